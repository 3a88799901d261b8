/* Metrics of a moving grid in three dimensions: area vectors a^1, a^2, a^3 in curl form with
   sum_k D_k a^k = 0.

       (a^i)_n = D_j q_k - D_k q_j,   q_k = 1/2 (x_m D_k x_l - x_l D_k x_m)

   with (i, j, k) and (n, m, l) cyclic (Thomas and Lombard, AIAA J. 17 (1979) 1030-1037). With x = y
   + sum_k xi_k P_k, P_k the period of axis k or 0, by the product rule,

       q_k = 1/2 (y_m D_k y_l - y_l D_k y_m) + y_m P_kl - y_l P_km,
       (a^i)_n += P_jm P_kl - P_km P_jl.

   D of a node comes from differences of pairs of nodes, in an order that is its own mirror image
   and without fused multiplications: blocks that share a face get the same bits for what lies
   within it, whichever way their axes run. Rows are taken one after the other, and all that is
   done with a row at once, so that it stays in fast memory. */

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
  double P[9];                  /* periods: P_kc */
  const double *x, *v;          /* (3, wide nodes) the y above, called x below; velocities */
  double *q;                    /* (3, 3, slots layers) q_k, by k and n; z is in slot z % slots */
  double *metrics, *volume;     /* planes of N nodes of the range; det D x */
  const long *faces;            /* (count, 2) some faces: axis i, index of their nodes along it */
  double *turning;              /* (9, N) how a^i changes in time on these faces */
  double *moved, *other, *rows; /* memory: (3, wide nodes), (3, N), (9, nodes of a row) */
  long N, count, slots, only;   /* only: i of the a^i that is wanted, or ALL */
};
struct box {
  long lo[3], hi[3];
};

static long wide_of(const struct cube *c, long x, long y, long z) {
  return x + c->size[0] * (y + c->size[1] * z);
}
static long wide_nodes(const struct cube *c) { return c->size[0] * c->size[1] * c->size[2]; }
static long q_nodes(const struct cube *c) { return c->size[0] * c->size[1] * c->slots; }

/* What a pair adds to D f of a node. */
INLINE double of_pair(const double *f, const struct pairs *p, int m, int even) {
  if (even) return p->ahead[m] * (f[p->after[m]] - f[-p->before[m]]);
  return p->ahead[m] * (f[p->after[m]] - *f) + p->behind[m] * (*f - f[-p->before[m]]);
}
/* D f of a node. */
INLINE double slope(const double *f, const struct pairs *p, int count, int even) {
  double sum = of_pair(f, p, 0, even);
  for (int m = 1; m < count; ++m) sum += of_pair(f, p, m, even);
  return sum;
}

/* What is done with D f along an axis: planes f of the wide range or, if of_q, planes q; what it
   fills: planes of the range or, if to_q, planes q. */
struct task {
  void (*of_row)(const struct cube *, const struct task *, const struct pairs *, long, long, long);
  int axis, of_q, to_q;
  const double *f;
  double *out;
};
/* A task of n nodes of a row with the same pairs: ``at`` is the first one in planes f, ``place``
   that in the range, or in planes q for those that fill them. Its code stands once for each number
   of pairs, which is unrolled. */
#define TASK(name)                                                                             \
  static NOINLINE void name(const struct cube *c, const struct task *t, const struct pairs *p, \
                            long at, long place, long n) {                                     \
    switch (p->even ? p->count : 0) {                                                          \
      case 1: return name##_of(c, t, p, at, place, n, 1, 1);                                   \
      case 2: return name##_of(c, t, p, at, place, n, 2, 1);                                   \
      case 3: return name##_of(c, t, p, at, place, n, 3, 1);                                   \
      case 4: return name##_of(c, t, p, at, place, n, 4, 1);                                   \
    }                                                                                          \
    if (p->count <= 3) return name##_of(c, t, p, at, place, n, 3, 0);                          \
    name##_of(c, t, p, at, place, n, MOST_PAIRS, 0);                                           \
  }
#define ROW_OF(name)                                                                              \
  INLINE void name##_of(const struct cube *c, const struct task *t, const struct pairs *p,         \
                        long at, long place, long n, int count, int even)

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

