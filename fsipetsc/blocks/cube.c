/* Metrics of a moving grid in three dimensions: area vectors a^1, a^2, a^3 in curl form with
   sum_k D_k a^k = 0.

       (a^i)_n = D_j q_k - D_k q_j,   q_k = 1/2 (x_m D_k x_l - x_l D_k x_m)

   with (i, j, k) and (n, m, l) cyclic (Thomas and Lombard, AIAA J. 17 (1979) 1030-1037). With x = y
   + sum_k xi_k P_k, P_k the period of axis k or 0, by the product rule,

       q_k = 1/2 (y_m D_k y_l - y_l D_k y_m) + y_m P_kl - y_l P_km,
       (a^i)_n += P_jm P_kl - P_km P_jl.

   D of a node comes from differences of pairs of nodes, in an order that is its own mirror image
   and without fused multiplications: blocks that share a face get the same bits for what lies
   within it, whichever way their axes run. */

#define MOST_PAIRS 7

/* The pairs of a node on both sides, nearest first: how far the others are, and their weights. Even
   ones have both nodes, with one weight. The others are as many as there is room for; what is not
   there has the weight 0. */
struct pairs {
  long count, even, before[MOST_PAIRS], after[MOST_PAIRS];
  double behind[MOST_PAIRS], ahead[MOST_PAIRS];
};

/* The nodes from lo to before hi. */
struct box {
  long lo[3], hi[3];
};

struct cube {
  const struct pairs *pairs[3]; /* of the nodes of the axes */
  long reach[3], size[3];       /* size: of the wide range, all nodes that derivatives need */
  struct box range;             /* the range itself in it, N nodes */
  long inner[2];                /* nodes along the first axis that have the same pairs */
  const double *P;              /* (3, 3) periods: P_kc */
  const long *ahead;            /* how many layers behind each one its derivatives reach */
  const long *faces;            /* (count, 2) some faces: axis i, index of their nodes along it */
  double *q;                    /* (3, 3, slots layers) q_k, by k and n; z is in slot z % slots */
  double *rows;                 /* memory: (9, nodes of a row) */
  long N, count, slots;
};

static long wide_of(const struct cube *c, long x, long y, long z) {
  return x + c->size[0] * (y + c->size[1] * z);
}
/* A node of the wide range in planes of the range. */
static long place_of(const struct cube *c, long x, long y, long z) {
  const long row = y - c->range.lo[1] + (c->range.hi[1] - c->range.lo[1]) * (z - c->range.lo[2]);
  return x - c->range.lo[0] + (c->range.hi[0] - c->range.lo[0]) * row;
}
static long wide_nodes(const struct cube *c) { return c->size[0] * c->size[1] * c->size[2]; }
static long q_nodes(const struct cube *c) { return c->size[0] * c->size[1] * c->slots; }

/* What a pair adds to D f of a node. */
INLINE double of_pair(const double *f, const struct pairs *p, int m, int even) {
  if (even) return p->ahead[m] * (f[p->after[m]] - f[-p->before[m]]);
  return p->ahead[m] * (f[p->after[m]] - *f) + p->behind[m] * (*f - f[-p->before[m]]);
}
/* D f of a node. Even pairs are PAIRS, as inside a block. */
INLINE double slope_with(const struct pairs *p, const double *f, int even) {
  double sum = of_pair(f, p, 0, even);
  for (int m = 1; m < (even ? PAIRS : MOST_PAIRS); ++m) sum += of_pair(f, p, m, even);
  return sum;
}
static int is_even(const struct pairs *p) { return p->even && p->count == PAIRS; }
/* D f of n nodes with the same pairs. */
static NOINLINE void slopes_of(const struct pairs *p, const double *f, double *restrict out,
                               long n) {
  if (is_even(p)) {
    ITEMS("omp simd", out[i] = slope_with(p, f + i, 1);)
  } else {
    ITEMS("omp simd", out[i] = slope_with(p, f + i, 0);)
  }
}

