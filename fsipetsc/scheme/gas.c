/* Rates of a block of gas, without fluxes through its faces:

       weight_i (J U)_t,i = - sum_k sum_l S_il (F^k(i, l) - {a^k . f_v})

   and a constant force, which is summed pair by pair like the fluxes. On a grid that moves J has
   the flux of U = 1; of a node at the end of an axis a^k . v is still to be added (fsipetsc.scheme.
   gas_record). The weight of a node
   is the product of those along all axes; S_il of a pair along axis k is that of
   fsipetsc.operators.bands times the weights along the other axes. The fluxes are those of
   fsipetsc.equations.gas, in the kernels of fsipetsc.scheme.gas_kernels.

   Nodes are swept in tiles. A tile is a range along the first axis and a few rows along the second
   one of three. It is swept layer by layer along the last axis, so that its rows stay in the
   fastest memory. The flux of a pair is computed once and added to both of its nodes. The sum of
   the lower node belongs to the row at work; that of the upper node waits in a row of its own. The
   fluxes reach a node in an order that does not depend on how a block is cut, so neither do the
   bits of its rate. */

enum {
  W = D + 5 + VISCOUS,                  /* primitive variables of a node, and J */
  FLUXES = D + 2 + (FORCE ? D : 0) + MOVES, /* what is summed of a node */
  SLOPES = D * (D + 1),                 /* D_k z of all axes; viscous fluxes of all axes */
  NUMBERS = W + (VISCOUS ? SLOPES : 0), /* what is kept of a node */
};

struct tile;
struct axis { /* of a patch: its band; its owned nodes, of size with the halo */
  const double *S, *weight;
  struct owned own;
  long reach, size, stride;
};
struct gas {
  struct axis first, inner, last; /* the contiguous axis, the second of three, that of the sweep */
  const double *p, *metrics;      /* parameters of the kernels; planes of N numbers */
  const double *potential;        /* of a constant force (fsipetsc.scheme.gas_force) */
  double *supplied;               /* that force on the owned nodes, over their weights */
  struct stage stage;             /* what becomes of rates */
  long N;                         /* nodes of a plane */
  long layers, depth, before;     /* layers of depth rows are kept, with rows before the tile's */
  double *rows, *high;            /* of these rows: NUMBERS; sums of upper nodes of pairs */
  double *low, *slope;            /* of the row at work: sums of lower nodes of pairs; D_k z */
  const double *along;            /* (1 + reach) rows: S of pairs along the first axis, by distance
                                     and lower node, between MARGIN zeros on both sides */
  const double *per_weight;       /* 1 over the weights along the first axis */
  const double *gain, *loss;      /* of viscous gases: as along, over the weight of the upper,
                                     of the lower node */
  double *gains, *losses;         /* the same along another axis, one for all nodes of a row */
  const struct tile *tiles;
  long count;
};
/* Pairs along a row: their lower nodes are begin … end - 1. */
struct span { long distance, begin, end; };
/* Nodes x0 … x1 - 1 along the first axis, y0 … y1 - 1 along the inner one. */
struct tile {
  long x0, x1, y0, y1, count;
  struct span spans[SPANS];
};

static long number_of(const struct gas *g, const struct tile *t, long layer, long j) {
  return layer % g->layers * g->depth + j - t->y0 + g->before;
}
static double *row_of(const struct gas *g, const struct tile *t, long layer, long j) {
  return g->rows + number_of(g, t, layer, j) * NUMBERS * ROW + MARGIN - t->x0;
}
static double *high_of(const struct gas *g, const struct tile *t, long layer, long j) {
  return g->high + number_of(g, t, layer, j) * FLUXES * ROW + MARGIN - t->x0;
}
static long node_of(const struct gas *g, long x, long j, long layer) {
  return x + j * g->inner.stride + layer * g->last.stride;
}

static long count_of(const struct owned *o) { return o->end - o->begin; }
static long own_nodes(const struct gas *g) {
  return count_of(&g->first.own) * count_of(&g->inner.own) * count_of(&g->last.own);
}
static long own_of(const struct gas *g, long x, long j, long layer) {
  const struct owned *first = &g->first.own, *inner = &g->inner.own, *last = &g->last.own;
  return ((layer - last->begin) * count_of(inner) + j - inner->begin) * count_of(first) + x -
         first->begin;
}

