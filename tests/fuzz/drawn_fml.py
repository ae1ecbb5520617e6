"""Texts of FML files drawn at random, as JFML and drafts have them: good and bad, as files in the wild are."""

import re
from xml.sax.saxutils import escape, quoteattr

NAMES = ["food", "rate in °/s", "a<b", "weight", "x", "any", "not", "1st", "food_", "low"]
TERMS = ["low", "very good", "high", "MED", "3rd", "any", "not", "low or above", "x"]
MODIFIERS = ["not", "very", "somewhat", "extremely", "intensify", "plus", "slightly", "more_or_less", "seldom"]
MODIFIERS += ["any", "norm", "above", "below", "VERY"]
NEGATED = ' complement="true"'
#: Values of attributes, words in elements, and names.
PARTS = [re.compile(pattern) for pattern in (r'"[^"]*"', r">[^<>\n]+<", r"[A-Za-z]\w+")]
T_NORMS = ["MIN", "PROD", "BDIF", "BSUM", "DRP", "DRS", "EPROD", "HPROD", "NILMIN"]
S_NORMS = ["MAX", "PROBOR", "BSUM", "DRS", "ESUM", "HSUM", "NILMAX"]
#: The numbers of each shape.
SHAPES = {
    "triangularShape": 3,
    "trapezoidShape": 4,
    "gaussianShape": 2,
    "leftGaussianShape": 2,
    "rightGaussianShape": 2,
}
SHAPES |= {"leftLinearShape": 2, "rightLinearShape": 2, "piShape": 2, "zShape": 2, "sShape": 2, "rectangularShape": 2}
SHAPES |= {"trapezoidalShape": 4, "singletonShape": 1}
POINT_SETS = ["pointSetShape", "pointSetMonotonicShape"]


def number(rng):
    return rng.choice([f"{rng.uniform(-1, 11):.3f}", str(rng.randrange(11)), "0.0", "1e1", "-2"])


