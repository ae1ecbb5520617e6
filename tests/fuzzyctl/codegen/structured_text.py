"""A machine for Structured Text: the grammar of IEC 61131-3 as far as it is written here, and what it means."""

import math
import re

from fuzzyctl.codegen.files import expected_of, sources

TOKEN = re.compile(
    r"\s*(?:(?P<comment>\(\*.*?\*\))|(?P<real>\d+\.\d+(?:E-?\d+)?)|(?P<int>\d+(?!\.\d))|(?P<name>[A-Za-z](?:_?[A-Za-z0-9])*)"
    r"|(?P<sign>:=|<=|>=|<>|\.\.|[-+*/<>=();:,\[\]]))",
    re.S,
)
KEYWORDS = {
    *"FUNCTION_BLOCK END_FUNCTION_BLOCK VAR VAR_INPUT VAR_OUTPUT END_VAR CONSTANT ARRAY OF IF THEN ELSE END_IF".split(),
    *"FOR TO DO END_FOR WHILE END_WHILE AND OR NOT MOD TRUE FALSE LREAL REAL DINT BOOL".split(),
}


def number(x):
    """Return a number that every machine takes: some order NaN in their own way, or stop at it."""
    assert x == x, "NaN is no argument"
    return x


def positive(x):
    assert number(x) > 0, "there is no logarithm"
    return x


STANDARD = {
    "MIN": lambda a, b: min(number(a), number(b)),
    "MAX": lambda a, b: max(number(a), number(b)),
    "LIMIT": lambda low, x, high: min(max(number(x), low), high),
    "ABS": abs,
    "SQRT": math.sqrt,
    "EXP": math.exp,
    "LN": lambda x: math.log(positive(x)),
    "SIN": math.sin,
    "COS": math.cos,
    "TAN": math.tan,
    "EXPT": math.pow,
    "TRUNC": int,
    "DINT_TO_LREAL": float,
    "DINT_TO_REAL": float,
}


