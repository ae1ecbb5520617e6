"""Texts of `.fis` files drawn at random, of MATLAB, Octave and fuzzylite: good and bad, as files in the wild are."""

NAMES = ["service", "Age (years)", "it''s", "weight", "x:y", "100%", "min", "[1]", "é", "", "a;b"]
TERMS = ["low", "very good", "not", "high", "MED", "3rd", "", "low"]
T_NORMS = (
    "min prod product bounded_difference drastic_product einstein_product hamacher_product nilpotent_minimum".split()
)
S_NORMS = "max probor algebraic_sum bounded_sum normalized_sum drastic_sum einstein_sum hamacher_sum nilpotent_maximum"
S_NORMS = S_NORMS.split()
#: The numbers of each membership function.
OF_MATLAB = {"trimf": 3, "trapmf": 4, "gaussmf": 2, "gauss2mf": 4, "gbellmf": 3, "sigmf": 2, "dsigmf": 4, "psigmf": 4}
OF_MATLAB |= {"zmf": 2, "smf": 2, "pimf": 4, "linsmf": 2, "linzmf": 2}
FUNCTIONS = OF_MATLAB | {"constant": 1, "rampmf": 2, "rectmf": 2, "discretemf": 4}
FUNCTIONS |= dict.fromkeys("concavemf cosinemf spikemf binarymf arcmf semiellipsemf".split(), 2)
HEADS = {
    "matlab": ["", "% a comment\n", "% numerics of matlab\n"],
    "octave": ["% made for Octave\n", "% numerics of octave_0_4\n"],
    "fuzzylite": ["#Code automatically generated with fuzzylite {}.\n", "% numerics of pyfuzzylite\n"],
}
SWITCHES = ["LockRange=1", "LockPrevious=1", "LockValid=1", "Default=0.5", "Default=nan", "Enabled=1", "Enabled=0"]


def number(rng):
    return rng.choice([f"{rng.uniform(-1, 11):.3f}", str(rng.randrange(11)), "0.0", "1e1", "pi/2", "2*3"])


