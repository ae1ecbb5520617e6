"""Texts of `.fcl` files drawn at random, of the standard, jFuzzyLogic and fuzzylite: good and bad."""

NAMES = ["heat", "Speed", "weight", "min", "x", "é", "d.e"]
TERMS = ["low", "HIGH", "not_at_all", "mid", "any", "2nd"]
SHAPES = {
    "standard": [],
    "jfuzzylogic": ["TRIAN 3", "TRAPE 4", "GAUSS 2", "GBELL 3", "SIGM 2", "DSIGM 4", "COSINE 2", "gauss 2"],
    "fuzzylite": ["Triangle 3", "Trapezoid 4", "Ramp 2", "Gaussian 2", "Bell 3", "SShape 2", "Spike 2", "Rectangle 2"],
}
NORMS = {
    "standard": (["MIN", "PROD", "BDIF"], ["MAX", "ASUM", "BSUM"], ["MAX", "BSUM", "NSUM"]),
    "jfuzzylogic": (
        ["MIN", "PROD", "NIPMIN", "HAMACHER"],
        ["MAX", "ASUM", "EINSTEIN"],
        ["MAX", "SUM", "PROBOR", "NSUM"],
    ),
    "fuzzylite": (["MIN", "PROD", "EPROD", "NONE"], ["MAX", "ASUM", "HSUM"], ["MAX", "USUM", "NONE", "ESUM"]),
}
SIGNS = {
    "standard": ["", "(* a comment *)\n"],
    "jfuzzylogic": ["// a comment\n", ""],
    "fuzzylite": ["# Code automatically generated with fuzzylite {}.\n", "# in the dialect of fuzzylite\n"],
}


def number(rng):
    return rng.choice([f"{rng.uniform(-1, 11):.3f}", str(rng.randrange(11)), "0.0", "1e1", "-2.5"])