static void clear_row(double *row, long components, long n) {
  for (long c = 0; c < components; ++c) memset(row + c * ROW, 0, n * sizeof *row);
}

/* Where the weights of pairs of distance k begin whose lower node is x. */
static long weight_of(const struct gas *g, long k, long x) {
  return k * (g->first.size + 2 * MARGIN) + MARGIN + x;
}

/* The unknowns: planes of the owned nodes, and of all with the halo. */
struct unknowns { const double *own, *ghosted; };

/* Find the primitive variables of a row, those of owned nodes from these. */
static void load_row(const struct gas *g, struct unknowns q, double *row, long x0, long x1, long j,
                     long layer) {
  const struct owned *x = &g->first.own, *y = &g->inner.own, *z = &g->last.own;
  const int own = y->begin <= j && j < y->end && z->begin <= layer && layer < z->end;
  const struct range in = within(x->begin, x->end, (struct range){own ? x0 : x1, x1});
  const long a = in.begin, b = in.end;
#define LOAD(of, from, to, nodes) \
  if ((from) < (to)) gas_load(.q = of, .w = row + (from), .p = g->p, .n = (to) - (from), .N = nodes)
  LOAD(q.ghosted + node_of(g, x0, j, layer), x0, a, g->N);
  LOAD(q.own + own_of(g, a, j, layer), a, b, own_nodes(g));
  LOAD(q.ghosted + node_of(g, b, j, layer), b, x1, g->N);
}

/* Find the primitive variables of all rows of a layer that the tile reads; clear their sums. */
static void load_layer(const struct gas *g, struct unknowns q, const struct tile *t, long layer) {
  const struct axis *last = &g->last, *inner = &g->inner;
  const long far = 1 + VISCOUS, around = VISCOUS * last->reach, beside = VISCOUS * inner->reach;
  const int within = last->own.begin - around <= layer && layer < last->own.end + around;
  const long more = within ? far * inner->reach : 0;
  for (long j = most(t->y0 - more, 0); j < least(t->y1 + more, inner->size); ++j) {
    const int whole = within && t->y0 - beside <= j && j < t->y1 + beside;
    const long longer = whole ? far * g->first.reach : 0;
    const long x0 = most(t->x0 - longer, 0), x1 = least(t->x1 + longer, g->first.size);
    load_row(g, q, row_of(g, t, layer, j), x0, x1, j, layer);
    clear_row(high_of(g, t, layer, j) + t->x0, FLUXES, t->x1 - t->x0);
  }
}

#if VISCOUS
static void fill_row(double *row, double value, long n) {
  for (long i = 0; i < n; ++i) row[i] = value;
}

/* Find D_k z of a row for each axis k. */
static void slopes_of_row(const struct gas *g, const struct tile *t, long layer, long j, long x0,
                          long n) {
  double *here = row_of(g, t, layer, j) + x0, *slope = g->slope + MARGIN - t->x0 + x0;
  clear_row(slope, SLOPES, n);
  for (long k = 1; k <= g->first.reach; ++k) {
    gas_slope(.below = here - k, .here = here, .above = here + k, .p = g->p, .n = n,
              .before = g->gain + weight_of(g, k, x0 - k), .after = g->loss + weight_of(g, k, x0),
              .slope = slope);
  }
  for (int m = 1; m < D; ++m) {
    const int sweep = m == D - 1;
    const struct axis *axis = sweep ? &g->last : &g->inner;
    const long i = sweep ? layer : j;
    for (long k = 1; k <= axis->reach; ++k) {
      const double *S = axis->S + k * axis->size;
      const double before = i >= k ? S[i - k] / axis->weight[i] : 0.0;
      const double after = i + k < axis->size ? S[i] / axis->weight[i] : 0.0;
      if (before == 0.0 && after == 0.0) continue;
      const long back = before != 0.0 ? k : 0, on = after != 0.0 ? k : 0;
      fill_row(g->gains, before, n);
      fill_row(g->losses, after, n);
      gas_slope(.below = row_of(g, t, layer - back * sweep, j - back * !sweep) + x0, .here = here,
                .above = row_of(g, t, layer + on * sweep, j + on * !sweep) + x0,
                .before = g->gains, .after = g->losses,
                .slope = slope + m * (D + 1) * ROW, .p = g->p, .n = n);
    }
  }
}