/* Do tasks with each row of a box. */
static void do_rows(const struct cube *c, const struct task *tasks, int count,
                    const struct box *b) {
  const long *first = c->first, *end = c->end;
  for (long z = b->lo[2]; z < b->hi[2]; ++z) {
    const struct pairs slots = between_slots(c, c->pairs[2] + z, z);
    for (long y = b->lo[1]; y < b->hi[1]; ++y) {
      const long wide = wide_of(c, 0, y, z), q = wide_of(c, 0, y, z % c->slots);
      const long row = y - first[1] + (end[1] - first[1]) * (z - first[2]);
      const long place = (end[0] - first[0]) * row - first[0];
      for (const struct task *t = tasks; t < tasks + count; ++t) {
        const long inner = least(most(c->inner[0], b->lo[0]), b->hi[0]);
        const long at = t->of_q ? q : wide, to = t->to_q ? q : place;
        for (long x = b->lo[0], stop; x < b->hi[0]; x = stop) {
          const long same = x != inner ? x + 1 : most(least(c->inner[1], b->hi[0]), x + 1);
          stop = t->axis != 0 ? b->hi[0] : same;
          const long i = t->axis == 0 ? x : t->axis == 1 ? y : z;
          const struct pairs *p = t->of_q && t->axis == 2 ? &slots : c->pairs[t->axis] + i;
          t->of_row(c, t, p, at + x, to + x, stop - x);
        }
      }
    }
  }
}

/* q_k of the places f. */
ROW_OF(potential) {
  const struct pairs of = *p;
  const long W = wide_nodes(c);
  const double *x = t->f + at, *P = c->P + 3 * t->axis;
  double *restrict q = t->out + place;
  const double P0 = P[0], P1 = P[1], P2 = P[2];
  const long Q = q_nodes(c);
  ITEMS("omp simd",
    const double a = x[i]; const double b = x[W + i]; const double e = x[2 * W + i];
    const double D_a = slope(x + i, &of, count, even);
    const double D_b = slope(x + W + i, &of, count, even);
    const double D_e = slope(x + 2 * W + i, &of, count, even);
    q[i] = 0.5 * (b * D_e - e * D_b) + (b * P2 - e * P1);
    q[Q + i] = 0.5 * (e * D_a - a * D_e) + (e * P0 - a * P2);
    q[2 * Q + i] = 0.5 * (a * D_b - b * D_a) + (a * P1 - b * P0);
  )
}
TASK(potential)

/* D_j q_k, the first part of a^i. */
ROW_OF(begin_area) {
  const struct pairs of = *p;
  const long Q = q_nodes(c), N = c->N;
  const double *q = t->f + at;
  double *restrict a = t->out + place;
  ITEMS("omp simd",
    for (int m = 0; m < 3; ++m) a[m * N + i] = slope(q + m * Q + i, &of, count, even);
  )
}
TASK(begin_area)

/* a^i = D_j q_k - D_k q_j with what periods add, k the axis of the task. */
ROW_OF(end_area) {
  const struct pairs of = *p;
  const long Q = q_nodes(c), N = c->N;
  const double *q = t->f + at, *P_j = c->P + (t->axis + 2) % 3 * 3, *P_k = c->P + t->axis * 3;
  double *restrict a = t->out + place;
  const double more[3] = {P_j[1] * P_k[2] - P_k[1] * P_j[2], P_j[2] * P_k[0] - P_k[2] * P_j[0],
                          P_j[0] * P_k[1] - P_k[0] * P_j[1]};
  ITEMS("omp simd",
    for (int m = 0; m < 3; ++m)
      a[m * N + i] = (a[m * N + i] - slope(q + m * Q + i, &of, count, even)) + more[m];
  )
}
TASK(end_area)

/* D_k x of a row, in planes of its nodes. */
ROW_OF(gradient) {
  const struct pairs of = *p;
  const long W = wide_nodes(c), size = c->size[0];
  const double *x = t->f + at;
  double *restrict slopes = t->out + at % size;
  (void)place;
  ITEMS("omp simd",
    for (int m = 0; m < 3; ++m) slopes[m * size + i] = slope(x + m * W + i, &of, count, even);
  )
}
TASK(gradient)

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
static struct box range_of(const struct cube *c) {
  return (struct box){{c->first[0], c->first[1], c->first[2]}, {c->end[0], c->end[1], c->end[2]}};
}

/* Find q_k of the places x in a box. */
static void potentials(const struct cube *c, const double *x, int k, struct box b) {
  const struct task task = {potential, k, 0, 1, x, c->q + 3 * k * q_nodes(c)};
  do_rows(c, &task, 1, &b);
}
/* The tasks that fill planes a with a^i. */
static void areas(const struct cube *c, int i, double *a, struct task *tasks) {
  const long j = (i + 1) % 3, k = (i + 2) % 3, Q = q_nodes(c);
  tasks[0] = (struct task){begin_area, j, 1, 0, c->q + 3 * k * Q, a};
  tasks[1] = (struct task){end_area, k, 1, 0, c->q + 3 * j * Q, a};
}

