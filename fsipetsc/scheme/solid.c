/* Rates of the nodes of a solid block, without fluxes through its faces. fsipetsc.equations.solid
   has the equations, fsipetsc.operators.bands the weights S_il of pairs. With

       D_k f   = sum_l S_il (f_l - f_i) / (2 weight_i)     derivative along axis k
       D°_k f  = sum_l S_il (f_l + f_i) / (2 weight_i)     the same without flux through the ends

   and the tractions t^k = P A^k, the rates of displacement, velocity and energy are

       D_t = v,    J0 m0 v_t = sum_k D°_k t^k,
       J0 m0 e_t = v . sum_k D°_k t^k + sum_k t^k . D_k v.

   The power is, pair by pair, S_il (t_i . v_l + t_l . v_i)/2: nothing is lost or won.

   Tiles (fsipetsc.scheme.solid_work) are swept layer by layer. A layer is loaded, and its F and t^k
   are found, when rates that need them are next: few layers are at work at a time. Arrays keep as
   many layers as are needed, in a ring. What two tiles need is found twice by the same operations:
   rates do not depend on tiles, nor on how a block is cut. */

/* Boxes around a tile, in which rates, heats, F and t^k, unknowns are needed. */
enum { OWN, HEATED, STRAINED, KNOWN };
enum { PLAIN, FREE }; /* D_k, D°_k */

struct solid {
  /* (tiles, 4, 3, 2) first node and first beyond of OWN … KNOWN along each axis */
  const long *boxes;
  /* (3, nodes, most) of each axis and node how many neighbours it has, then how far they are;
     (2, 3, nodes, most) S_il/(2 weight_i) of these, PLAIN and FREE */
  const long *jumps;
  const double *weights;
  const long *ends;               /* (nodes,) along the first axis: the next node with others */
  /* of nodes of the interior, by axes and pairs: (2, layers, D PAIRS) how far the node ahead and
     that behind are in a tile, by the place of the layer in the ring; (D PAIRS) their weights */
  const long *far;
  const double *inner;
  long tiles, nodes, most;
  long size[2];                   /* of the patch: nodes with the halo */
  struct owned own[3], inside[3]; /* and its owned nodes; as free ones those with PAIRS pairs */
  long row, layer, layers, step;  /* of a tile: nodes of a row, of a layer; layers; of a plane */
  const double *p, *metrics, *prestress;
  long N, M; /* nodes of a plane of the unknowns, metrics and prestress; of owned ones */
  struct stage stage; /* what becomes of rates */
  double *unknowns, *strains, *tractions, *temperatures, *heats, *slopes;
};
/* n nodes from x, y, z on along the first axis. patch, own, tile: the place of the first one in
   arrays of the patch, of its owned nodes, of the tile; place: the layer of the tile's ring. */
struct row { long n, x, y, z, patch, own, tile, place; };

static const long *box_of(const struct solid *s, long tile, int stage, int axis) {
  return s->boxes + ((tile * 4 + stage) * 3 + axis) * 2;
}

static long own_of(const struct solid *s, long x, long y, long z) {
  const struct owned *own = s->own;
  return ((z - own[2].begin) * (own[1].end - own[1].begin) + y - own[1].begin) *
         (own[0].end - own[0].begin) + x - own[0].begin;
}

static struct row row_of(const struct solid *s, long tile, int stage, long y, long z) {
  const long *box = box_of(s, tile, stage, 0), x = box[0];
  const long x0 = box_of(s, tile, KNOWN, 0)[0], y0 = box_of(s, tile, KNOWN, 1)[0];
  const long place = z % s->layers;
  return (struct row){
      .n = box[1] - x, .x = x, .y = y, .z = z, .place = place,
      .patch = (z * s->size[1] + y) * s->size[0] + x,
      .own = own_of(s, x, y, z),
      .tile = place * s->layer + (y - y0) * s->row + x - x0,
  };
}

/* The part of a row of the nodes x … to - 1. */
static struct row part_of(struct row r, long x, long to) {
  const long on = x - r.x;
  r.x = x, r.n = to - x, r.patch += on, r.own += on, r.tile += on;
  return r;
}

