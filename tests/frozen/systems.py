"""Systems whose printed programs, bounds and verdicts are kept: every method, every algorithm, every variant."""

INPUTS = """
input x in [-1, 2]
  terms N Z P
input y in [0, 10]
  low  = triangle(-inf, 1, 4)
  mid  = trapezoid(1, 4, 5, 9)
  high = ramp(5, 9)
"""

STRAIGHT = """
output u in [-4, 6]
  a = triangle(-4, -2, 1)
  b = trapezoid(-1, 0, 1, 4)
  c = triangle(2, 5, inf)
"""

CURVED = """
output u in [-4, 6]
  a = gaussian(-2, 1)
  b = bell(1, 1, 2)
  c = s_shape(1, 5)
"""

NUMBERS = """
output u in [-4, 6]
  terms a=-3 b=0.5 c=5
"""

MONOTONE = """
output u in [-4, 6]
  a = ramp(3, -4)
  b = s_shape(-2, 5)
  c = sigmoid(1, 2)
"""

TABLE = """
table u = x x y
       low  mid  high
  N |  a    a    b
  Z |  a    b    c
  P |  b    c    c
"""

RULES = """
if x is N and y is low then u is a
if x is Z or y is mid then u is b weight 0.8
if x is P and not y is very low then u is c
if x is somewhat Z and (y is high or x is P) then u is c
"""

#: Tables of MacVicar and Whelan: bands of equal terms.
BANDS = """
input e in [-1, 1]
  terms NB NM NS ZO PS PM PB
input de in [-2, 2]
  terms NB NM NS ZO PS PM PB
output u in [-3, 3]
  terms NB NM NS ZO PS PM PB

table u = e x de
        NB  NM  NS  ZO  PS  PM  PB
  NB |  NB  NB  NB  NB  NM  NS  ZO
  NM |  NB  NB  NB  NM  NS  ZO  PS
  NS |  NB  NB  NM  NS  ZO  PS  PM
  ZO |  NB  NM  NS  ZO  PS  PM  PB
  PS |  NM  NS  ZO  PS  PM  PB  PB
  PM |  NS  ZO  PS  PM  PB  PB  PB
  PB |  ZO  PS  PM  PB  PB  PB  PB
"""


def over_sets(method, output=STRAIGHT, rules=RULES):
    return f"{method}\n{INPUTS}{output.replace('[-4, 6]', '[-4, 6] else 0')}{rules}"


def over_rules(method, output=NUMBERS, rules=TABLE):
    return f"{method}\n{INPUTS}{output}{rules}"