/* Do the tasks of a^1, a^2 and a^3 in a box, or of a^only alone if that is not ALL, at the places
   x: layer by layer, q_k as far ahead as it is needed. */
enum { ALL = 3 };
static void find_areas(const struct cube *c, const double *x, const struct task *tasks, int count,
                       const struct box *b, int only) {
  long found = most(b->lo[2] - c->reach[2], 0);
  struct box layer = *b;
  for (long z = b->lo[2]; z < b->hi[2]; ++z) {
    for (; found <= z + c->reach[2] && found < c->size[2]; ++found) {
      for (int k = 0; k < 3; ++k) { /* a^i takes D_m q_k of the axis m that is neither i nor k */
        const int one = only == ALL ? (k + 1) % 3 : 3 - only - k;
        struct box of_q = reached(c, b, one, only == ALL ? (k + 2) % 3 : one);
        if (k == only || found < of_q.lo[2] || of_q.hi[2] <= found) continue;
        of_q.lo[2] = found, of_q.hi[2] = found + 1;
        potentials(c, x, k, of_q);
      }
    }
    layer.lo[2] = z, layer.hi[2] = z + 1;
    do_rows(c, tasks, count, &layer);
  }
}

/* Find a^i of the places x on a face: that takes derivatives within the face only. */
static void find_face(const struct cube *c, const double *x, long i, const struct box *face,
                      double *a) {
  struct task tasks[2];
  areas(c, i, a, tasks);
  find_areas(c, x, tasks, 2, face, (int)i);
}

/* Find a^1, a^2 and a^3 of the range, or the one of them that is wanted. */
void cube_move(const struct cube *c) {
  const struct box range = range_of(c);
  struct task tasks[6];
  if (c->only != ALL) {
    find_face(c, c->x, c->only, &range, c->metrics + 3 * c->only * c->N);
    return;
  }
  for (int k = 0; k < 3; ++k) areas(c, k, c->metrics + 3 * k * c->N, tasks + 2 * k);
  find_areas(c, c->x, tasks, 6, &range, ALL);
}

/* Find det D x of the range. */
void cube_volumes(const struct cube *c) {
  const long rows = c->size[0];
  double *volume = c->volume;
  struct task tasks[3];
  for (int k = 0; k < 3; ++k)
    tasks[k] = (struct task){gradient, k, 0, 0, c->x, c->rows + 3 * k * rows};
  for (long z = c->first[2]; z < c->end[2]; ++z) {
    for (long y = c->first[1]; y < c->end[1]; ++y) {
      const struct box row = {{c->first[0], y, z}, {c->end[0], y + 1, z + 1}};
      do_rows(c, tasks, 3, &row);
      for (long i = c->first[0]; i < c->end[0]; ++i) {
        double G[9];
        for (int m = 0; m < 9; ++m) G[m] = c->rows[m * rows + i] + c->P[m];
        *volume++ = G[0] * (G[4] * G[8] - G[5] * G[7]) + G[1] * (G[5] * G[6] - G[3] * G[8]) +
                    G[2] * (G[3] * G[7] - G[4] * G[6]);
      }
    }
  }
}

/* The nodes of the range with index ``at`` along axis i. */
static struct box face_of(const struct cube *c, long i, long at) {
  struct box face = range_of(c);
  face.lo[i] = c->first[i] + at;
  face.hi[i] = face.lo[i] + 1;
  return face;
}

/* x + sign v of a face with the nodes that its derivatives reach. */
static const double *places(const struct cube *c, double sign, const struct box *face, long i) {
  const struct box b = reached(c, face, (i + 1) % 3, (i + 2) % 3);
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
  for (long n = 0; n < c->count; ++n) {
    const long i = c->faces[2 * n];
    const struct box b = face_of(c, i, c->faces[2 * n + 1]);
    double *a = c->turning + 3 * i * c->N;
    find_face(c, places(c, 1.0, &b, i), i, &b, a);
    find_face(c, places(c, -1.0, &b, i), i, &b, c->other);
    for (long z = b.lo[2]; z < b.hi[2]; ++z)
      for (long y = b.lo[1]; y < b.hi[1]; ++y)
        for (long x = b.lo[0]; x < b.hi[0]; ++x) {
          const long row = y - c->first[1] + (c->end[1] - c->first[1]) * (z - c->first[2]);
          const long node = x - c->first[0] + (c->end[0] - c->first[0]) * row;
          for (int m = 0; m < 3; ++m)
            a[m * c->N + node] = 0.5 * (a[m * c->N + node] - c->other[m * c->N + node]);
        }
  }
}