/* Numbers between a node and a neighbour along an axis in the arrays of a tile. */
static long away(const struct solid *s, const struct row *r, int axis, long jump) {
  if (axis < 2) return axis == 0 ? jump : jump * s->row;
  const long there = r->place + jump;
  return (jump + (there < 0 ? s->layers : there < s->layers ? 0 : -s->layers)) * s->layer;
}

/* Let out be w0 a + w1 b + w2 c + w3 d, or add this to it if it is not the first. */
static NOINLINE void combine(double *restrict out, const double *w, const double *a,
                             const double *b, const double *c, const double *d, int first,
                             long n) {
  const double w0 = w[0], w1 = w[1], w2 = w[2], w3 = w[3];
  if (first) {
    #pragma omp simd
    for (long i = 0; i < n; ++i) out[i] = fma(w3, d[i], fma(w2, c[i], fma(w1, b[i], w0 * a[i])));
  } else {
    #pragma omp simd
    for (long i = 0; i < n; ++i) out[i] += fma(w3, d[i], fma(w2, c[i], fma(w1, b[i], w0 * a[i])));
  }
}

/* Store D_k f, or D°_k f if kind is FREE, for k = 1 … d in planes of slopes, from ``to`` on. Along
   axis k these are derivatives of count planes of f, from first + k next on. Nodes with the same
   neighbours are taken together: along the row those in the interior, across it all. */
static void differentiate(const struct solid *s, const struct row *r, int kind, const double *f,
                          long first, long next, long count, long to) {
  for (int k = 0; k < D; ++k) {
    const int axis = D == 2 ? 2 * k : k;
    for (long begin = 0, end; begin < r->n; begin = end) {
      const long x = axis == 0 ? r->x + begin : axis == 1 ? r->y : r->z;
      end = axis == 0 ? least(s->ends[x] - r->x, r->n) : r->n;
      const long *far = s->jumps + (axis * s->nodes + x) * s->most;
      const double *w = s->weights + ((kind * 3 + axis) * s->nodes + x) * s->most;
      for (long m = 1; m <= far[0]; m += 4) {
        for (long l = 0; l < count; ++l) {
          const double *here = f + (first + k * next + l) * s->step + r->tile + begin;
          combine(s->slopes + (to + k * count + l) * WIDTH + begin, w + m,
                  here + away(s, r, axis, far[m]), here + away(s, r, axis, far[m + 1]),
                  here + away(s, r, axis, far[m + 2]), here + away(s, r, axis, far[m + 3]),
                  m == 1, end - begin);
        }
      }
    }
  }
}

#define PLACED .metrics = s->metrics + r.patch, .N = s->N, .step = s->step, .p = s->p, .n = r.n
/* For each row of a box in a layer. */
#define ROWS_OF(stage) \
  for (long y = box_of(s, t, stage, 1)[0]; y < box_of(s, t, stage, 1)[1]; ++y)

/* The unknowns: planes of the owned nodes, or 0, and of all with the halo. */
struct unknowns { const double *own, *ghosted; };

static void take(const struct solid *s, const double *q, long nodes, struct row r) {
  if (r.n > 0)
    solid_take(.q = q, .unknowns = s->unknowns + r.tile, .step = s->step, .N = nodes, .n = r.n);
}

static void take_row(const struct solid *s, struct unknowns q, struct row r) {
  const struct owned *x = s->own, *y = s->own + 1, *z = s->own + 2;
  const int own = q.own && y->begin <= r.y && r.y < y->end && z->begin <= r.z && r.z < z->end;
  const long end = r.x + r.n;
  const struct range in = within(x->begin, x->end, (struct range){own ? r.x : end, end});
  const struct row before = part_of(r, r.x, in.begin), inside = part_of(r, in.begin, in.end);
  const struct row after = part_of(r, in.end, end);
  take(s, q.ghosted + before.patch, s->N, before);
  take(s, q.own + inside.own, s->M, inside);
  take(s, q.ghosted + after.patch, s->N, after);
}