class Fis:
    """One file.

    Args:
        rng: A random.Random.
    """

    def __init__(self, rng):
        self.rng = rng
        self.tool = rng.choice(["matlab", "matlab", "octave", "fuzzylite", "fuzzylite"])
        self.type = rng.choice(["mamdani", "mamdani", "sugeno", "sugeno", "Sugeno", "tsukamoto", "hybrid"])
        if self.tool != "fuzzylite":
            self.type = rng.choice(["mamdani", "sugeno"])
        self.inputs, self.outputs = rng.choice([1, 1, 2, 3]), rng.choice([1, 1, 1, 2])
        self.names = rng.sample(NAMES, self.inputs + self.outputs)

    def maybe(self, line, chance=0.8):
        return [line] if self.rng.random() < chance else []

    def text(self):
        rng = self.rng
        self.counts = []
        lines = [
            "[System]",
            *self.maybe("Name='simple-dimmer'"),
            f"Type='{self.type}'",
            *self.maybe("Version=2.0", 0.5),
        ]
        lines += [f"NumInputs={self.inputs}", *self.methods()]
        for k, name in enumerate(self.names):
            is_input = k < self.inputs
            head = f"[Input{k + 1}]" if is_input else f"[Output{k + 1 - self.inputs}]"
            lines += ["", head, *self.variable(name, is_input)]
        lines += ["", "[Rules]", *(self.rule() for _ in range(rng.choice([1, 2, 3, 5])))]
        head = rng.choice(HEADS[self.tool]).format(rng.choice(["5.0", "6.0", "7.1"]))
        text = head + "\n".join(lines) + "\n"
        return text.replace("\n", "\r\n") if rng.random() < 0.05 else text

    def methods(self):
        rng = self.rng
        few = 2 if self.tool == "matlab" else 20
        for key, words in (
            ("AndMethod", T_NORMS),
            ("OrMethod", S_NORMS),
            ("ImpMethod", T_NORMS),
            ("AggMethod", ["sum", *S_NORMS]),
        ):
            yield from self.maybe(f"{key}='{rng.choice([*words[:few], ''])}'", 0.9)
        weighted = self.type not in ("mamdani", "hybrid")
        kinds = ["wtaver", "wtsum"] if weighted else ["centroid", "bisector", "mom", "som", "lom"]
        yield from self.maybe(f"DefuzzMethod='{rng.choice(kinds)}'", 0.9)

    def variable(self, name, is_input):
        rng = self.rng
        fuzzylite = self.tool == "fuzzylite"
        ends = rng.choice(["[0 10]", "[-1.5 12]", "[0,1]", "[0 0]" if not is_input else "[0 9]"])
        if fuzzylite and is_input and rng.random() < 0.1:
            ends = rng.choice(["[-inf inf]", "[0 inf]"])
        yield from self.maybe(f"Name='{name}'", 0.95)
        yield from self.maybe(f"Range={ends}", 0.99)
        if fuzzylite:
            yield from (s for s in rng.sample(SWITCHES, 2) if rng.random() < 0.3)
        names = [rng.choice(TERMS) for _ in range(rng.choice([1, 2, 2, 3]))]
        self.counts.append(len(names))
        yield f"NumMFs={len(names)}"
        for k, term in enumerate(names, 1):
            yield f"MF{k}='{term}':{self.term(is_input)}"

    def term(self, is_input):
        rng = self.rng
        if not is_input and (self.type in ("sugeno", "Sugeno") or (self.type == "hybrid" and rng.random() < 0.5)):
            count = rng.choice([1, self.inputs + 1])
            kind = "constant" if count == 1 else "linear"
            extra = rng.choice([*[[]] * 6, ["0"], ["7"]])
            return f"'{kind}',[{' '.join([*(number(rng) for _ in range(count)), *extra])}]"
        kinds = list(FUNCTIONS) if self.tool == "fuzzylite" else list(OF_MATLAB)
        if not is_input and self.type == "tsukamoto":
            kinds = ["rampmf", "smf", "zmf", "sigmf", "concavemf"]
        kind = rng.choice(kinds)
        if self.tool == "fuzzylite" and rng.random() < 0.05:
            return rng.choice(["'function',[x / 12]", "'function',[sin(x) ^ 2 / 2]", "'function',[0.5]"])
        if kind == "constant":
            return f"'constant',[{rng.choice(['0.5', '1', '0'])}]"
        count = FUNCTIONS[kind]
        values = sorted(rng.uniform(0, 11) for _ in range(count))
        texts = [f"{v:.3f}" for v in values]
        if kind == "discretemf":
            texts[1::2] = ["0", "1"]
        if rng.random() < 0.1:
            rng.shuffle(texts)
        if rng.random() < 0.1:
            texts[rng.randrange(count)] = rng.choice(["Inf", "-Inf", "0", texts[0]])
        return f"'{kind}',[{' '.join([*texts, *rng.choice([*[[]] * 6, ['0'], ['0 0'], ['3']])])}]"

    def rule(self):
        rng = self.rng
        codes = [self.code(k) for k in range(self.inputs + self.outputs)]
        weight = rng.choice(["1", "1", "0.5", "1.000", "0"])
        left, right = " ".join(codes[: self.inputs]), " ".join(codes[self.inputs :])
        return f"{left}, {right} ({weight}) : {rng.choice('112')}"

    def code(self, k):
        rng = self.rng
        count = self.counts[k]
        digits = rng.randrange(1, count + 1) if rng.random() > 0.004 else count + 1
        fraction = ""
        if self.tool != "matlab" and rng.random() < 0.15:
            fraction = rng.choice([".05", ".2", ".3", ".4", ".99" if self.tool == "fuzzylite" else ".15"])
        sign = "-" if rng.random() < (0.15 if k < self.inputs else 0.03) else ""
        return "0" if rng.random() < 0.15 else f"{sign}{digits}{fraction}"


def fis(rng):
    """Draw a text."""
    return Fis(rng).text()
