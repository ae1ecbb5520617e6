"""Published systems evaluated with numpy alone: membership functions, tables and defuzzifiers written out."""

import math
from itertools import pairwise

import numpy as np

SEVEN = np.linspace(-1, 1, 7)


def tri(x, a, b, c):
    """Degree of a triangle; an infinite foot is a shoulder."""
    x = np.asarray(x, dtype=float)
    left = np.ones_like(x) if math.isinf(a) else (x - a) / (b - a)
    right = np.ones_like(x) if math.isinf(c) else (c - x) / (c - b)
    return np.clip(np.minimum(left, right), 0, 1)


def ramp(x, start, end):
    return np.clip((np.asarray(x, dtype=float) - start) / (end - start), 0, 1)


def partition(x, peaks):
    """Degrees of triangles between peaks, the outer ones shoulders; shape (terms, ...)."""
    ends = [-math.inf, *peaks, math.inf]
    return np.stack([tri(x, *ends[k : k + 3]) for k in range(len(peaks))])


def strengths(rows, columns, norm):
    """Firing strengths of a table, shape (rows, columns, ...)."""
    return norm(rows[:, None], columns[None, :])


def average(w, values):
    """Average of the values of a table's cells, by strength."""
    values = np.asarray(values, dtype=float).reshape(w.shape[:2] + (1,) * (w.ndim - 2))
    return (w * values).sum((0, 1)) / w.sum((0, 1))


def cells(text, **values):
    """Values of the cells of a table that is typed as words."""
    return np.array([[values[word] for word in line.split()] for line in text.strip().splitlines()])