/* Find the viscous fluxes of the rows of a layer that pairs with owned nodes take. */
static void viscous_layer(const struct gas *g, const struct tile *t, long layer) {
  const int owned = g->last.own.begin <= layer && layer < g->last.own.end;
  const long beside = owned ? g->inner.reach : 0;
  for (long j = most(t->y0 - beside, 0); j < least(t->y1 + beside, g->inner.size); ++j) {
    const long longer = owned && t->y0 <= j && j < t->y1 ? g->first.reach : 0;
    const long x0 = most(t->x0 - longer, 0), n = least(t->x1 + longer, g->first.size) - x0;
    const long node = node_of(g, x0, j, layer);
    double *row = row_of(g, t, layer, j) + x0;
    slopes_of_row(g, t, layer, j, x0, n);
    gas_viscous(.w = row, .a = g->metrics + node, .s = row + W * ROW,
                .slope = g->slope + MARGIN - t->x0 + x0, .p = g->p, .n = n, .N = g->N);
  }
}
#endif

/* Add the fluxes of n pairs of nodes along axis k, whose lower nodes are side by side. */
static void add_pairs(const struct gas *g, int k, const double *l, const double *r, long node_l,
                      long node_r, double of_row, const double *of_node, double *low, double *high,
                      long n) {
  const double *areas = g->metrics + k * D * g->N;
  const long viscous = (W + k * (D + 1)) * ROW;
  (void)viscous;
#define PAIR .l = l, .r = r, .a_l = areas + node_l, .a_r = areas + node_r, .p = g->p, .n = n, \
             .N = g->N, \
             .of_row = &of_row, .of_node = of_node, .low = low, .high = high
#if MOVES
  const double *velocity = g->metrics + D * D * g->N;
#define MOVED , .v_l = velocity + node_l, .v_r = velocity + node_r
#else
#define MOVED
#endif
#if VISCOUS
#define STRESS , .s_l = l + viscous, .s_r = r + viscous
#else
#define STRESS
#endif
#if FORCE
#define RAISED , .potential_l = g->potential + node_l, .potential_r = g->potential + node_r
#else
#define RAISED
#endif
#if TELLS_FAR
  if (gas_near(PAIR MOVED RAISED STRESS)) gas_far(PAIR MOVED RAISED STRESS);
#else
  gas_near(PAIR MOVED RAISED STRESS);
#endif
}

/* Add the pairs of row j of a layer with rows farther on: of other layers if it is a sweep, else of
   the same layer. */
static void pairs_across(const struct gas *g, const struct tile *t, long layer, long j, int sweep) {
  const struct axis *axis = sweep ? &g->last : &g->inner;
  const long i = sweep ? layer : j, n = t->x1 - t->x0, node = node_of(g, t->x0, j, layer);
  for (long k = 1; k <= axis->reach && i + k < axis->size; ++k) {
    const double s = axis->S[k * axis->size + i];
    if (s == 0.0 || i + k < axis->own.begin) continue;
    const double beside = sweep ? g->inner.weight[j] : g->last.weight[layer];
    const long to = layer + k * sweep, at = j + k * !sweep;
    add_pairs(g, sweep ? D - 1 : 1, row_of(g, t, layer, j) + t->x0, row_of(g, t, to, at) + t->x0,
              node, node + k * axis->stride, s * beside, g->first.weight + t->x0, g->low + MARGIN,
              high_of(g, t, to, at) + t->x0, n);
  }
}

/* Add the pairs along row j of a layer. */
static void pairs_along(const struct gas *g, const struct tile *t, long layer, long j) {
  double *row = row_of(g, t, layer, j), *high = high_of(g, t, layer, j);
  double *low = g->low + MARGIN - t->x0;
  const double of_row = g->inner.weight[j] * g->last.weight[layer];
  for (long m = 0; m < t->count; ++m) {
    const long k = t->spans[m].distance, a = t->spans[m].begin, b = t->spans[m].end;
    const long node = node_of(g, a, j, layer);
    add_pairs(g, 0, row + a, row + a + k, node, node + k, of_row, g->along + weight_of(g, k, a),
              low + a, high + a + k, b - a);
  }
}