/* Distances and weights of the pairs of the nodes of row r, if these are in the interior. */
#define NEAR                                                                              \
  .far = s->far + r.place * D * PAIRS, .back = s->far + (s->layers + r.place) * D * PAIRS, \
  .w = s->inner

/* Call a function for the nodes of a row: those before, within and after the interior. */
typedef void of_nodes(const struct solid *, double *, struct row, int inside, int kind);
static void along_row(const struct solid *s, double *next, struct row r, int kind, of_nodes *does) {
  const struct owned *x = s->inside, *y = s->inside + 1, *z = s->inside + 2;
  const long end = r.x + r.n;
  const int may_be = (D < 3 || is_free(y, r.y)) && (D < 2 || is_free(z, r.z));
  const struct range of = {may_be ? r.x : end, end}, in = within(x->free_begin, x->free_end, of);
  if (r.x < in.begin) does(s, next, part_of(r, r.x, in.begin), 0, kind);
  if (in.begin < in.end) does(s, next, part_of(r, in.begin, in.end), 1, kind);
  if (in.end < end) does(s, next, part_of(r, in.end, end), 0, kind);
}

static void strain_row(const struct solid *s, struct row r) {
  differentiate(s, &r, PLAIN, s->unknowns, 0, 0, D, 0);
  solid_strain(.slopes = s->slopes, .strains = s->strains + r.tile, PLACED
#if HOOPS
               , .unknowns = s->unknowns + r.tile
#endif
  );
}

static void pull_nodes(const struct solid *s, double *next, struct row r, int inside, int kind) {
  (void)next, (void)kind;
#if PRESTRESSED
#define PULLED , .prestress = s->prestress + r.patch
#else
#define PULLED
#endif
#define PULL                                                                            \
  .unknowns = s->unknowns + r.tile, .strains = s->strains + r.tile,                     \
  .temperatures = s->temperatures + r.tile, .tractions = s->tractions + r.tile, PLACED PULLED
  if (inside) {
    solid_pull_inside(PULL, NEAR);
  } else {
    differentiate(s, &r, PLAIN, s->unknowns, 0, 0, D, 0);
    solid_pull(PULL, .slopes = s->slopes);
  }
}

#if CONDUCTS
static void conduct_row(const struct solid *s, struct row r) {
  differentiate(s, &r, PLAIN, s->temperatures, 0, 0, 1, 0);
  solid_conduct(.slopes = s->slopes, .strains = s->strains + r.tile, .heats = s->heats + r.tile,
                PLACED);
}
#endif

/* Store what becomes of the rates of nodes. */
static void accelerate_nodes(const struct solid *s, double *next, struct row r, int inside,
                             int kind) {
  const struct stage *stage = &s->stage;
  if (!inside) {
    differentiate(s, &r, FREE, s->tractions, 0, D, D, 0);
    differentiate(s, &r, PLAIN, s->unknowns, D, 0, D, D * D);
#if CONDUCTS
    differentiate(s, &r, FREE, s->heats, 0, 1, 1, 2 * D * D);
#endif
  }
#define STORE                                                                        \
  .unknowns = s->unknowns + r.tile, .tractions = s->tractions + r.tile,              \
  .strains = s->strains + r.tile, .heats = s->heats + r.tile, PLACED, .M = s->M,     \
  .next = next + r.own, STAGES(r.own)
#define CASE(number, name)                    \
  case number:                                \
    if (inside)                               \
      solid_##name##_inside(STORE, NEAR);     \
    else                                      \
      solid_##name(STORE, .slopes = s->slopes); \
    break
  switch (kind) {
    CASE(RATES, rates);
    CASE(NEXT, next);
    CASE(LAST, last);
  }
}

/* Store rates of a row of nodes, but the next stage of those to whose rates nothing is added. */
static void accelerate_row(const struct solid *s, double *next, struct row r) {
  const struct owned *first = s->own;
  const int kind = (int)*s->stage.numbers;
  const int free = kind != RATES && is_free(s->own + 1, r.y) && is_free(s->own + 2, r.z);
  const long end = r.x + r.n;
  const struct range of = {free ? r.x : end, end};
  const struct range in = within(first->free_begin, first->free_end, of);
  along_row(s, next, part_of(r, r.x, in.begin), RATES, accelerate_nodes);
  along_row(s, next, part_of(r, in.begin, in.end), kind, accelerate_nodes);
  along_row(s, next, part_of(r, in.end, end), RATES, accelerate_nodes);
}

