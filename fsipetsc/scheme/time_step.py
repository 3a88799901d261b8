"""The length of a step: its bound, and the next time that must be hit."""

#: a step may be longer than its bound by this fraction, so that round-off costs no extra step
SLACK = 1e-9


def longest_step(courant, fixed, rate):
    """Bound on a step [s]: the one that is given (-ts_dt), or, if that is 0, the Courant number
    times 1/``rate``.
    """
    return fixed if fixed != 0.0 else courant / rate


def next_step(t, target, bound):
    """(step, time after it) [s]: at most ``bound``; with less than two steps to the target they are
    equal.
    """
    left = target - t
    if left <= bound * (1 + SLACK):
        return left, target
    step = left / 2 if left < 2 * bound else bound
    return step, t + step