def many_inputs(count):
    """A complete grid of terms over inputs of different ranges, in which few rules act at a time."""
    names = [f"x{k}" for k in range(count)]
    inputs = "\n".join(f"input {n} in [{-k}, {k + 1}]\n  terms N Z P" for k, n in enumerate(names))
    rules = []
    for number in range(3**count):
        digits = [number // 3**k % 3 for k in range(count)]
        cells = " and ".join(f"{n} is {'NZP'[d]}" for n, d in zip(names, digits, strict=True))
        rules.append(f"if {cells} then u is {'abc'[sum(digits) % 3]}")
    return "\n".join(["and min", "defuzzifier weighted_average", inputs, NUMBERS, *rules])


_TEXTS = {
    # Averages over rules.
    "center_average": over_rules("and product\ndefuzzifier center_average", STRAIGHT),
    "weighted_average_product": over_rules("and product\ndefuzzifier weighted_average"),
    "weighted_average_min": over_rules("and min\ndefuzzifier weighted_average"),
    "weighted_average_rules": over_rules(
        "and min\nor max\ndefuzzifier weighted_average", NUMBERS.replace("6]", "6] else 0"), RULES
    ),
    "weighted_sum": over_rules("and product\ndefuzzifier weighted_sum"),
    "takagi_sugeno": over_rules(
        "and product\ndefuzzifier weighted_average",
        "output u in [-40, 60]\n  a = linear(2, 0.5, -1)\n  b = constant(0.5)\n  c = function(x * y - sin(x))\n",
    ),
    "tsukamoto": over_rules("and min\ndefuzzifier tsukamoto", MONOTONE),
    "tsukamoto_sum": over_rules("and product\ndefuzzifier tsukamoto_sum", MONOTONE),
    "inverse_tsukamoto": over_rules("and min\ndefuzzifier inverse_tsukamoto", CURVED),
    "inverse_tsukamoto_sum": over_rules("and min\ndefuzzifier inverse_tsukamoto_sum", STRAIGHT),
    # Sets with straight sides.
    "centroid_min_max": over_sets("defuzzifier centroid"),
    "centroid_product_max": over_sets("implication product\ndefuzzifier centroid"),
    "centroid_product_sum": over_sets("implication product\naggregation sum\ndefuzzifier centroid"),
    "centroid_min_sum": over_sets("aggregation sum\ndefuzzifier centroid"),
    "centroid_table": over_rules("defuzzifier centroid", STRAIGHT),
    "bisector_min_max": over_sets("defuzzifier bisector"),
    "bisector_product_sum": over_sets("implication product\naggregation sum\ndefuzzifier bisector"),
    "smallest_of_maximum": over_sets("defuzzifier som"),
    "mean_of_maximum": over_sets("defuzzifier mom"),
    "largest_of_maximum_by_magnitude": over_sets("defuzzifier lom(by=magnitude)"),
    "mean_of_maximum_product": over_sets("implication product\ndefuzzifier mom"),
    # Curved sets and other norms.
    "centroid_curved": over_sets("defuzzifier centroid", CURVED),
    "centroid_curved_sum": over_sets("implication product\naggregation sum\ndefuzzifier centroid", CURVED),
    "centroid_other_norms": over_sets(
        "and einstein_product\nor einstein_sum\n"
        "implication hamacher_product\naggregation bounded_sum\ndefuzzifier centroid"
    ),
    "bisector_curved": over_sets("defuzzifier bisector", CURVED),
    "maxima_curved": over_sets("defuzzifier mom", CURVED),
    "centroid_hedged": over_sets("defuzzifier centroid", STRAIGHT, RULES.replace("u is a", "u is not very a")),
    # Samples.
    "centroid_sampled": over_sets("defuzzifier centroid(resolution=50)", CURVED),
    "centroid_trapezoid": over_sets("defuzzifier centroid(resolution=21, grid=endpoints, rule=trapezoid)"),
    "bisector_walk": over_sets("defuzzifier bisector(resolution=21, grid=endpoints, rule=walk)"),
    "bisector_two_sided": over_sets("defuzzifier bisector(resolution=21, grid=left, rule=two_sided)"),
    "maxima_running": over_sets("defuzzifier lom(resolution=21, rule=running)", CURVED),
    # Activation, blocks, several outputs, chains.
    "activation_highest": over_rules("and min\nactivation highest(count=2)\ndefuzzifier weighted_average"),
    "activation_first": over_rules(
        "and min\nactivation first(count=2, threshold=0.1)\ndefuzzifier center_average",
        STRAIGHT.replace("6]", "6] else 0"),
    ),
    "activation_proportional": over_sets("activation proportional\ndefuzzifier centroid"),
    "activation_threshold": over_sets("activation threshold(>= 0.2)\ndefuzzifier centroid"),
    "blocks": over_sets(
        "and min\ndefuzzifier centroid",
        rules=RULES + "rules fast and product implication product activation lowest(count=1)\n"
        "if x is very P and y is high then u is c\nif x is N and y is high then u is b\n",
    ),
    "several_outputs": over_rules(
        "and product\ndefuzzifier weighted_average",
        NUMBERS + "output v in [0, 1]\n  terms d=0 e=0.5 f=1\n",
        TABLE.replace("table u", "table u, v")
        .replace("a    a    b", "a/d  a/e  b/f")
        .replace("a    b    c", "a/d  b/e  c/f")
        .replace("b    c    c", "b/d  c/e  c/f"),
    ),
    "chain": over_rules(
        "and product\ndefuzzifier weighted_average",
        NUMBERS + "output v in [0, 1] else 0\n  low = triangle(-inf, 0, 1)\n  high = triangle(0, 1, inf)\n",
        "if y is low then v is low\nif y is high then v is high\n"
        "if v is low and x is N then u is a\nif v is high or x is Z then u is b\nif x is P then u is c\n",
    ).replace("[-4, 6]", "[-4, 6] else 0"),
    # States.
    "adaptive": over_rules(
        "and product\ndefuzzifier weighted_average\nparam gamma = 2",
        "output u in [-4, 6] adaptive rate gamma * x\n  terms a=-3 b=0.5 c=5\n",
    ),
    "hold": over_rules("and min\ndefuzzifier weighted_average", NUMBERS.replace("6]", "6] else hold(1)"), RULES),
    # Names of the rest of the language.
    "own_hedge": over_rules(
        "hedge hardly(z) = (1 - z)^3\nand min\ndefuzzifier weighted_average",
        NUMBERS.replace("6]", "6] else nan"),
        RULES.replace("very low", "hardly low"),
    ),
    "own_degree": over_rules(
        "and min\ndefuzzifier weighted_average", NUMBERS.replace("6]", "6] else error"), RULES
    ).replace("low  = triangle(-inf, 1, 4)", "low  = function(1 / (1 + y^2))"),
    "extrapolate": over_rules("and product\ndefuzzifier weighted_average").replace("[0, 10]", "[0, 10] extrapolate"),
    "matlab": over_sets("semantics matlab"),
    "fuzzylite": over_sets("semantics fuzzylite"),
    "scikit_fuzzy": over_sets("semantics scikit_fuzzy"),
    # Large tables.
    "bands_centroid": "defuzzifier centroid" + BANDS,
    "bands_average": "and product\ndefuzzifier center_average" + BANDS,
    "four_inputs": many_inputs(4),
}

SYSTEMS = {name: f"system {name}\n{text}" for name, text in _TEXTS.items()}