class Fml:
    """One file.

    Args:
        rng: A random.Random.
    """

    def __init__(self, rng):
        self.rng = rng
        self.sort = rng.choice(["mamdani", "mamdani", "mamdani", "tsk", "tsukamoto", "mixed"])
        self.draft = self.sort == "mamdani" and rng.random() < 0.25
        self.inputs, self.outputs = rng.choice([1, 1, 2, 3]), rng.choice([1, 1, 2])
        self.names = rng.sample(NAMES, self.inputs + self.outputs)
        self.terms = {}
        #: The clauses that may stand in conditions, and in conclusions, by variable.
        self.composed = {}

    def maybe(self, text, chance=0.8):
        return text if self.rng.random() < chance else ""

    def text(self):
        rng = self.rng
        variables = [self.variable(name, k) for k, name in enumerate(self.names)]
        if rng.random() < 0.3:
            variables.append(self.aggregated())
        bases = [self.base(k) for k in range(rng.choice([1, 1, 1, 2, 3]))]
        if rng.random() < 0.1:
            rng.shuffle(variables)
        name = self.maybe(f" name={quoteattr(rng.choice(['tipper', 'brake - MAMDANI', 'x']))}")
        lines = [f"<fuzzySystem{name}>", " <knowledgeBase>", *variables, " </knowledgeBase>", *bases, "</fuzzySystem>"]
        text = '<?xml version="1.0"?>\n' + "\n".join(lines) + "\n"
        text = text.replace("param", "Param") if self.draft else text
        return self.exchanged(text) if rng.random() < 0.3 else text

    def exchanged(self, text):
        """Return a text in which one value, name or word is another one of it, or is empty."""
        rng = self.rng
        found = list(rng.choice(PARTS).finditer(text))
        place, other = rng.choice(found), rng.choice(found).group()
        if rng.random() < 0.1 and other[0] in '">':
            other = other[0] + other[-1]
        return text[: place.start()] + other + text[place.end() :]

    def tag(self, name):
        """Return the name of a shape, which begins with a capital in drafts."""
        return name[0].upper() + name[1:] if self.draft else name

    def variable(self, name, k):
        rng = self.rng
        is_input = k < self.inputs
        sort = rng.choice(["mamdani", "tsk", "tsukamoto"]) if self.sort == "mixed" else self.sort
        if not is_input and sort == "tsk":
            return self.functions(name)
        tsukamoto = not is_input and sort == "tsukamoto"
        tag = "tsukamoto" if tsukamoto else "fuzzy"
        low, high = rng.choice([("0", "10"), ("-1.5", "12"), ("0.0", "1")])
        attributes = f' domainleft="{low}" domainright="{high}" scale="{rng.choice(["", "%", "null", "m/s"])}"'
        attributes += ' type="input"' if is_input else ' type="output"'
        if not is_input and not tsukamoto:
            attributes += self.maybe(f' accumulation="{rng.choice([*S_NORMS, "SUM", "max"])}"', 0.6)
            attributes += self.maybe(f' defuzzifier="{rng.choice(["COG", "COA", "LM", "RM", "MOM", "mm"])}"', 0.7)
        attributes += self.maybe(f' defaultValue="{number(rng)}"', 0.3 if not is_input else 0)
        names = [rng.choice(TERMS) for _ in range(rng.choice([1, 2, 2, 3]))]
        self.terms[name] = list(dict.fromkeys(names))
        terms = [self.term(tag, n, tsukamoto, names[:k] if is_input else []) for k, n in enumerate(names)]
        return "\n".join([f"<{tag}Variable name={quoteattr(name)}{attributes}>", *terms, f"</{tag}Variable>"])

    def term(self, tag, name, tsukamoto, before):
        rng = self.rng
        attributes = self.maybe(f' complement="{rng.choice(["true", "false", "false"])}"', 0.3)
        shape = self.shape(tsukamoto)
        if before and rng.random() < 0.1:
            join = rng.choice(["and", "or"])
            words = T_NORMS if join == "and" else S_NORMS
            norm = self.maybe(f' t-{"co" if join == "or" else ""}norm="{rng.choice(words[:3])}"', 0.5)
            heads = [f"<termName{self.maybe(NEGATED, 0.3)}>" for _ in range(rng.choice([2, 2, 3]))]
            parts = "".join(f"{head}{escape(rng.choice(before))}</termName>" for head in heads)
            shape = f"<circularDefinition><{join}{norm}>{parts}</{join}></circularDefinition>"
            attributes = ""
        return f"<{tag}Term name={quoteattr(name)}{attributes}>\n {shape}\n</{tag}Term>"

    def shape(self, tsukamoto):
        rng = self.rng
        kinds = list(SHAPES)[:-1]
        if tsukamoto:
            kinds = ["leftLinearShape", "rightLinearShape", "zShape", "sShape", "leftGaussianShape"]
        kind = rng.choice([*kinds, *(POINT_SETS[tsukamoto:] if rng.random() < 0.5 else [])])
        if rng.random() < 0.03:
            kind = "singletonShape"
        if kind in POINT_SETS:
            places = sorted(rng.uniform(0, 10) for _ in range(3))
            degrees = sorted(rng.choice(["0", "0.3", "1"]) for _ in places) if tsukamoto else ["0", "1", "0.25"]
            if rng.random() < 0.2:
                degrees = ["0.5", "0.8", "0"]
            points = "".join(f'<point x="{x:.2f}" y="{y}"/>' for x, y in zip(places, degrees, strict=True))
            return f"<{self.tag(kind)}>{points}</{self.tag(kind)}>"
        values = sorted(rng.uniform(0, 10) for _ in range(SHAPES[kind]))
        if rng.random() < 0.05:
            rng.shuffle(values)
        if rng.random() < 0.05:
            values[-1] = values[0]
        given = " ".join(f'param{i}="{v:.3f}"' for i, v in enumerate(values, 1))
        return f"<{self.tag(kind)} {given}/>"

    def functions(self, name):
        rng = self.rng
        sugeno = rng.random() < 0.2
        self.terms[name] = names = rng.sample(TERMS, rng.choice([1, 2, 3]))
        lines = []
        for n in names:
            count = self.inputs + 1 if sugeno else rng.choice([1, self.inputs + 1])
            if sugeno:
                given = " ".join(f'param{i}="{number(rng)}"' for i in range(count))
                lines.append(f"<sugenoTerm name={quoteattr(n)} {given}/>")
                continue
            order = self.maybe(f' order="{0 if count == 1 else 1}"', 0.9)
            values = "".join(f"<tskValue>{number(rng)}</tskValue>" for _ in range(count))
            lines.append(f"<tskTerm name={quoteattr(n)}{order}>{values}</tskTerm>")
        tag = "takagiSugenoVariable" if sugeno else "tskVariable"
        attributes = self.maybe(' domainleft="-5" domainright="25"', 0.3) + self.maybe(' combination="WA"')
        return "\n".join([f'<{tag} name={quoteattr(name)} type="output"{attributes}>', *lines, f"</{tag}>"])

    def aggregated(self):
        parts = [f"<aggregatedFuzzyTerm name={quoteattr(n)}>{self.joined(2)}</aggregatedFuzzyTerm>" for n in TERMS[:2]]
        self.composed["quality"] = TERMS[:2]
        lines = "\n".join(parts)
        return f'<aggregatedFuzzyVariable name="quality" type="input">\n{lines}\n</aggregatedFuzzyVariable>'

    def joined(self, depth):
        rng = self.rng
        join = rng.choice(["and", "or"])
        norm = self.maybe(f' t-{"co" if join == "or" else ""}norm="{"MIN" if join == "and" else "MAX"}"', 0.5)
        parts = [
            self.joined(depth - 1) if depth > 1 and rng.random() < 0.3 else self.clause(self.names[: self.inputs])
            for _ in range(rng.choice([2, 2, 3]))
        ]
        if rng.random() < 0.1:
            parts[1] = parts[0]
        return f"<{join}{norm}>{''.join(parts)}</{join}>"

    def clause(self, variables, tag="clause", chance=0.25):
        rng = self.rng
        variable = rng.choice(variables)
        term = rng.choice(self.terms.get(variable) or self.composed[variable])
        if rng.random() < 0.002:
            term = "nothing"
        modifier = self.maybe(f' modifier="{rng.choice(MODIFIERS)}"', chance)
        if rng.random() < 0.05:
            negated = self.maybe(' NOT="true"', 0.3)
            return f"<{tag}{modifier} var={quoteattr(variable)} term={quoteattr(term)}{negated}/>"
        named = f"<variable>{escape(variable)}</variable>\n<term>{escape(term)}</term>"
        return f"<{tag}{modifier}>{named}</{tag}>"

    def base(self, k):
        rng = self.rng
        tag = rng.choice(["mamdaniRuleBase", "mamdaniRuleBase", "tskRuleBase", "tsukamotoRuleBase", "RuleBase"])
        attributes = f' name="{rng.choice(["rules1", "rules", f"base {k}"])}"'
        attributes += self.maybe(f' activationMethod="{rng.choice(T_NORMS)}"', 0.4)
        attributes += self.maybe(f' andMethod="{rng.choice([*T_NORMS, "min"])}"', 0.4)
        attributes += self.maybe(f' orMethod="{rng.choice(S_NORMS)}"', 0.4)
        rules = [self.rule(j) for j in range(rng.choice([1, 2, 3]))]
        return "\n".join([f"<{tag}{attributes}>", *rules, f"</{tag}>"])

    def rule(self, j):
        rng = self.rng
        tsk = "tsk" if rng.random() < 0.1 else ""
        connector = rng.choice(["and", "and", "or", "OR"])
        attributes = f' name="r{j}"' + self.maybe(f' connector="{connector}"')
        attributes += self.maybe(f' weight="{rng.choice(["1", "1.0", "0.5", "0"])}"', 0.5)
        attributes += self.maybe(f' {rng.choice(["andMethod", "operator"])}="{rng.choice(["MIN", "PROD"])}"', 0.1)
        variables = [*self.names[: self.inputs], *self.composed]
        if rng.random() < 0.1:
            variables += self.names[self.inputs :]
        clauses = "".join(self.clause(variables) for _ in range(rng.choice([1, 2, 2, 3])))
        outputs = self.names[self.inputs :]
        chance = 0.1 if self.sort == "mamdani" else 0.02
        conclusions = "".join(self.clause(outputs, "clause", chance) for _ in range(rng.choice([1, 1, 2])))
        then, other = (f"{tsk}Then", f"{tsk}Else") if tsk else ("then", "else")
        more = self.maybe(f"<{other}>{self.clause(outputs, 'clause', 0)}</{other}>", 0.08)
        consequent = f"{tsk}Consequent" if tsk else "consequent"
        body = f"<{then}>{conclusions}</{then}>" if rng.random() < 0.9 or more else conclusions
        tag = f"{tsk}Rule" if tsk else "rule"
        return (
            f"<{tag}{attributes}>\n<antecedent>{clauses}</antecedent>\n"
            f"<{consequent}>{body}{more}</{consequent}></{tag}>"
        )


def fml(rng):
    """Draw a text."""
    return Fml(rng).text()