class Block:
    """A function block: parsed by the grammar of IEC 61131-3 as far as it is used here, with its variables."""

    def __init__(self, text):
        self.tokens, place = [], 0
        text = text.rstrip()
        while place < len(text):
            found = TOKEN.match(text, place)
            assert found, f"no token at {text[place : place + 40]!r}"
            if found.lastgroup != "comment":
                word = found[found.lastgroup]
                if found.lastgroup == "name" and word in KEYWORDS:
                    self.tokens.append(("key", word))
                else:
                    # Names know no case.
                    self.tokens.append((found.lastgroup, word.lower() if found.lastgroup == "name" else word))
            place = found.end()
        self.next, self.variables, self.types, self.inputs, self.outputs = 0, {}, {}, [], []
        self.constants = set()
        self.parse()

    # grammar ---------------------------------------------------------------------------------------------------------

    def peek(self):
        return self.tokens[self.next][1] if self.next < len(self.tokens) else None

    def take(self, *wanted):
        kind, word = self.tokens[self.next]
        assert word in wanted or kind in wanted, f"{wanted} due, not {word!r}"
        self.next += 1
        return word

    def parse(self):
        self.take("FUNCTION_BLOCK")
        self.name = self.take("name")
        while self.peek() in ("VAR", "VAR_INPUT", "VAR_OUTPUT"):
            self.declarations(self.take("key"))
        self.body = self.statements("END_FUNCTION_BLOCK")
        assert self.next == len(self.tokens)

    def declarations(self, section):
        constant = self.peek() == "CONSTANT" and self.take("CONSTANT")
        while self.peek() != "END_VAR":
            name = self.take("name")
            assert name not in self.types, f"{name} is declared twice"
            assert name.upper() not in KEYWORDS | STANDARD.keys()
            self.take(":")
            kind, value = self.declared()
            self.types[name], self.variables[name] = kind, value
            {"VAR_INPUT": self.inputs, "VAR_OUTPUT": self.outputs}.get(section, []).append(name)
            if constant:
                self.constants.add(name)
            self.take(";")
        self.take("END_VAR")

    def declared(self):
        if self.peek() == "ARRAY":
            for word in ("ARRAY", "["):
                self.take(word)
            assert self.take("int") == "0"
            self.take("..")
            last = int(self.take("int"))
            for word in ("]", "OF"):
                self.take(word)
            kind = self.take("LREAL", "REAL", "BOOL")
            for word in (":=", "["):
                self.take(word)
            values = self.repeated_value()
            while self.peek() == ",":
                self.take(",")
                values += self.repeated_value()
            self.take("]")
            assert len(values) == last + 1
            return f"ARRAY OF {kind}", values
        kind = self.take("LREAL", "REAL", "DINT", "BOOL")
        value = {"DINT": 0, "BOOL": False}.get(kind, 0.0)
        if self.peek() == ":=":
            self.take(":=")
            value = self.signed()
        return kind, value

    def repeated_value(self):
        """Return the values of an entry: one, or `COUNT(VALUE)`."""
        if self.tokens[self.next][0] != "int":
            return [self.signed()]
        count = int(self.take("int"))
        self.take("(")
        value = self.signed()
        self.take(")")
        return [value] * count

    def signed(self):
        if self.peek() in ("TRUE", "FALSE"):
            return self.take("TRUE", "FALSE") == "TRUE"
        sign = -1.0 if self.peek() == "-" and self.take("-") else 1.0
        return sign * float(self.take("real"))

    def statements(self, *ends):
        found = []
        while self.peek() not in ends:
            found.append(self.statement())
        self.take(*ends) if ends[0] == "END_FUNCTION_BLOCK" else None
        return found

    def statement(self):
        special = {"IF": self.choice, "FOR": self.count, "WHILE": self.loop}.get(self.peek())
        if special:
            found = special()
        else:
            name = self.take("name")
            assert name in self.types, f"{name} is not declared"
            assert name not in self.constants
            index = None
            if self.peek() == "[":
                self.take("[")
                index = self.expression()
                self.take("]")
            self.take(":=")
            found = ("set", name, index, self.expression())
        self.take(";")
        return found

    def choice(self):
        self.take("IF")
        test = self.expression()
        self.take("THEN")
        then, otherwise = self.statements("ELSE", "END_IF"), []
        if self.peek() == "ELSE":
            self.take("ELSE")
            otherwise = self.statements("END_IF")
        self.take("END_IF")
        return "if", test, then, otherwise

    def count(self):
        self.take("FOR")
        name = self.take("name")
        self.take(":=")
        first = self.expression()
        self.take("TO")
        last = self.expression()
        return "for", name, first, last, self.repeated("END_FOR")

    def loop(self):
        self.take("WHILE")
        return "while", self.expression(), self.repeated("END_WHILE")

    def repeated(self, end):
        self.take("DO")
        body = self.statements(end)
        self.take(end)
        return body

    def expression(self, level=0):
        levels = [("OR",), ("AND",), ("=", "<>"), ("<", ">", "<=", ">="), ("+", "-"), ("*", "/", "MOD")]
        if level == len(levels):
            return self.unary()
        left = self.expression(level + 1)
        while self.peek() in levels[level]:
            left = (self.take(*levels[level]), left, self.expression(level + 1))
        return left

    def unary(self):
        if self.peek() in ("-", "NOT"):
            return (f"unary {self.take('-', 'NOT')}", self.unary())
        kind, word = self.tokens[self.next]
        self.next += 1
        if word == "(":
            inner = self.expression()
            self.take(")")
            return inner
        if word in ("TRUE", "FALSE"):
            return ("value", word == "TRUE")
        if kind in ("real", "int"):
            return ("value", float(word) if kind == "real" else int(word))
        assert kind == "name", f"no value begins with {word!r}"
        if self.peek() == "(":
            arguments = []
            while self.take("(", ","):
                arguments.append(self.expression())
                if self.peek() == ")":
                    break
            self.take(")")
            return ("call", word.upper(), arguments)
        assert word in self.types, f"{word} is not declared"
        if self.peek() == "[":
            self.take("[")
            index = self.expression()
            self.take("]")
            return ("item", word, index)
        return ("name", word)

    # meaning ---------------------------------------------------------------------------------------------------------

    def __call__(self, **inputs):
        assert set(inputs) == set(self.inputs)
        self.variables |= inputs
        self.run(self.body)
        return [self.variables[o] for o in self.outputs]

    def run(self, statements):
        for statement in statements:
            match statement:
                case ("set", name, index, value):
                    found, declared = self.value(value), self.types[name]
                    assert (index is not None) == declared.startswith("ARRAY OF ")
                    kind = {"BOOL": bool, "DINT": int}.get(declared.removeprefix("ARRAY OF "), float)
                    assert type(found) is kind, f"{name} : {declared} := {found}"
                    if index is None:
                        self.variables[name] = found
                    else:
                        place = self.value(index)
                        assert 0 <= place < len(self.variables[name]), f"{name}[{place}]"
                        self.variables[name][place] = found
                case ("if", test, then, otherwise):
                    found = self.value(test)
                    assert type(found) is bool
                    self.run(then if found else otherwise)
                case ("for", name, first, last, body):
                    for k in range(self.value(first), self.value(last) + 1):
                        self.variables[name] = k
                        self.run(body)
                case ("while", test, body):
                    while self.value(test):
                        self.run(body)

    def value(self, node):
        match node:
            case ("value", value):
                return value
            case ("name", name):
                return self.variables[name]
            case ("item", name, index):
                place = self.value(index)
                assert 0 <= place < len(self.variables[name]), f"{name}[{place}]"
                return self.variables[name][place]
            case ("unary -", operand):
                return -self.value(operand)
            case ("unary NOT", operand):
                return not self.value(operand)
            case ("call", function, arguments):
                return STANDARD[function](*map(self.value, arguments))
        sign, a, b = node[0], self.value(node[1]), self.value(node[2])
        assert type(a) is type(b), f"{a} {sign} {b}: no conversion is implied"
        match sign:
            case "OR":
                return a or b
            case "AND":
                return a and b
            case "/":
                return a / b  # which stops at a quotient by zero
        return {
            "MOD": lambda: a % b,
            "+": lambda: a + b,
            "-": lambda: a - b,
            "*": lambda: a * b,
            "<": lambda: a < b,
            ">": lambda: a > b,
            "<=": lambda: a <= b,
            ">=": lambda: a >= b,
            "=": lambda: a == b,
            "<>": lambda: a != b,
        }[sign]()


def differences(unit):
    """Run all vectors through the block; return the largest error in parts of the tolerance."""
    block = Block(*sources(unit, "st").values())
    worst = 0.0
    names = [n for n in block.inputs if n != "time_step"]
    step = {"time_step": 0.01} if "time_step" in block.inputs else {}
    for vector in expected_of(unit).vectors:
        found = block(**dict(zip(names, vector.inputs, strict=True)), **step)
        for k, wanted in enumerate(vector.outputs):
            value, valid = found[2 * k], found[2 * k + 1]
            assert valid == (wanted == wanted), f"{vector} {found}"
            if valid:
                worst = max(worst, abs(value - wanted) / unit.tolerance(k))
            else:
                assert value == 0.0
    return worst
