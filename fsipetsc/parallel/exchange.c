/* Exchanges of numbers between ranks, as procedures: see fsipetsc/parallel/exchange.py. MPI's
   functions and handles come from mpi4py, so that no header of MPI is needed. */

#include <sched.h>
#include <stdio.h>
#include <stdlib.h>

struct run { long from, to, count; }; /* numbers side by side */
struct copies { const struct run *runs; long count; double *buffer; };
struct exchange {
  int (*start_all)(int, void *), (*test_all)(int, void *, int *, void *);
  void *requests, *statuses;
  long messages;                /* requests: those of what is received and of what is sent */
  const double *source;         /* or 0: the world vector */
  double *target;
  struct copies sent, received; /* to a buffer, and from one */
  struct copies own;            /* from source to target */
};

static void copy_runs(const struct copies *c, const double *of, double *to) {
  for (const struct run *r = c->runs; r < c->runs + c->count; ++r) {
    if (r->count > 8)
      memcpy(to + r->to, of + r->from, r->count * sizeof *to);
    else
      for (long i = 0; i < r->count; ++i) to[r->to + i] = of[r->from + i];
  }
}

/* End this rank, and with it the others, if a function of MPI failed. */
static void check(int code) {
  if (code == 0) return;
  fputs("fsipetsc: error: a message between ranks failed\n", stderr);
  abort();
}

/* Wait for all messages. A rank keeps its core for some 1 ms: most messages come within that, and
   another program may keep a core that it was given for 3 ms. Then it lets others have the core:
   where there are more ranks or programs than cores, the rank that it waits for may want it. */
static void wait_for(const struct exchange *e) {
  int done = 0;
  for (long asked = 0; !done; ++asked) {
    if (asked > 20000) sched_yield();
    check(e->test_all((int)e->messages, e->requests, &done, e->statuses));
  }
}

void exchange(const struct exchange *e, double *y, double *f) {
  (void)f;
  const double *source = e->source ? e->source : y;
  copy_runs(&e->sent, source, e->sent.buffer);
  if (e->messages) check(e->start_all((int)e->messages, e->requests));
  copy_runs(&e->own, source, e->target);
  if (e->messages) wait_for(e);
  copy_runs(&e->received, e->received.buffer, e->target);
}

/* The largest of all ranks' numbers, one by one, in place. */
struct reduction {
  int (*all_reduce)(const void *, void *, int, long, long, long);
  long type, operation, comm;
  double *numbers, *room;
  long count;
};

void reduce(const struct reduction *r, double *y, double *f) {
  (void)y, (void)f;
  memcpy(r->room, r->numbers, r->count * sizeof(double));
  check(r->all_reduce(r->room, r->numbers, (int)r->count, r->type, r->operation, r->comm));
}
