"""Systems drawn at random whose kernels may interpolate, as text: complete tables or loose rules under the product."""

import itertools

from hypothesis import strategies as st


@st.composite
def partitions(draw, lower):
    """Terms of an input, as text: a partition of unity, or overlapping trapezoids that leave no gap."""
    count = draw(st.integers(2, 4))
    steps = draw(st.lists(st.integers(2, 40), min_size=count - 1, max_size=count - 1))
    peaks = list(itertools.accumulate(steps, initial=lower))
    names = [f"T{k}" for k in range(count)]
    if draw(st.booleans()):
        return names, "  terms " + " ".join(f"{n}@{p}" for n, p in zip(names, peaks, strict=True)), peaks
    lines = []
    for k, n in enumerate(names):
        left = "-inf" if k == 0 else f"{peaks[k - 1]}"
        right = "inf" if k == count - 1 else f"{peaks[k + 1] + draw(st.integers(0, 3))}"
        top = peaks[k] + (draw(st.integers(0, 1)) if k < count - 1 else 0)
        height = draw(st.sampled_from(["", ", height=0.75"]))
        lines.append(f"  {n} = trapezoid({left}, {peaks[k]}, {top}, {right}{height})")
    return names, "\n".join(lines), peaks


@st.composite
def systems(draw):
    """A complete table or loose rules over one to three inputs, averaged under the product."""
    count = draw(st.integers(1, 3))
    lines = ["system s", "and product", "or probabilistic_sum", "defuzzifier weighted_average"]
    terms, knots = [], []
    for i in range(count):
        lower = draw(st.integers(-30, 30))
        names, text, peaks = draw(partitions(lower))
        ends = (peaks[0] - draw(st.integers(-1, 2)), peaks[-1] + draw(st.integers(0, 2)))
        extrapolate = draw(st.sampled_from(["", " extrapolate"]))
        lines += [f"input x{i} in [{ends[0]}, {ends[1]}]{extrapolate}", text]
        terms.append(names)
        knots.append([*peaks, *map(float, ends)])
    lines += ["output u in [-10, 10]", *(f"  c{k} = constant({draw(st.integers(-9, 9))})" for k in range(4))]
    for combination in itertools.product(*terms):
        parts = [f"x{i} is {t}" for i, t in enumerate(combination)]
        weight = draw(st.sampled_from(["", " weight 0.5", " weight 0.9"]))
        lines.append(f"if {' and '.join(parts)} then u is c{draw(st.integers(0, 3))}{weight}")
    if count > 1 and draw(st.booleans()):
        lines.append(f"if x0 is not {terms[0][0]} or x1 is {terms[1][0]} then u is c1 weight 0.25")
    return "\n".join(lines), knots