/* A tile, and the layers of it that are next: to be loaded, to get t^k, to get heats. */
struct progress { struct unknowns q; long tile, load, pull, heat; };

static struct progress begin(const struct solid *s, struct unknowns q, long t) {
  return (struct progress){q, t, box_of(s, t, KNOWN, 2)[0], box_of(s, t, STRAINED, 2)[0],
                           box_of(s, t, HEATED, 2)[0]};
}

/* The last layer that derivatives in a layer take. */
static long last_of(const struct solid *s, long z) {
  const long *far = s->jumps + (2 * s->nodes + z) * s->most;
  long last = z;
  for (long m = 1; m <= far[0]; ++m) last = most(last, z + far[m]);
  return last;
}

/* Load what derivatives in a layer take. */
static void load_for(const struct solid *s, struct progress *of, long z) {
  const long t = of->tile, end = least(last_of(s, z) + 1, box_of(s, t, KNOWN, 2)[1]);
  for (; of->load < end; ++of->load)
    ROWS_OF(KNOWN) take_row(s, of->q, row_of(s, t, KNOWN, y, of->load));
}

/* Find the t^k that derivatives in a layer take. */
static void pull_for(const struct solid *s, struct progress *of, long z) {
  const long t = of->tile, end = least(last_of(s, z) + 1, box_of(s, t, STRAINED, 2)[1]);
  for (; of->pull < end; ++of->pull) {
    load_for(s, of, of->pull);
    ROWS_OF(STRAINED) along_row(s, 0, row_of(s, t, STRAINED, y, of->pull), RATES, pull_nodes);
  }
}

/* Find the heats that derivatives in a layer take. */
static void heat_for(const struct solid *s, struct progress *of, long z) {
#if CONDUCTS
  const long t = of->tile, end = least(last_of(s, z) + 1, box_of(s, t, HEATED, 2)[1]);
  for (; of->heat < end; ++of->heat) {
    pull_for(s, of, of->heat);
    ROWS_OF(HEATED) conduct_row(s, row_of(s, t, HEATED, y, of->heat));
  }
#else
  (void)s, (void)of, (void)z;
#endif
}

/* Fill planes of the strains F of the owned nodes; own, ghosted: unknowns of these, or 0, and of a
   halo of one reach, or of all nodes. */
void solid_strains(const struct solid *s, const double *own, const double *ghosted, double *F) {
  for (long t = 0; t < s->tiles; ++t) {
    struct progress of = begin(s, (struct unknowns){own, ghosted}, t);
    for (long z = box_of(s, t, OWN, 2)[0]; z < box_of(s, t, OWN, 2)[1]; ++z) {
      load_for(s, &of, z);
      ROWS_OF(OWN) {
        const struct row r = row_of(s, t, OWN, y, z);
        strain_row(s, r);
        for (int c = 0; c < D * D + HOOPS; ++c)
          memcpy(F + c * s->M + r.own, s->strains + c * s->step + r.tile, r.n * sizeof *F);
      }
    }
  }
}

/* Fill the rates of the owned nodes, or what becomes of them; own, ghosted: unknowns of these, and
   of a halo of two interior reaches, with conduction of three. */
void solid_sweep(const struct solid *s, const double *own, const double *ghosted, double *next) {
  for (long t = 0; t < s->tiles; ++t) {
    struct progress of = begin(s, (struct unknowns){own, ghosted}, t);
    for (long z = box_of(s, t, OWN, 2)[0]; z < box_of(s, t, OWN, 2)[1]; ++z) {
      heat_for(s, &of, z);
      pull_for(s, &of, z);
      ROWS_OF(OWN) accelerate_row(s, next, row_of(s, t, OWN, y, z));
    }
  }
}
