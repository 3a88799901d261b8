/* Metrics of a moving grid in three dimensions: area vectors a^1, a^2, a^3 in curl form with
   sum_k D_k a^k = 0.

       (a^i)_n = D_j q_k - D_k q_j,   q_k = 1/2 (x_m D_k x_l - x_l D_k x_m)

   with (i, j, k) and (n, m, l) cyclic (Thomas and Lombard, AIAA J. 17 (1979) 1030-1037). With x = y
   + sum_k xi_k P_k, P_k the period of axis k or 0, by the product rule,

       q_k = 1/2 (y_m D_k y_l - y_l D_k y_m) + y_m P_kl - y_l P_km,
       (a^i)_n += P_jm P_kl - P_km P_jl.

   D of a node comes from differences of pairs of nodes, in an order that is its own mirror image
   and without fused multiplications: blocks that share a face get the same bits for what lies
   within it, whichever way their axes run. D is taken of a row at a time, which stays in fast
   memory. */

#define INLINE static inline __attribute__((always_inline))
#define MOST_PAIRS 7

/* The pairs of a node on both sides, nearest first: how far the others are, and their weights. Even
   ones have both nodes, with one weight. The others are as many as there is room for; what is not
   there has the weight 0. */
struct pairs {
  long count, even, before[MOST_PAIRS], after[MOST_PAIRS];
  double behind[MOST_PAIRS], ahead[MOST_PAIRS];
};

struct cube {
  const struct pairs *pairs[3]; /* of the nodes of the axes */
  long reach[3], size[3];       /* size: of the wide range, all nodes that derivatives need */
  long first[3], end[3];        /* the range itself in it */
  long inner[2];                /* nodes along the first axis that have the same pairs */
  const double *P;              /* (3, 3) periods: P_kc */
  const double *x, *v;          /* (3, wide nodes) the y above, called x below; velocities */
  double *q;                    /* (3, 3, slots layers) q_k, by k and n; z is in slot z % slots */
  double *metrics, *volume;     /* planes of N nodes of the range; det D x */
  const long *faces;            /* (count, 2) some faces: axis i, index of their nodes along it */
  double *turning;              /* (9, N) how a^i changes in time on these faces */
  double *moved, *other, *rows; /* memory: (3, wide nodes), (9, N), (9, nodes of a row) */
  long N, count, slots, only;   /* only: i of the a^i that is wanted, or ALL */
};
struct box {
  long lo[3], hi[3];
};

static long wide_of(const struct cube *c, long x, long y, long z) {
  return x + c->size[0] * (y + c->size[1] * z);
}
/* A node of the wide range in planes of the range. */
static long place_of(const struct cube *c, long x, long y, long z) {
  const long row = y - c->first[1] + (c->end[1] - c->first[1]) * (z - c->first[2]);
  return x - c->first[0] + (c->end[0] - c->first[0]) * row;
}
static long wide_nodes(const struct cube *c) { return c->size[0] * c->size[1] * c->size[2]; }
static long q_nodes(const struct cube *c) { return c->size[0] * c->size[1] * c->slots; }

/* What a pair adds to D f of a node. */
INLINE double of_pair(const double *f, const struct pairs *p, int m, int even) {
  if (even) return p->ahead[m] * (f[p->after[m]] - f[-p->before[m]]);
  return p->ahead[m] * (f[p->after[m]] - *f) + p->behind[m] * (*f - f[-p->before[m]]);
}
/* D f of n nodes with the same pairs. */
INLINE void slopes_with(const struct pairs *p, const double *f, double *restrict out, long n,
                          int count, int even) {
  ITEMS("omp simd",
    double sum = of_pair(f + i, p, 0, even);
    for (int m = 1; m < count; ++m) sum += of_pair(f + i, p, m, even);
    out[i] = sum;
  )
}
static NOINLINE void slopes_of(const struct pairs *p, const double *f, double *out, long n) {
  switch (p->even ? p->count : 0) {
    case 1: return slopes_with(p, f, out, n, 1, 1);
    case 2: return slopes_with(p, f, out, n, 2, 1);
    case 3: return slopes_with(p, f, out, n, 3, 1);
    case 4: return slopes_with(p, f, out, n, 4, 1);
  }
  if (p->count <= 3) return slopes_with(p, f, out, n, 3, 0);
  slopes_with(p, f, out, n, MOST_PAIRS, 0);
}

