"""Defuzzifiers over the samples of an aggregated set; None where they have no value."""

import math
from itertools import accumulate, pairwise


def locations(own, lower, upper):
    """Return where a defuzzifier takes its samples."""
    shift = 0.5 if own.grid == "midpoint" else 0.0
    return [lower + (i + shift) * cell(own, lower, upper) for i in range(own.resolution)]


def defuzzified(own, xs, ys, lower, upper):
    """Return what a defuzzifier makes of the samples `ys` of a set at `xs`."""
    # The bisector from both ends does not look at the first sample.
    if max(ys[1:] if own.rule == "two_sided" else ys) <= 0.0:
        return None
    if own.kind == "centroid":
        return centroid(own, xs, ys)
    if own.kind == "bisector":
        return BISECTORS[own.rule or "interpolated"](own, xs, ys, lower, upper)
    return running(own, xs, ys) if own.rule == "running" else maximum(own, xs, ys)


def cell(own, lower, upper):
    """Return the distance between samples."""
    return (upper - lower) / (max(own.resolution - 1, 1) if own.grid == "endpoints" else own.resolution)


def centroid(own, xs, ys):
    ends = [0.5 if own.rule == "trapezoid" and i in (0, len(xs) - 1) else 1.0 for i in range(len(xs))]
    area = sum(w * y for w, y in zip(ends, ys, strict=True))
    return sum(w * y * x for w, y, x in zip(ends, ys, xs, strict=True)) / area if area > 0.0 else None


def maximum(own, xs, ys):
    bound = (1.0 - (1e-9 if own.tolerance is None else own.tolerance)) * max(ys)
    largest = [x for x, y in zip(xs, ys, strict=True) if y >= bound]
    if own.kind == "mom":
        return sum(largest) / len(largest)
    return (min if own.kind == "som" else max)(largest, key=abs if own.by == "magnitude" else None)


def running(own, xs, ys):
    """A largest degree so far, as fuzzylite 6 has it."""
    same, most, place, end, stays = own.tolerance or 0.0, -1.0, xs[0], xs[0], False
    for x, y in zip(xs, ys, strict=True):
        equal = y == most or abs(y - most) < same
        if own.kind == "lom" and (equal or y > most):
            most, place = y, x
        elif own.kind != "lom" and not equal and y > most:
            most, place, end, stays = y, x, x, True
        elif equal and stays:
            end = x
        elif not equal and y < most:
            stays = False
    return 0.5 * (place + end) if own.kind == "mom" else place


def first(own, xs, ys, lower, upper):
    half = sum(ys) / 2
    return next(x for x, area in zip(xs, accumulate(ys), strict=True) if area >= half)


def nearest(own, xs, ys, lower, upper):
    away = [abs(area / sum(ys) - 0.5) for area in accumulate(ys)]
    best = [x for x, d in zip(xs, away, strict=True) if d == min(away)]
    return sum(best) / len(best)


def walk(own, xs, ys, lower, upper):
    areas = [(a + b) / 2 for a, b in pairwise(ys)]
    left, right, k = 0.0, sum(areas), 0
    if right <= 0.0:
        return None
    while left < right:
        left, right, k = left + areas[k], right - areas[k], k + 1
    return xs[k] if areas[k - 1] >= left - right else xs[k - 1]


def two_sided(own, xs, ys, lower, upper):
    low, high, below, above = 0, len(ys) - 1, 0.0, 0.0
    while low < high:
        if below <= above:
            low, below = low + 1, below + ys[low + 1]
        else:
            high, above = high - 1, above + ys[high - 1]
    return xs[low] if below > 0.0 else None


def between(own, xs, ys, lower, upper):
    same, low, high, below, above = own.tolerance or 0.0, 0, len(ys), 0.0, 0.0
    while low < high:
        if below <= above or below - above < same:
            low, below = low + 1, below + ys[low]
        else:
            high, above = high - 1, above + ys[high - 1]
    left = xs[low - 1] if low else lower
    right = xs[high] if high < len(ys) else upper
    return (below * right + above * left) / (below + above)


def interpolated(own, xs, ys, lower, upper):
    """Up to where the area is half; cells are flat, or between the ends of the range straight."""
    straight, step = own.grid == "endpoints", cell(own, lower, upper)
    starts = xs if own.grid != "midpoint" else [x - step / 2 for x in xs]
    lines = pairwise(ys) if straight else ((y, y) for y in ys)
    cells = [(x, a, b) for x, (a, b) in zip(starts, lines, strict=False) if a + b > 0.0]
    rest = sum(a + b for _, a, b in cells) / 4
    for k, (x, a, b) in enumerate(cells):
        area = (a + b) / 2
        if abs(rest - area) <= 1e-13 * area and k + 1 < len(cells):
            return (x + step + cells[k + 1][0]) / 2  # the middle of a gap, if there is one
        if rest <= area:
            root = math.sqrt(max(0.0, a * a + 2 * (b - a) * rest))
            return x + step * min(1.0, 2 * rest / (a + root))
        rest -= area
    return cells[-1][0] + step if cells else None


BISECTORS = {
    "interpolated": interpolated,
    "first": first,
    "nearest": nearest,
    "walk": walk,
    "two_sided": two_sided,
    "between": between,
}