/* Store what becomes of the rates of nodes x0 … x1 - 1 of row j of a layer. */
static void store_nodes(const struct gas *g, double *next, const struct tile *t, long layer, long j,
                        long x0, long x1, int kind) {
  const long own = own_of(g, x0, j, layer);
  const struct stage *stage = &g->stage;
  const double of_row = 1.0 / (g->inner.weight[j] * g->last.weight[layer]);
  if (x0 >= x1) return;
#define SUMS .of_row = &of_row, .of_node = g->per_weight + x0, \
             .low = g->low + MARGIN - t->x0 + x0, .high = high_of(g, t, layer, j) + x0, \
             .n = x1 - x0
#define BECOMES .next = next + own, .M = own_nodes(g), STAGES(own)
#if FORCE
  (void)kind;
  gas_rates(SUMS, BECOMES, .supplied = g->supplied + own * (D + 1));
#else
  switch (kind) {
    case RATES: gas_rates(SUMS, BECOMES); break;
    case NEXT: gas_next(SUMS, BECOMES); break;
    case LAST: gas_last(SUMS, BECOMES); break;
  }
#endif
}

/* Store the rates of row j of a layer and, of nodes that nothing else adds to, the next stage. */
static void store_row(const struct gas *g, double *next, const struct tile *t, long layer, long j) {
  const struct owned *first = &g->first.own;
  const int kind = (int)*g->stage.numbers;
  const int free = kind != RATES && is_free(&g->inner.own, j) && is_free(&g->last.own, layer);
  const struct range of = {free ? t->x0 : t->x1, t->x1};
  const struct range in = within(first->free_begin, first->free_end, of);
  store_nodes(g, next, t, layer, j, t->x0, in.begin, RATES);
  store_nodes(g, next, t, layer, j, in.begin, in.end, kind);
  store_nodes(g, next, t, layer, j, in.end, t->x1, RATES);
}

/* Add the fluxes of the pairs that begin in a layer, and store its rates if it is owned. */
static void sweep_layer(const struct gas *g, double *next, const struct tile *t, long layer) {
  const struct axis *inner = &g->inner;
  const int owned = layer >= g->last.own.begin;
  for (long j = owned ? most(t->y0 - inner->reach, 0) : t->y0; j < t->y1; ++j) {
    clear_row(g->low + MARGIN, FLUXES, t->x1 - t->x0);
    if (owned && D == 3) pairs_across(g, t, layer, j, 0);
    if (j < t->y0) continue;
    if (D > 1) pairs_across(g, t, layer, j, 1);
    if (!owned) continue;
    pairs_along(g, t, layer, j);
    store_row(g, next, t, layer, j);
  }
}

/* How far the last layer is that pairs take which begin in a layer. */
static long ahead_of(const struct axis *axis, long layer) {
  long k = axis->reach;
  while (k > 0 && axis->S[k * axis->size + layer] == 0.0) --k;
  return k;
}

/* Find the rates of a tile. Layers are loaded ahead of those whose viscous fluxes are found, and
   these ahead of those whose rates are found, no earlier than they are needed: few rows are at work
   at a time, and fit into the fastest memory. */
static void sweep(const struct gas *g, struct unknowns q, double *next, const struct tile *t) {
  const struct axis *last = &g->last;
  long completed = most(last->own.begin - last->reach, 0);
  long loaded = most(completed - VISCOUS * last->reach, 0);
  for (long layer = completed; layer < last->own.end; ++layer) {
    for (; completed <= layer + ahead_of(last, layer) && completed < last->size; ++completed) {
      const long far = completed + VISCOUS * ahead_of(last, completed);
      for (; loaded <= far && loaded < last->size; ++loaded) load_layer(g, q, t, loaded);
#if VISCOUS
      viscous_layer(g, t, completed);
#endif
    }
    sweep_layer(g, next, t, layer);
  }
}

/* Fill the rates of the owned nodes, or what becomes of them; own, ghosted: unknowns of these, and
   of a halo. */
void gas_sweep(const struct gas *g, const double *own, const double *ghosted, double *next) {
  for (long m = 0; m < g->count; ++m)
    sweep(g, (struct unknowns){own, ghosted}, next, g->tiles + m);
}