/* A row of n nodes, and its pairs along the three axes, of the first node along axis 0. */
struct line {
  long x, n;
  const struct pairs *pairs[3];
};

/* D_axis f of a row. */
static void slopes(const struct cube *c, const struct line *r, int axis, const double *f,
                   double *out) {
  if (axis != 0) return slopes_of(r->pairs[axis], f, out, r->n);
  for (long i = 0, stop; i < r->n; i = stop) {
    const long x = r->x + i, inside = c->inner[0] <= x && x < c->inner[1];
    stop = inside ? least(c->inner[1] - r->x, r->n) : i + 1;
    slopes_of(r->pairs[0] + i, f + i, out + i, stop - i);
  }
}
static struct line line_at(const struct cube *c, const struct box *b, long y, long z) {
  const long x = b->lo[0];
  return (struct line){x, b->hi[0] - x, {c->pairs[0] + x, c->pairs[1] + y, c->pairs[2] + z}};
}

/* The pairs p along the last axis of a node of layer z, between its slots of q. */
static struct pairs between_slots(const struct cube *c, const struct pairs *p, long z) {
  const long layer = c->size[0] * c->size[1], here = z % c->slots;
  struct pairs found = *p;
  for (long m = 0; m < p->count; ++m) {
    found.after[m] = ((z + p->after[m] / layer) % c->slots - here) * layer;
    found.before[m] = (here - (z - p->before[m] / layer) % c->slots) * layer;
  }
  return found;
}

/* Fill q_k of the places x in the rows of a layer of a box. */
static void find_potential(const struct cube *c, const double *x, int k, const struct box *b,
                           long z) {
  const long W = wide_nodes(c), Q = q_nodes(c), length = c->size[0];
  const double P0 = c->P[3 * k], P1 = c->P[3 * k + 1], P2 = c->P[3 * k + 2];
  double *D_a = c->rows, *D_b = D_a + length, *D_e = D_b + length;
  for (long y = b->lo[1]; y < b->hi[1]; ++y) {
    const struct line r = line_at(c, b, y, z);
    const double *row = x + wide_of(c, r.x, y, z);
    double *restrict q = c->q + 3 * k * Q + wide_of(c, r.x, y, z % c->slots);
    for (int m = 0; m < 3; ++m) slopes(c, &r, k, row + m * W, D_a + m * length);
    const long n = r.n;
    ITEMS("omp simd",
      const double a = row[i]; const double e = row[2 * W + i]; const double f = row[W + i];
      q[i] = 0.5 * (f * D_e[i] - e * D_b[i]) + (f * P2 - e * P1);
      q[Q + i] = 0.5 * (e * D_a[i] - a * D_e[i]) + (e * P0 - a * P2);
      q[2 * Q + i] = 0.5 * (a * D_b[i] - f * D_a[i]) + (a * P1 - f * P0);
    )
  }
}

/* Fill planes a with a^i = D_j q_k - D_k q_j and what periods add, in a layer of a box. */
static void find_area(const struct cube *c, int axis, double *a, const struct box *b, long z) {
  const long j = (axis + 1) % 3, k = (axis + 2) % 3, Q = q_nodes(c), N = c->N;
  const double *P_j = c->P + 3 * j, *P_k = c->P + 3 * k;
  const double more[3] = {P_j[1] * P_k[2] - P_k[1] * P_j[2], P_j[2] * P_k[0] - P_k[2] * P_j[0],
                          P_j[0] * P_k[1] - P_k[0] * P_j[1]};
  const struct pairs slots = between_slots(c, c->pairs[2] + z, z);
  double *D_j = c->rows, *D_k = c->rows + c->size[0];
  for (long y = b->lo[1]; y < b->hi[1]; ++y) {
    struct line r = line_at(c, b, y, z);
    const double *q = c->q + wide_of(c, r.x, y, z % c->slots);
    const long n = r.n;
    r.pairs[2] = &slots;
    for (int m = 0; m < 3; ++m) {
      double *restrict out = a + m * N + place_of(c, r.x, y, z);
      slopes(c, &r, j, q + (3 * k + m) * Q, D_j);
      slopes(c, &r, k, q + (3 * j + m) * Q, D_k);
      ITEMS("omp simd", out[i] = (D_j[i] - D_k[i]) + more[m];)
    }
  }
}

