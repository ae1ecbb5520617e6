"""Texts of `.fll` files drawn at random: what files in the wild have, good and bad, and no writer would write."""

NAMES = ["a", "b-1", "weight", "Gap_(m)", "min", "x", "é", "speed of it", "NAND", "d.e"]
TERMS = ["low", "very-low", "high", "MED", "3rd", "pi", "not", "any", "s"]
VERSIONS = ["", "", "#Code automatically generated with fuzzylite {}.\n".format, "# numerics of pyfuzzylite\n"]
ENGINES = ["drawn", "simple-dimmer", "two words", ""]
OF_SETS = ["Centroid", "Bisector", "SmallestOfMaximum", "LargestOfMaximum", "MeanOfMaximum"]
ACTIVATIONS = [
    *["General"] * 5,
    "none",
    "First",
    "Last 2 0.25",
    "Highest 2",
    "Lowest",
    "Proportional",
    "Threshold >= 0.3",
    "Threshold",
    "Highest 200000",
    "AlgebraicProduct",
]
HEDGES = ["any", "extremely", "not", "seldom", "somewhat", "very"]
S_NORMS = (
    "Maximum AlgebraicSum BoundedSum NormalizedSum DrasticSum EinsteinSum HamacherSum NilpotentMaximum UnboundedSum"
)
S_NORMS = S_NORMS.split()
T_NORMS = "Minimum AlgebraicProduct BoundedDifference DrasticProduct EinsteinProduct HamacherProduct NilpotentMinimum"
T_NORMS = T_NORMS.split()
#: The numbers of each kind of term.
KINDS = dict.fromkeys(
    "Arc Bell Binary Concave Cosine Gaussian GaussianProduct PiShape Ramp Rectangle SemiEllipse".split(), 2
)
KINDS |= dict.fromkeys("Sigmoid SigmoidDifference SigmoidProduct Spike SShape Trapezoid Triangle ZShape".split(), 2)
KINDS |= {"Bell": 3, "Triangle": 3, "Trapezoid": 4, "PiShape": 4}
KINDS |= {"GaussianProduct": 4, "SigmoidDifference": 4, "SigmoidProduct": 4}
MONOTONE = ["Ramp", "Sigmoid", "SShape", "ZShape", "Concave", "Arc"]


def number(rng):
    return rng.choice([f"{rng.uniform(-1, 11):.3f}", str(rng.randrange(11)), "0.0", "1e1", ".5"])


