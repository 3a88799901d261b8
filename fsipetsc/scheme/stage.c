/* What becomes of the rates k of a row of nodes: they are stored, or what follows from them in a
   stage of the Runge-Kutta method (fsipetsc/scheme/runge_kutta.py). */

enum { RATES, NEXT, LAST };
/* numbers: RATES … LAST, what k is multiplied by; a block's part of the solution, and of the stages
   of fsipetsc/scheme/stage.py. */
struct stage { const double *numbers, *y, *y1, *y2, *y3; };
#define STAGES(own)                                                        \
  .y = stage->y + own, .y1 = stage->y1 + own, .y2 = stage->y2 + own,       \
  .y3 = stage->y3 + own, .numbers = stage->numbers

/* Nodes begin … end - 1 of an axis that a rank owns, and those of them to whose rates nothing is
   added after a sweep. */
struct owned { long begin, end, free_begin, free_end; };

/* Nodes of a range that are within begin … end - 1; an empty range at its end if none are. */
struct range { long begin, end; };
static struct range within(long begin, long end, struct range r) {
  const long a = least(most(begin, r.begin), r.end);
  return (struct range){a, most(least(end, r.end), a)};
}

static int is_free(const struct owned *o, long i) { return o->free_begin <= i && i < o->free_end; }
