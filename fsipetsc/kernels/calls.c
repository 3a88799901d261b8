/* Calls of procedures, one after the other. */

struct call {
  void (*procedure)(const void *, double *, long, double *, long);
  const void *of;
  double *y;
  long y_size;
  double *f;
  long f_size;
};

void run_calls(const struct call *calls, long count) {
  for (const struct call *c = calls; c < calls + count; ++c)
    c->procedure(c->of, c->y, c->y_size, c->f, c->f_size);
}

/* The calls of one step, once, and again while nothing is bad and more steps are allowed. */
void run_batch(const struct call *calls, long count, const double *bad, const double *allowed) {
  do run_calls(calls, count);
  while (*bad == 0.0 && *allowed != 0.0);
}
