/* Metrics of a moving grid in three dimensions: area vectors a^1, a^2, a^3 in curl form with
   sum_k D_k a^k = 0, and J_t = sum_k a^k . D_k v.

       (a^i)_n = D_j q_k - D_k q_j,   q_k = 1/2 (x_m D_k x_l - x_l D_k x_m)

   with (i, j, k) and (n, m, l) cyclic (Thomas and Lombard, AIAA J. 17 (1979) 1030-1037). With x = y
   + sum_k xi_k P_k, P_k the period of axis k or 0, by the product rule,

       q_k = 1/2 (y_m D_k y_l - y_l D_k y_m) + y_m P_kl - y_l P_km,
       (a^i)_n += P_jm P_kl - P_km P_jl.

   D of a node comes from differences of pairs of nodes, in an order that is its own mirror image
   and without fused multiplications: blocks that share a face get the same bits for what lies
   within it, whichever way their axes run. Rows are taken one after the other, so that they
   stay in fast memory. */

#define ROOM 1024 /* most nodes of a row that are taken at once */
#define MOST_PAIRS 16

struct cube {
  const double *S[3], *half[3]; /* pairs of the axes (1 + reach, size), 1/2 over the weights */
  long reach[3], size[3];       /* size: of the wide range, all nodes that derivatives need */
  long first[3], end[3];        /* the range itself in it */
  long inner[2];                /* nodes along the first axis that have the same pairs */
  double P[9];                  /* periods: P_kc */
  const double *x, *v;          /* (3, wide nodes) the y above, called x below; velocities */
  double *q;                    /* (3, 3, wide nodes) q_k, by k and n */
  double *metrics, *volume;     /* planes of N nodes of the range; det D x */
  const long *faces;            /* (count, 2) some faces: axis i, and index of their nodes along it */
  double *of_faces;             /* (9, N) a^i on these faces, or their rates; elsewhere 0 */
  long N, count;
};
struct box {
  long lo[3], hi[3];
};

static long wide_of(const struct cube *c, long x, long y, long z) {
  return x + c->size[0] * (y + c->size[1] * z);
}
static long wide_nodes(const struct cube *c) { return c->size[0] * c->size[1] * c->size[2]; }

/* A pair of nodes on both sides, ``far`` numbers away: its weights. */
struct pair { long far; double behind, ahead; };

/* Find the pairs of the node i along an axis, nearest first, and how many there are. */
static long pairs_of(const struct cube *c, int axis, long i, struct pair *pairs) {
  const long size = c->size[axis];
  const long step = axis == 0 ? 1 : axis == 1 ? c->size[0] : c->size[0] * c->size[1];
  long count = 0;
  for (long k = 1; k <= c->reach[axis]; ++k) {
    const double ahead = i + k < size ? c->S[axis][k * size + i] : 0.0;
    const double behind = i >= k ? c->S[axis][k * size + i - k] : 0.0;
    if (ahead != 0.0 || behind != 0.0) pairs[count++] = (struct pair){k * step, behind, ahead};
  }
  return count;
}

/* out = factor (out + that of a pair), without out if it is the first. */
static NOINLINE void add_pair(const double *f, struct pair p, double factor, int first,
                              double *restrict out, long n) {
  const double *before = p.behind != 0.0 ? f - p.far : f, *after = p.ahead != 0.0 ? f + p.far : f;
#pragma omp simd
  for (long i = 0; i < n; ++i) {
    const double more = p.ahead * (after[i] - f[i]) + p.behind * (f[i] - before[i]);
    out[i] = factor * (first ? more : out[i] + more);
  }
}