def diagonal(names, size):
    """Cells of a table along diagonals: the sum of both positions, counted from the middle, held at the ends."""
    steps = np.arange(size) - size // 2
    return np.clip(steps[:, None] + steps[None, :], -(size // 2), size // 2) / (size // 2) * names


def centroid_of_union(points, heights, sets):
    """Centroid of the larger of some scaled sets of straight sides, exact: corners, crossings, Simpson's rule."""
    curves = [lambda y, h=h, s=s: h * tri(y, *s) for h, s in zip(heights, sets, strict=True)]
    corners = sorted({*points, *(v for s in sets for v in s if min(points) < v < max(points))})
    found = list(corners)
    for a, b in pairwise(corners):
        for i, f in enumerate(curves):
            for g in curves[:i]:
                at_a, at_b = f(a) - g(a), f(b) - g(b)
                if at_a * at_b < 0:
                    found.append(a + (b - a) * at_a / (at_a - at_b))
    y = np.array(sorted(found))
    middle = (y[1:] + y[:-1]) / 2
    mu = [np.max([f(at) for f in curves], axis=0) for at in (y[:-1], middle, y[1:])]
    step = np.diff(y) / 6
    area = (step * (mu[0] + 4 * mu[1] + mu[2])).sum()
    return (step * (mu[0] * y[:-1] + 4 * mu[1] * middle + mu[2] * y[1:])).sum() / area


def takagi_sugeno_1985(x1, x2):
    w = [np.minimum(ramp(x1, 16, 0), ramp(x2, 8, 0)), ramp(x1, 10, 20), ramp(x2, 2, 10)]
    return (w[0] * (x1 + x2) + w[1] * 2 * x1 + w[2] * 3 * x2) / sum(w)


def _lee(x, y):
    one = min(tri(x, 2, 5, 8), tri(y, 5, 8, 11))
    two = min(tri(x, 3, 6, 9), tri(y, 4, 7, 10))
    z = np.arange(11.0)
    return z, np.maximum(np.minimum(one, tri(z, 1, 4, 7)), np.minimum(two, tri(z, 3, 6, 9)))


def lee_1990(x, y):
    found = []
    for a, b in zip(x, y, strict=True):
        z, mu = _lee(a, b)
        if mu.max() == 0:
            found.append((math.nan, math.nan))
        else:
            found.append(((z * mu).sum() / mu.sum(), z[mu >= mu.max() * (1 - 1e-9)].mean()))
    return np.array(found).T


def passino_yurkovich_1998(e, de):
    five = np.arange(-2, 3)
    w = strengths(partition(e, five * math.pi / 4), partition(de, five * math.pi / 8), np.minimum)
    values = -10 * np.clip(five[:, None] + five[None, :], -2, 2)
    return average(20 * (w - w**2 / 2), values), average(w, values)


ZHAO_P = "BBBBBBB SBBBBBS SSBBBSS SSSBSSS SSBBBSS SBBBBBS BBBBBBB".split()
ZHAO_D = "SSSSSSS BBSSSBB BBBSBBB BBBBBBB BBBSBBB BBSSSBB SSSSSSS".split()
ZHAO_ALPHA = "2222222 3322233 4332334 5433345 4332334 3322233 2222222".split()


def zhao_1993(e, de):
    w = strengths(partition(e, SEVEN), partition(de, SEVEN), np.multiply)

    def monotone(rows):
        is_big = np.array([[c == "B" for c in row] for row in rows]).reshape(7, 7, *[1] * (w.ndim - 2))
        return (w * np.where(is_big, 1 - np.exp(-4 * w), np.exp(-4 * w))).sum((0, 1))

    p, d = monotone(ZHAO_P), monotone(ZHAO_D)
    alpha = average(w, [[float(c) for c in row] for row in ZHAO_ALPHA])
    kp, kd = 1.6 + 1.4 * p, 0.4 + 0.35 * d
    return p, d, alpha, kp, kd, kp**2 / (alpha * kd)


SEVEN_NAMES = dict(zip("NB NM NS ZE PS PM PB".split(), SEVEN, strict=True))
MUDI_PAL_STEPS = """
NB NB NB NM NS NS ZE
NB NM NM NM NS ZE PS
NB NM NS NS ZE PS PM
NB NM NS ZE PS PM PB
NM NS ZE PS PS PM PB
NS ZE PS PM PM PM PB
ZE PS PS PM PB PB PB
"""
MUDI_PAL_GAIN = """
VB VB VB B SB S ZE
VB VB B B MB S VS
VB MB B VB VS S VS
S SB MB ZE MB SB S
VS S VS VB B MB VB
VS S MB B B VB VB
ZE S SB B VB VB VB
"""


def mudi_pal_1999(reference, y):
    gains = dict(zip("ZE VS S SB MB B VB".split(), np.linspace(0, 1, 7), strict=True))
    found, u, before = [], 0.0, None
    for r, own in zip(reference, y, strict=True):
        e = np.clip(0.9 * (r - own), -1, 1)
        de = np.clip(5 * (0.0 if before is None else (r - own) - before), -1, 1)
        w = strengths(partition(e, SEVEN), partition(de, SEVEN), np.minimum)
        alpha = average(w, cells(MUDI_PAL_GAIN, **gains))
        u += alpha * 0.4 * average(w, cells(MUDI_PAL_STEPS, **SEVEN_NAMES))
        before = r - own
        found.append(u)
    return found


def macvicar_whelan_1977(e, de):
    return average(strengths(partition(e, 6 * SEVEN), partition(de, 6 * SEVEN), np.minimum), diagonal(6, 7))


def yamakawa_1989(angle, rate):
    rules = [(2, 0, 2), (1, 1, 1), (1, -1, 0), (-2, 0, -2), (-1, -1, -1), (-1, 1, 0), (0, 0, 0)]
    w = np.stack([np.minimum(tri(angle, a - 1, a, a + 1), tri(rate, b - 1, b, b + 1)) for a, b, _ in rules])
    total = w.sum(0)
    values = np.array([c for *_, c in rules])[:, None]
    return np.where(total > 0, (w * values).sum(0) / np.where(total > 0, total, 1), 0.0)


KONG_KOSKO = """
PS PM PM PB PB
NS PS PM PB PB
NM NS PS PM PB
NM NM ZE PM PM
NB NM NS PS PM
NB NB NM NS PS
NB NB NM NM NS
"""


def kong_kosko_1992(x, phi):
    position = [
        np.where(x <= 10, 1, ramp(x, 35, 10)),
        tri(x, 30, 40, 50),
        tri(x, 45, 50, 55),
        tri(x, 50, 60, 70),
        ramp(x, 65, 90),
    ]
    turn = [
        tri(phi, -math.inf, -45, 10),
        tri(phi, -10, 35, 60),
        tri(phi, 45, 67.5, 90),
        tri(phi, 80, 90, 100),
        tri(phi, 90, 112.5, 135),
        tri(phi, 120, 145, 190),
        tri(phi, 170, 225, math.inf),
    ]
    w = strengths(np.stack(turn), np.stack(position), np.minimum)
    #: Area and centre of each set within the range.
    area = {"NB": 7.5, "NM": 10, "NS": 6, "ZE": 5, "PS": 6, "PM": 10, "PB": 7.5}
    centre = {"NB": -25, "NM": -15, "NS": -6, "ZE": 0, "PS": 6, "PM": 15, "PB": 25}
    areas = cells(KONG_KOSKO, **area)[..., None] * w
    return (areas * cells(KONG_KOSKO, **centre)[..., None]).sum((0, 1)) / areas.sum((0, 1))


def tanaka_sano_1994(x1, x2, x3):
    z = x2 - 2 / 11 * x1
    turn = np.clip(np.clip(np.abs(z), 0, 3.14) / 3.14, 0, 1)
    laws = [1.28 * x1 - 0.41 * x2 + 0.02 * x3, 0.98 * x1 - 0.07 * x2 + 0.0005 * x3]
    return np.clip((1 - turn) * laws[0] + turn * laws[1], -10, 10)


def wang_1993(reference, x, dx):
    theta, found = np.zeros((3, 3)), []
    for r, a, b in zip(reference, x, dx, strict=True):
        s = 2 * (r - a) - b
        degrees = [np.exp(-(((np.clip(v, -3, 3) - np.array([-2, 0, 2])) / 1) ** 2) / 2) for v in (a, b)]
        w = np.outer(*degrees)
        xi = w / w.sum()
        found.append((theta * xi).sum())
        theta = np.clip(theta + 0.01 * 50 * s * xi, -20, 20)
    return found


def palm_1994(e, de):
    s = np.clip(de + 2 * e, -8, 8)
    w = partition(s, [-1, -0.25, 0, 0.25, 1])
    return (w * np.array([10, 6, 0, -6, -10])[:, None]).sum(0) / w.sum(0)


def yubazaki_1995(angle, rate, size):
    f1, f2 = -angle, -rate
    return f1, f2, size, (0.4 + 0.6 * size) * f1 + (1 - size) * f2


PROCYK = """
NB NB NB NS ZO
NB NS NS ZO ZO
NS ZO ZO ZO PS
ZO ZO PS PS PB
ZO PS PB PB PB
"""


def procyk_mamdani_1979(reference, y):
    values = {"NB": -6, "NS": -3, "ZO": 0, "PS": 3, "PB": 6}
    total, before, sums = 0.0, None, []
    for r, own in zip(reference, y, strict=True):
        e, de = 4 * (r - own), 10 * (0.0 if before is None else (r - own) - before)
        peaks = [-6, -3, 0, 3, 6]
        w = strengths(partition(e, peaks), partition(de, peaks), np.minimum)
        total += 0.02 * average(w, cells(PROCYK, **values))
        before = r - own
        sums.append(total)
    return [0.0] * 5 + sums[:-5]


def mamdani_1975(pressure, change):
    heat = np.arange(-7.0, 8.0)
    sets = [
        np.interp(heat, x, y)
        for x, y in [
            ([4, 7], [0, 1]),
            ([2, 4, 6], [0, 1, 0]),
            ([-2, 0, 2], [0, 1, 0]),
            ([-6, -4, -2], [0, 1, 0]),
            ([-7, -4], [1, 0]),
        ]
    ]
    found = []
    for a, b in zip(pressure, change, strict=True):
        pe, cpe = (round(max(-6.0, min(6.0, v))) for v in (a, b))
        big = {4: 0.3, 5: 0.7, 6: 1.0}
        small = {1: 0.3, 2: 1.0, 3: 0.65, 4: 0.3}
        nb, pb = big.get(-cpe, 0.0), big.get(cpe, 0.0)
        w = [
            min(big.get(-pe, 0.0), 1 - nb),
            min(small.get(-pe, 0.0), 1 - nb),
            min(max(0, 1 - abs(pe) / 2), 1 - max(nb, pb)),
            min(small.get(pe, 0.0), 1 - pb),
            min(big.get(pe, 0.0), 1 - pb),
        ]
        mu = np.max([np.minimum(h, s) for h, s in zip(w, sets, strict=True)], axis=0)
        found.append((heat * mu).sum() / mu.sum() if mu.any() else 0.0)
    return np.array(found)


def sugeno_nishida_1985(distance, side, angle):
    far = [ramp(distance, 20, 60), ramp(side, 10, 50)]
    w = strengths(np.stack([1 - far[0], far[0]]), np.stack([1 - far[1], far[1]]), np.minimum)
    laws = np.array(
        [
            [0.5 * distance - 0.3 * side - 0.2 * angle + 10, 0.4 * distance + 0.1 * side - 0.3 * angle + 5],
            [0.2 * side - 0.4 * angle - 3, 0.1 * side - 0.5 * angle],
        ]
    )
    return np.clip((w * laws).sum((0, 1)) / w.sum((0, 1)), -90, 90)


def larsen_1980(torque, lime):
    sets = {k: (2.5 * (k - 1), 2.5 * k, 2.5 * (k + 1)) for k in (-1, 0, 1)}
    sets |= {-2: (-math.inf, -5, -2.5), 2: (2.5, 5, math.inf)}
    found = []
    for a, b in zip(torque, lime, strict=True):
        w = strengths(partition(a, [-3, 0, 3]), partition(b, [-3, 0, 3]), np.multiply)
        heights = dict.fromkeys(sets, 0.0)
        for i in range(3):
            for j in range(3):
                heights[j - i] = max(heights[j - i], w[i, j])
        found.append(centroid_of_union((-5, 5), [heights[k] for k in sets], [sets[k] for k in sets]))
    return np.array(found)


def kickert_1976(e, de):
    valve = np.arange(-6.0, 7.0)
    sets = [tri(valve, -9, -6, -1), tri(valve, -4, 0, 4), tri(valve, 1, 6, 9)]
    found = []
    for a, b in zip(e, de, strict=True):
        w = strengths(*(1 / (1 + (v - np.array([-4, 0, 4])) ** 4) for v in (a, b)), np.minimum)
        heights = [
            max(w[i, j] for i in range(3) for j in range(3) if np.clip(i + j - 2, -1, 1) == k) for k in (-1, 0, 1)
        ]
        mu = np.max([np.minimum(h, s) for h, s in zip(heights, sets, strict=True)], axis=0)
        found.append(valve[mu >= mu.max() * (1 - 1e-9)].mean())
    return np.array(found)


def ying_1990(e, r):
    large, small = np.maximum(np.abs(e), np.abs(r)), e + r
    return small / (2 * (2 - large))


def mizumoto_1995(a, b):
    return a + b


def li_gatland_1996(reference, y):
    total, before, found = 0.0, None, []
    five = np.linspace(-1, 1, 5)
    for r, own in zip(reference, y, strict=True):
        e = r - own
        de = 0.0 if before is None else e - before
        w = strengths(partition(0.8 * e, five), partition(3 * de, five), np.multiply)
        step = average(w, diagonal(1, 5))
        total += 0.1 * step
        before = e
        found.append(0.5 * step + 0.1 * total)
    return found


def tsukamoto_1979(a, b):
    high = [ramp(a, 0, 10), ramp(b, 0, 10)]
    w = strengths(np.stack([1 - high[0], high[0]]), np.stack([1 - high[1], high[1]]), np.minimum)
    large = np.where(w <= 0.5, np.sqrt(w / 2), 1 - np.sqrt((1 - w) / 2)) * 100
    z = np.stack([np.stack([100 * (1 - w[0, 0]), large[0, 1]]), np.stack([large[1, 0], 100 * (1 - w[1, 1])])])
    return (w * z).sum((0, 1)) / w.sum((0, 1))


def wang_tanaka_griffin_1996(x1, x2):
    a, l, g, beta = 0.1, 0.5, 9.8, math.cos(math.radians(88))  # noqa: E741 - the pendulum's half length, as printed
    laws = []
    for slope, factor in ((g, 1.0), (2 * g / math.pi, beta)):
        n = 4 * l / 3 - a * 2 * l * factor**2
        # Poles at -2: with x2' = slope/n x1 - a factor/n u the polynomial is s^2 + 4 s + 4.
        laws.append(((slope / n + 4) * x1 + 4 * x2) / (a * factor / n))
    level = 2 / math.pi * np.abs(x1)
    return (1 - level) * laws[0] + level * laws[1]