class Fcl:
    """One file.

    Args:
        rng: A random.Random.
    """

    def __init__(self, rng):
        self.rng = rng
        self.tool = rng.choice(list(SHAPES))
        count = rng.choice([1, 2, 2, 3])
        names = rng.sample(NAMES, count + rng.choice([1, 1, 2]))
        self.inputs, self.outputs = names[:count], names[count:]
        self.terms = {}

    def text(self):
        rng = self.rng
        lines = [f"FUNCTION_BLOCK {rng.choice(['', 'fan', 'a fan (small)'])}", "VAR_INPUT"]
        lines += [f"  {n} : REAL;" for n in self.inputs]
        lines += ["END_VAR", "VAR_OUTPUT", *(f"  {n} : REAL;" for n in self.outputs), "END_VAR"]
        if rng.random() < 0.3:
            lines += ["VAR", "  k : REAL := 2.5;", "END_VAR"]
            self.constant = "k"
        else:
            self.constant = "3"
        for name in self.inputs:
            lines += [f"FUZZIFY {name}", *self.fuzzy(name, self.sharp(False), True), "END_FUZZIFY"]
        for name in self.outputs:
            lines += [f"DEFUZZIFY {self.spelt(name)}", *self.output(name), "END_DEFUZZIFY"]
        for k in range(rng.choice([1, 1, 2])):
            lines += [f"RULEBLOCK {rng.choice(['', 'No1', f'b{k}', 'rules'])}", *self.block(), "END_RULEBLOCK"]
        head = rng.choice(SIGNS[self.tool]).format(rng.choice(["5.0", "6.0", "7.1"]))
        return head + "\n".join([*lines, "END_FUNCTION_BLOCK"]) + "\n"

    def spelt(self, name):
        return name.upper() if self.rng.random() < 0.05 else name

    def sharp(self, may_be):
        return may_be and self.rng.random() < 0.5

    def fuzzy(self, name, sharp, is_input):
        rng = self.rng
        if rng.random() < 0.8:
            yield f"  RANGE := ({rng.choice(['0 .. 10', '-1.5 .. 12', '0 .. 10', '2 .. 2'])});"
        if self.tool == "fuzzylite":
            locks = ["LOCK : RANGE;", "ENABLED : TRUE;", "ENABLED : FALSE;"]
            yield from (f"  {line}" for line in rng.sample(locks, 1) if rng.random() < (0.3 if is_input else 0.0))
        names = rng.sample(TERMS, rng.choice([1, 2, 3]))
        if rng.random() < 0.05:
            names.append(names[0])
        self.terms[name] = names
        for term in names:
            yield f"  TERM {term} := {self.shape(sharp)};"

    def shape(self, sharp):
        rng = self.rng
        if sharp:
            constants = [number(rng), self.constant]
            if self.tool == "fuzzylite":
                constants += [f"Constant {number(rng)}", "Linear " + " ".join(number(rng) for _ in [*self.inputs, 0])]
            if self.tool == "jfuzzylogic" and self.inputs[0].isidentifier():
                constants += [f"FUNCTION 2 * {self.inputs[0]} + 1", f"FUNCTION sin({self.inputs[0]}) ^ 2"]
            return rng.choice(constants)
        kinds = SHAPES[self.tool]
        if not kinds or rng.random() < 0.3:
            xs = sorted(rng.uniform(0, 10) for _ in range(rng.choice([2, 3, 4])))
            return " ".join(f"({x:.2f}, {rng.choice(['0', '1', '0', '1', '0.5'])})" for x in xs)
        kind, count = rng.choice(kinds).split()
        values = [f"{v:.3f}" for v in sorted(rng.uniform(0, 11) for _ in range(int(count)))]
        if rng.random() < 0.1:
            rng.shuffle(values)
        if rng.random() < 0.1:
            values[-1] = self.constant
        return " ".join([kind, *values, *rng.choice([*[[]] * 8, ["0.5"], ["1", "2"]])])

    def output(self, name):
        rng = self.rng
        sharp = self.sharp(True)
        yield from self.fuzzy(name, sharp, False)
        method = rng.choice(["COGS", "COGS", "COG"] if sharp else ["COG", "COA", "LM", "MM", "COGS"])
        yield from (s for s in [f"  METHOD : {method};"] if rng.random() < 0.9)
        yield from (s for s in [f"  ACCU : {rng.choice(NORMS[self.tool][2])};"] if rng.random() < 0.3)
        defaults = ["0", "2.5", "NC", *(["nan", "NC | 1", "nan | NC"] if self.tool == "fuzzylite" else [])]
        yield from (s for s in [f"  DEFAULT := {rng.choice(defaults)};"] if rng.random() < 0.8)

    def block(self):
        rng = self.rng
        conjunctions, disjunctions, accumulations = NORMS[self.tool]
        yield from (s for s in [f"  AND : {rng.choice(conjunctions)};"] if rng.random() < 0.8)
        yield from (s for s in [f"  OR : {rng.choice(disjunctions)};"] if rng.random() < 0.5)
        yield from (s for s in [f"  ACT : {rng.choice(conjunctions)};"] if rng.random() < 0.7)
        yield from (s for s in [f"  ACCU : {rng.choice(accumulations)};"] if rng.random() < 0.7)
        if self.tool == "fuzzylite" and rng.random() < 0.2:
            yield f"  ENABLED : {rng.choice(['TRUE', 'FALSE'])};"
        for k in range(rng.choice([1, 2, 3])):
            conclusions = ", ".join(
                self.clause(o, 0.0) for o in rng.sample(self.outputs, rng.choice([1, len(self.outputs)]))
            )
            weight = rng.choice(["", "", " WITH 0.5", f" WITH {self.constant}"]) if rng.random() < 0.5 else ""
            yield f"  RULE {k} : IF {self.condition(2)} THEN {conclusions}{weight};"

    def condition(self, depth):
        rng = self.rng
        if depth == 0 or rng.random() < 0.5:
            text = self.clause(rng.choice([*self.inputs * 6, *self.outputs]), 0.2)
            return f"NOT {text}" if rng.random() < 0.1 else text
        text = self.condition(depth - 1)
        for _ in range(rng.choice([1, 1, 2])):
            text += f" {rng.choice(['AND', 'OR', 'and'])} {self.condition(depth - 1)}"
        return f"{rng.choice(['', 'NOT '])}({text})" if rng.random() < 0.6 else text

    def clause(self, name, hedged):
        rng = self.rng
        hedges = [rng.choice(["NOT", "very", "any"])] if rng.random() < hedged else []
        term = "absent" if rng.random() < 0.003 else self.spelt(rng.choice(self.terms[name]))
        return " ".join([self.spelt(name), rng.choice(["IS", "is"]), *hedges, term])


def fcl(rng):
    """Draw a text."""
    return Fcl(rng).text()