/* The same of two pairs that have both nodes, first ones. */
static NOINLINE void set_pairs(const double *f, struct pair p, struct pair r, double factor,
                               double *restrict out, long n) {
  const double *p0 = f - p.far, *p1 = f + p.far, *r0 = f - r.far, *r1 = f + r.far;
#pragma omp simd
  for (long i = 0; i < n; ++i) {
    const double one = p.ahead * (p1[i] - f[i]) + p.behind * (f[i] - p0[i]);
    const double two = r.ahead * (r1[i] - f[i]) + r.behind * (f[i] - r0[i]);
    out[i] = factor * (one + two);
  }
}

/* out = factor D f of n nodes with the same pairs. */
static void add_up(const double *f, const struct pair *pairs, long count, double factor,
                   double *out, long n) {
  long m = 0;
  if (count >= 2 && pairs[0].behind != 0.0 && pairs[0].ahead != 0.0 && pairs[1].behind != 0.0 &&
      pairs[1].ahead != 0.0) {
    set_pairs(f, pairs[0], pairs[1], count == 2 ? factor : 1.0, out, n);
    m = 2;
  }
  for (; m < count; ++m) add_pair(f, pairs[m], m == count - 1 ? factor : 1.0, m == 0, out, n);
}

/* D f of the node i along the first axis. */
static double slope_of(const struct cube *c, const double *f, long i) {
  struct pair pairs[MOST_PAIRS];
  const long count = pairs_of(c, 0, i, pairs);
  double sum = 0.0;
  for (const struct pair *p = pairs; p < pairs + count; ++p)
    sum += (p->ahead != 0.0 ? p->ahead * (f[i + p->far] - f[i]) : 0.0) +
           (p->behind != 0.0 ? p->behind * (f[i] - f[i - p->far]) : 0.0);
  return c->half[0][i] * sum;
}

/* out = D f along the first axis, of n nodes from x on: those with the same pairs together. */
static void derive_along(const struct cube *c, const double *f, long x, long n, double *out) {
  struct pair pairs[MOST_PAIRS];
  const long a = least(most(c->inner[0], x), x + n), b = most(least(c->inner[1], x + n), a);
  for (long i = x; i < a; ++i) out[i - x] = slope_of(c, f, i);
  if (a < b) add_up(f + a, pairs, pairs_of(c, 0, a, pairs), c->half[0][a], out + a - x, b - a);
  for (long i = b; i < x + n; ++i) out[i - x] = slope_of(c, f, i);
}

/* out = D f along an axis, of the n nodes from (x, y, z) on along the first axis. */
static void derive(const struct cube *c, int axis, const double *f, long x, long y, long z, long n,
                   double *out) {
  if (axis == 0) {
    derive_along(c, f + wide_of(c, 0, y, z), x, n, out);
    return;
  }
  struct pair pairs[MOST_PAIRS];
  const long i = axis == 1 ? y : z, count = pairs_of(c, axis, i, pairs);
  add_up(f + wide_of(c, x, y, z), pairs, count, c->half[axis][i], out, n);
}

/* The part of a box whose rows begin at x and have at most ROOM nodes. */
static struct box part_of(const struct box *b, long x) {
  struct box part = *b;
  part.lo[0] = x;
  part.hi[0] = least(x + ROOM, b->hi[0]);
  return part;
}

/* Find all three components of q_k in a box of short rows, for the places x + sign v. */
static void potentials_of_part(const struct cube *c, int k, double sign, const struct box *b) {
  const long n = b->hi[0] - b->lo[0], W = wide_nodes(c);
  double slope[3][ROOM], place[3][ROOM], turn[ROOM];
  for (long z = b->lo[2]; z < b->hi[2]; ++z) {
    for (long y = b->lo[1]; y < b->hi[1]; ++y) {
      const long at = wide_of(c, b->lo[0], y, z);
      for (int m = 0; m < 3; ++m) {
        derive(c, k, c->x + m * W, b->lo[0], y, z, n, slope[m]);
        memcpy(place[m], c->x + m * W + at, n * sizeof(double));
        if (sign == 0.0) continue;
        derive(c, k, c->v + m * W, b->lo[0], y, z, n, turn);
        for (long i = 0; i < n; ++i) {
          slope[m][i] += sign * turn[i];
          place[m][i] += sign * c->v[m * W + at + i];
        }
      }
      for (int component = 0; component < 3; ++component) {
        const int m = (component + 1) % 3, l = (component + 2) % 3;
        const double *f = place[m], *g = place[l], *slope_f = slope[m], *slope_g = slope[l];
        const double P_f = c->P[3 * k + m], P_g = c->P[3 * k + l];
        double *restrict q = c->q + (3 * k + component) * W + at;
#pragma omp simd
        for (long i = 0; i < n; ++i)
          q[i] = 0.5 * (f[i] * slope_g[i] - g[i] * slope_f[i]) + (f[i] * P_g - g[i] * P_f);
      }
    }
  }
}