class Fll:
    """One file.

    Args:
        rng: A random.Random.
    """

    def __init__(self, rng):
        self.rng = rng
        count = rng.choice([1, 1, 2, 2, 3])
        names = rng.sample(NAMES, count + rng.choice([1, 1, 2]))
        self.inputs, self.outputs = names[:count], names[count:]
        self.terms = {}

    def text(self):
        rng = self.rng
        version = rng.choice(VERSIONS)
        head = version(rng.choice(["4.0", "5.0", "6.0", "7.1"])) if callable(version) else version
        lines = [f"Engine: {rng.choice(ENGINES)}", *rng.choice([[], ['  description: a "drawn" engine']])]
        for name in self.inputs:
            lines += [f"InputVariable: {name}", *self.variable(name, True)]
        for name in self.outputs:
            lines += [f"OutputVariable: {name}", *self.output(name)]
        blocks = [[*self.block(k)] for k in range(rng.choice([1, 1, 1, 2, 3]))]
        if rng.random() < 0.3:  # blocks of no name that differ in their rules only
            common = ["RuleBlock:", *(line for line in blocks[0][1:] if "rule:" not in line)]
            blocks = [[*common, *(line for line in block if "rule:" in line)] for block in blocks]
        lines += [line for block in blocks for line in block]
        text = head + "\n".join(lines) + "\n"
        return text.replace("\n", "\r\n") if rng.random() < 0.05 else text

    def maybe(self, line, chance=0.8):
        return [line] if self.rng.random() < chance else []

    def variable(self, name, is_input, kinds=()):
        rng = self.rng
        ends = rng.choice(["0 10", "-1.5 12", "0.000 1.000", *(["-inf inf", "0 inf"] if is_input else [])])
        ends = rng.choice(["0 0", "-inf inf"]) if kinds and rng.random() < 0.15 else ends
        yield from self.maybe(f"  enabled: {'true' if rng.random() < 0.95 else 'false'}", 0.5)
        yield from self.maybe(f"  range: {ends}", 0.97)
        yield from self.maybe(f"  lock-range: {rng.choice(['true', 'false'])}", 0.6)
        names = rng.sample(TERMS, rng.choice([1, 2, 2, 3]))
        if rng.random() < 0.05:
            names.append(names[0])
        self.terms[name] = names
        yield from (f"  term: {term} {self.term(is_input, kinds)}" for term in names)

    def term(self, is_input, kinds):
        rng = self.rng
        kind = rng.choice(kinds or list(KINDS))
        if not kinds and rng.random() < 0.2:
            # A formula of an input beside one that is called x was read, and had no value.
            formula = "Discrete" if "x" in self.inputs else "Function"
            kind = rng.choice(["Discrete", formula, "Constant" if rng.random() < 0.3 else "Discrete"])
        if kind == "Function":
            return f"Function {rng.choice(['x / 12', 'sin(x) ^ 2', '0.5', 'pow(x, 2) / 150', 'lt(x, 4) and gt(x, 1)'])}"
        if kind == "FunctionOfInputs":
            name = next((n for n in self.inputs if n.isidentifier()), "1")
            return f"Function 2 * {name} + sin({name})"
        if kind == "Linear":
            return " ".join(["Linear", *(number(rng) for _ in range(len(self.inputs) + rng.choice([0, 1, 1])))])
        if kind == "Constant":
            return f"Constant {rng.choice(['0.5', '1', '0.0']) if is_input else number(rng)}"
        count = 2 * rng.choice([2, 3]) if kind == "Discrete" else KINDS[kind]
        values = [f"{v:.3f}" for v in sorted(rng.uniform(-1, 11) for _ in range(count))]
        if kind == "Discrete":
            values[1::2] = [rng.choice(["0", "1", "0.5"]) for _ in values[1::2]]
        if rng.random() < 0.15:
            values[rng.randrange(count)] = rng.choice(["inf", "-inf", "0", values[0]])
        if rng.random() < 0.1:
            rng.shuffle(values)
        height = rng.choice([*[[]] * 8, ["0.5"], ["1.000"], ["0"], ["0.5", "7"]])
        return " ".join([kind, *values, *height])

    def output(self, name):
        rng = self.rng
        weighted = rng.random() < 0.5
        yield from self.maybe(
            f"  {rng.choice(['aggregation', 'aggregation', 'accumulation'])}: {self.norm(S_NORMS)}", 0.97
        )
        if weighted:
            kind = rng.choice(["", " Automatic", " TakagiSugeno", " Tsukamoto"])
            yield f"  defuzzifier: {rng.choice(['WeightedAverage', 'WeightedSum'])}{kind}"
            kinds = rng.choice([["Constant"], ["Constant", "Linear"], ["FunctionOfInputs"], MONOTONE, ["Triangle"]])
        else:
            yield from self.maybe(f"  defuzzifier: {rng.choice(OF_SETS)}{rng.choice(['', ' 100', ' 1', ' 37'])}", 0.97)
            kinds = ()
        yield from self.maybe(f"  default: {rng.choice(['nan', '0.5', '-1'])}", 0.7)
        yield from self.maybe(f"  {rng.choice(['lock-previous', 'lock-previous', 'lock-valid'])}: true", 0.2)
        yield from self.variable(name, False, kinds)

    def norm(self, norms):
        return "none" if self.rng.random() < 0.05 else self.rng.choice(norms[: self.rng.choice([2, 9])])

    def block(self, k):
        rng = self.rng
        yield f"RuleBlock: {rng.choice(['', 'rules', f'block {k}'])}"
        yield from self.maybe(f"  enabled: {'true' if rng.random() < 0.9 else 'false'}", 0.5)
        yield f"  conjunction: {self.norm(T_NORMS)}"
        yield f"  disjunction: {self.norm(S_NORMS)}"
        yield from self.maybe(f"  implication: {self.norm(T_NORMS)}", 0.9)
        yield f"  activation: {rng.choice(ACTIVATIONS)}"
        yield from (f"  rule: {self.rule()}" for _ in range(rng.choice([0, 1, 2, 2, 3, 4])))

    def rule(self):
        rng = self.rng
        outputs = [rng.choice(self.outputs) for _ in range(rng.choice([1, 1, 1, 2]))]
        then = " and ".join(self.proposition(o, 0.1) for o in outputs)
        weight = rng.choice(["", "", "", " with 0.5", " with 1.000", " with 0"])
        return f"if {self.condition(2)} then {then}{weight}"

    def condition(self, depth):
        rng = self.rng
        if depth == 0 or rng.random() < 0.5:
            return self.proposition(rng.choice([*self.inputs * 6, *self.outputs]), 0.3)
        sign = rng.choice([" and ", " or "])
        text = sign.join(self.condition(depth - 1) for _ in range(rng.choice([2, 2, 3])))
        return f"({text})" if rng.random() < 0.5 else text

    def proposition(self, name, hedged):
        rng = self.rng
        hedges = [rng.choice(HEDGES) for _ in range(rng.choice([1, 1, 2]))] if rng.random() < hedged else []
        # A second file of a name has other terms; one misspelt word is enough for a file to be refused.
        term = "absent" if rng.random() < 0.003 else rng.choice(self.terms[name])
        spelt = "".join(c for c in name if not c.isspace() and c not in "()")
        if "any" in hedges and rng.random() < 0.5:
            return " ".join([spelt, "is", *hedges[: hedges.index("any") + 1]])
        return " ".join([spelt, "is", *hedges, term])


def fll(rng):
    """Draw a text."""
    return Fll(rng).text()