/* A box with the nodes that derivatives along all axes but one reach. */
static struct box reached(const struct cube *c, const struct box *b, int but) {
  struct box found = *b;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis == but) continue;
    found.lo[axis] = most(b->lo[axis] - c->reach[axis], 0);
    found.hi[axis] = least(b->hi[axis] + c->reach[axis], c->size[axis]);
  }
  return found;
}

/* Fill planes a with a^1, a^2 and a^3 of the places x in a box, or with a^only alone if that is not
   ALL: layer by layer, q_k as far ahead as it is needed. */
enum { ALL = 3 };
static void find_areas(const struct cube *c, const double *x, double *a, const struct box *b,
                       int only) {
  const struct box of_q = reached(c, b, only);
  long found = of_q.lo[2];
  for (long z = b->lo[2]; z < b->hi[2]; ++z) {
    for (; found <= z + c->reach[2] && found < of_q.hi[2]; ++found)
      for (int k = 0; k < 3; ++k)
        if (k != only) find_potential(c, x, k, &of_q, found);
    for (int i = 0; i < 3; ++i)
      if (only == ALL || only == i) find_area(c, i, a + 3 * i * c->N, b, z);
  }
}
static struct box range_of(const struct cube *c) {
  return (struct box){{c->first[0], c->first[1], c->first[2]}, {c->end[0], c->end[1], c->end[2]}};
}

/* Find a^1, a^2 and a^3 of the range, or the one of them that is wanted. */
void cube_move(const struct cube *c) {
  const struct box range = range_of(c);
  find_areas(c, c->x, c->metrics, &range, (int)c->only);
}

/* Find det D x of the range. */
void cube_volumes(const struct cube *c) {
  const struct box range = range_of(c);
  const long W = wide_nodes(c), length = c->size[0];
  for (long z = c->first[2]; z < c->end[2]; ++z)
    for (long y = c->first[1]; y < c->end[1]; ++y) {
      const struct line r = line_at(c, &range, y, z);
      double *volume = c->volume + place_of(c, r.x, y, z), G[9];
      for (int m = 0; m < 9; ++m)
        slopes(c, &r, m / 3, c->x + m % 3 * W + wide_of(c, r.x, y, z), c->rows + m * length);
      for (long i = 0; i < r.n; ++i) {
        for (int m = 0; m < 9; ++m) G[m] = c->rows[m * length + i] + c->P[m];
        volume[i] = G[0] * (G[4] * G[8] - G[5] * G[7]) + G[1] * (G[5] * G[6] - G[3] * G[8]) +
                    G[2] * (G[3] * G[7] - G[4] * G[6]);
      }
    }
}

/* x + sign v of a face of axis i with the nodes that its derivatives reach. */
static const double *places(const struct cube *c, double sign, const struct box *face, int i) {
  const struct box b = reached(c, face, i);
  const long n = b.hi[0] - b.lo[0];
  for (long z = b.lo[2]; z < b.hi[2]; ++z)
    for (long y = b.lo[1]; y < b.hi[1]; ++y)
      for (int m = 0; m < 3; ++m) {
        const long at = m * wide_nodes(c) + wide_of(c, b.lo[0], y, z);
        for (long p = at; p < at + n; ++p) c->moved[p] = c->x[p] + sign * c->v[p];
      }
  return c->moved;
}

/* Find how a^i changes in time on the faces: it is bilinear in the places, so half the difference
   of those of x + v and x - v. */
void cube_turn(const struct cube *c) {
  for (long face = 0; face < c->count; ++face) {
    const int i = (int)c->faces[2 * face];
    struct box b = range_of(c);
    b.lo[i] = c->first[i] + c->faces[2 * face + 1];
    b.hi[i] = b.lo[i] + 1;
    find_areas(c, places(c, 1.0, &b, i), c->turning, &b, i);
    find_areas(c, places(c, -1.0, &b, i), c->other, &b, i);
    for (long z = b.lo[2]; z < b.hi[2]; ++z)
      for (long y = b.lo[1]; y < b.hi[1]; ++y)
        for (int m = 3 * i; m < 3 * i + 3; ++m) {
          const long at = m * c->N + place_of(c, b.lo[0], y, z);
          for (long p = at; p < at + b.hi[0] - b.lo[0]; ++p)
            c->turning[p] = 0.5 * (c->turning[p] - c->other[p]);
        }
  }
}