/* The same in any box. */
static void potentials(const struct cube *c, int k, double sign, const struct box *b) {
  for (long x = b->lo[0]; x < b->hi[0]; x += ROOM) {
    const struct box part = part_of(b, x);
    potentials_of_part(c, k, sign, &part);
  }
}

/* Add factor times a^i of a box of short rows to out, planes by component of the nodes of the
 * range. */
static void areas_of_part(const struct cube *c, int i, double factor, const struct box *b,
                          double *out) {
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  const long n = b->hi[0] - b->lo[0], W = wide_nodes(c), rows = c->end[0] - c->first[0];
  double more[ROOM], less[ROOM];
  for (long z = b->lo[2]; z < b->hi[2]; ++z) {
    for (long y = b->lo[1]; y < b->hi[1]; ++y) {
      const long row = (y - c->first[1]) + (c->end[1] - c->first[1]) * (z - c->first[2]);
      for (int component = 0; component < 3; ++component) {
        const int m = (component + 1) % 3, l = (component + 2) % 3;
        const double periods =
            c->P[3 * j + m] * c->P[3 * k + l] - c->P[3 * k + m] * c->P[3 * j + l];
        derive(c, j, c->q + (3 * k + component) * W, b->lo[0], y, z, n, more);
        derive(c, k, c->q + (3 * j + component) * W, b->lo[0], y, z, n, less);
        double *restrict a = out + component * c->N + row * rows + b->lo[0] - c->first[0];
#pragma omp simd
        for (long p = 0; p < n; ++p) a[p] += factor * ((more[p] - less[p]) + periods);
      }
    }
  }
}

/* The same of any box. */
static void areas(const struct cube *c, int i, double factor, const struct box *b, double *out) {
  for (long x = b->lo[0]; x < b->hi[0]; x += ROOM) {
    const struct box part = part_of(b, x);
    areas_of_part(c, i, factor, &part, out);
  }
}

/* A box with the nodes that derivatives along two axes reach. */
static struct box reached(const struct cube *c, const struct box *b, int one, int other) {
  struct box found = *b;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis != one && axis != other) continue;
    found.lo[axis] = most(b->lo[axis] - c->reach[axis], 0);
    found.hi[axis] = least(b->hi[axis] + c->reach[axis], c->size[axis]);
  }
  return found;
}

/* det D x at entry i of rows of D_k y_c. */
static double determinant(const double *P, double (*G)[ROOM], long i) {
  const double xx = G[0][i] + P[0], xy = G[1][i] + P[1], xz = G[2][i] + P[2];
  const double yx = G[3][i] + P[3], yy = G[4][i] + P[4], yz = G[5][i] + P[5];
  const double zx = G[6][i] + P[6], zy = G[7][i] + P[7], zz = G[8][i] + P[8];
  return xx * (yy * zz - yz * zy) + xy * (yz * zx - yx * zz) + xz * (yx * zy - yy * zx);
}