/* A row of n nodes, and its pairs along the three axes, of the first node along axis 0. */
struct line {
  long x, n;
  const struct pairs *pairs[3];
};
/* Where those nodes of a row end, from node i on, that have the same pairs along axis 0. */
static long same_pairs(const struct cube *c, const struct line *r, long i) {
  const long x = r->x + i, inside = c->inner[0] <= x && x < c->inner[1];
  return inside ? least(c->inner[1] - r->x, r->n) : i + 1;
}
/* The pairs along an axis of the nodes of a row from node i on. */
static const struct pairs *pairs_at(const struct line *r, int axis, long i) {
  return r->pairs[axis] + (axis == 0 ? i : 0);
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

/* q_k of n nodes with the same pairs along axis k, of the places x. W, Q: from plane to plane. */
INLINE void potential_with(const struct pairs *p, const double *P, const double *x, long W,
                           double *restrict q, long Q, long n, int even) {
  ITEMS("omp simd",
    const double a = x[i]; const double e = x[2 * W + i]; const double f = x[W + i];
    const double D_a = slope_with(p, x + i, even);
    const double D_f = slope_with(p, x + W + i, even);
    const double D_e = slope_with(p, x + 2 * W + i, even);
    q[i] = 0.5 * (f * D_e - e * D_f) + (f * P[2] - e * P[1]);
    q[Q + i] = 0.5 * (e * D_a - a * D_e) + (e * P[0] - a * P[2]);
    q[2 * Q + i] = 0.5 * (a * D_f - f * D_a) + (a * P[1] - f * P[0]);
  )
}
static NOINLINE void potential_of(const struct pairs *p, const double *P, const double *x, long W,
                                  double *q, long Q, long n) {
  if (is_even(p)) return potential_with(p, P, x, W, q, Q, n, 1);
  potential_with(p, P, x, W, q, Q, n, 0);
}

/* Fill q_k of the places x in the rows of a layer of a box. */
static void find_potential(const struct cube *c, const double *x, int k, const struct box *b,
                           long z) {
  const long W = wide_nodes(c), Q = q_nodes(c);
  for (long y = b->lo[1]; y < b->hi[1]; ++y) {
    const struct line r = line_at(c, b, y, z);
    const double *row = x + wide_of(c, r.x, y, z);
    double *q = c->q + 3 * k * Q + wide_of(c, r.x, y, z % c->slots);
    for (long i = 0, stop; i < r.n; i = stop) {
      stop = k == 0 ? same_pairs(c, &r, i) : r.n;
      potential_of(pairs_at(&r, k, i), c->P + 3 * k, row + i, W, q + i, Q, stop - i);
    }
  }
}

/* D_j f - D_k g + more of n nodes with the same pairs. */
INLINE void curl_with(const struct pairs *j, const double *f, int even_j, const struct pairs *k,
                      const double *g, int even_k, double more, double *restrict out, long n) {
  ITEMS("omp simd",
    out[i] = (slope_with(j, f + i, even_j) - slope_with(k, g + i, even_k)) + more;
  )
}
static NOINLINE void curl_of(const struct pairs *j, const double *f, const struct pairs *k,
                             const double *g, double more, double *out, long n) {
  if (is_even(j) && is_even(k)) return curl_with(j, f, 1, k, g, 1, more, out, n);
  if (is_even(j)) return curl_with(j, f, 1, k, g, 0, more, out, n);
  if (is_even(k)) return curl_with(j, f, 0, k, g, 1, more, out, n);
  curl_with(j, f, 0, k, g, 0, more, out, n);
}

/* Fill planes a with a^i = D_j q_k - D_k q_j and what periods add, in a layer of a box. */
static void find_area(const struct cube *c, int axis, double *a, const struct box *b, long z) {
  const int j = (axis + 1) % 3, k = (axis + 2) % 3;
  const long Q = q_nodes(c), N = c->N;
  const double *P_j = c->P + 3 * j, *P_k = c->P + 3 * k;
  const double more[3] = {P_j[1] * P_k[2] - P_k[1] * P_j[2], P_j[2] * P_k[0] - P_k[2] * P_j[0],
                          P_j[0] * P_k[1] - P_k[0] * P_j[1]};
  const struct pairs slots = between_slots(c, c->pairs[2] + z, z);
  for (long y = b->lo[1]; y < b->hi[1]; ++y) {
    struct line r = line_at(c, b, y, z);
    const double *q = c->q + wide_of(c, r.x, y, z % c->slots);
    r.pairs[2] = &slots;
    for (long i = 0, stop; i < r.n; i = stop) {
      const struct pairs *of_j = pairs_at(&r, j, i), *of_k = pairs_at(&r, k, i);
      stop = axis == 0 ? r.n : same_pairs(c, &r, i);
      for (int m = 0; m < 3; ++m) {
        const double *f = q + (3 * k + m) * Q + i, *g = q + (3 * j + m) * Q + i;
        curl_of(of_j, f, of_k, g, more[m], a + m * N + place_of(c, r.x + i, y, z), stop - i);
      }
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
    for (const long end = least(z + c->ahead[z] + 1, of_q.hi[2]); found < end; ++found)
      for (int k = 0; k < 2; ++k)
        if (k != only) find_potential(c, x, k, &of_q, found);
    if (only != 2) find_potential(c, x, 2, &of_q, z);
    for (int i = 0; i < 3; ++i)
      if (only == ALL || only == i) find_area(c, i, a + 3 * i * c->N, b, z);
  }
}

/* Fill planes a with a^1, a^2 and a^3 of the range, of the places x. */
void cube_areas(const struct cube *c, const double *x, double *a) {
  find_areas(c, x, a, &c->range, ALL);
}

/* Fill planes a with a^i on the faces, each of one axis i: of the places x there. */
void cube_faces(const struct cube *c, const double *x, double *a) {
  for (const long *face = c->faces; face < c->faces + 2 * c->count; face += 2) {
    struct box b = c->range;
    b.lo[face[0]] = c->range.lo[face[0]] + face[1];
    b.hi[face[0]] = b.lo[face[0]] + 1;
    find_areas(c, x, a, &b, (int)face[0]);
  }
}

/* Fill det D x of the range, of the places x. */
void cube_volumes(const struct cube *c, const double *x, double *volume) {
  const long W = wide_nodes(c), length = c->size[0];
  double G[9];
  for (long z = c->range.lo[2]; z < c->range.hi[2]; ++z)
    for (long y = c->range.lo[1]; y < c->range.hi[1]; ++y) {
      const struct line r = line_at(c, &c->range, y, z);
      for (long i = 0, stop; i < r.n; i = stop) {
        stop = same_pairs(c, &r, i);
        for (int m = 0; m < 9; ++m) {
          const double *f = x + m % 3 * W + wide_of(c, r.x + i, y, z);
          slopes_of(pairs_at(&r, m / 3, i), f, c->rows + m * length + i, stop - i);
        }
      }
      for (long i = 0; i < r.n; ++i) {
        for (int m = 0; m < 9; ++m) G[m] = c->rows[m * length + i] + c->P[m];
        volume[place_of(c, r.x + i, y, z)] = G[0] * (G[4] * G[8] - G[5] * G[7]) +
                                             G[1] * (G[5] * G[6] - G[3] * G[8]) +
                                             G[2] * (G[3] * G[7] - G[4] * G[6]);
      }
    }
}