/* Find a^1, a^2, a^3 of the range. */
void cube_move(const struct cube *c) {
  const struct box range = {{c->first[0], c->first[1], c->first[2]},
                            {c->end[0], c->end[1], c->end[2]}};
  for (int k = 0; k < 3; ++k) {
    const struct box wide = reached(c, &range, (k + 1) % 3, (k + 2) % 3);
    potentials(c, k, 0.0, &wide);
  }
  memset(c->metrics, 0, 9 * c->N * sizeof(double));
  for (int i = 0; i < 3; ++i) areas(c, i, 1.0, &range, c->metrics + 3 * i * c->N);
}

/* Find det D x of the range. */
void cube_volumes(const struct cube *c) {
  const long n = c->end[0] - c->first[0], W = wide_nodes(c);
  double G[9][ROOM], *volume = c->volume;
  for (long z = c->first[2]; z < c->end[2]; ++z) {
    for (long y = c->first[1]; y < c->end[1]; ++y) {
      for (long x = 0; x < n; x += ROOM) {
        const long m = least(ROOM, n - x);
        for (int k = 0; k < 9; ++k)
          derive(c, k / 3, c->x + k % 3 * W, c->first[0] + x, y, z, m, G[k]);
        for (long i = 0; i < m; ++i) *volume++ = determinant(c->P, G, i);
      }
    }
  }
}

/* Find the velocity of the grid and J_t, after cube_move. */
void cube_swing(const struct cube *c) {
  const long W = wide_nodes(c);
  double slope[ROOM];
  long at = 0;
  for (long z = c->first[2]; z < c->end[2]; ++z) {
    for (long y = c->first[1]; y < c->end[1]; ++y) {
      for (long x = c->first[0]; x < c->end[0]; x += ROOM) {
        const long m = least(ROOM, c->end[0] - x);
        double *restrict J_t = c->metrics + 12 * c->N + at;
        memset(J_t, 0, m * sizeof(double));
        for (int k = 0; k < 9; ++k) {
          const double *restrict area = c->metrics + k * c->N + at;
          derive(c, k / 3, c->v + k % 3 * W, x, y, z, m, slope);
#pragma omp simd
          for (long i = 0; i < m; ++i) J_t[i] += area[i] * slope[i];
        }
        for (int k = 0; k < 3; ++k)
          memcpy(c->metrics + (9 + k) * c->N + at, c->v + k * W + wide_of(c, x, y, z),
                 m * sizeof(double));
        at += m;
      }
    }
  }
}

/* Add factor times a^i of the places x + sign v to planes a, on the nodes of the range with index
   ``at`` along axis i: that takes derivatives within the face only. */
static void cube_face(const struct cube *c, long i, long at, double factor, double sign, double *a) {
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  struct box face = {{c->first[0], c->first[1], c->first[2]}, {c->end[0], c->end[1], c->end[2]}};
  face.lo[i] = c->first[i] + at;
  face.hi[i] = face.lo[i] + 1;
  const struct box of_k = reached(c, &face, j, j), of_j = reached(c, &face, k, k);
  potentials(c, k, sign, &of_k);
  potentials(c, j, sign, &of_j);
  areas(c, i, factor, &face, a);
}

static void add_faces(const struct cube *c, double factor, double sign) {
  for (long n = 0; n < c->count; ++n) {
    const long i = c->faces[2 * n];
    cube_face(c, i, c->faces[2 * n + 1], factor, sign, c->of_faces + 3 * i * c->N);
  }
}

/* Find a^i of the places x on the faces. */
void cube_faces(const struct cube *c) {
  memset(c->of_faces, 0, 9 * c->N * sizeof(double));
  add_faces(c, 1.0, 0.0);
}

/* Find how a^i changes in time on the faces: it is bilinear in the places, so half the difference of
   those of x + v and x - v. */
void cube_turn(const struct cube *c) {
  memset(c->of_faces, 0, 9 * c->N * sizeof(double));
  add_faces(c, 0.5, 1.0);
  add_faces(c, -0.5, -1.0);
}
