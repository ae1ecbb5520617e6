"""Generated Structured Text, read by a parser of its grammar and run: the numbers are those of the kernels."""

import math
import re
from itertools import product

import pytest

from fuzzyctl import compile, loads
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.names import ST_RESERVED
from fuzzyctl.codegen.st_source import function_block
from fuzzyctl.codegen.unit import prepare
from fuzzyctl.codegen.vectors import STEP, vectors

TOKEN = re.compile(
    r"\s*(?:(?P<comment>\(\*.*?\*\))|(?P<real>\d+\.\d+(?:E-?\d+)?)|(?P<int>\d+(?!\.\d))|(?P<name>[A-Za-z](?:_?[A-Za-z0-9])*)"
    r"|(?P<sign>:=|<=|>=|<>|\.\.|[-+*/<>=();:,\[\]]))",
    re.S,
)
KEYWORDS = {
    *"FUNCTION_BLOCK END_FUNCTION_BLOCK VAR VAR_INPUT VAR_OUTPUT END_VAR CONSTANT ARRAY OF IF THEN ELSE END_IF".split(),
    *"FOR TO DO END_FOR WHILE END_WHILE AND OR NOT TRUE FALSE LREAL REAL DINT BOOL".split(),
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
            assert name not in ST_RESERVED
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
            kind = self.take("LREAL", "REAL")
            for word in (":=", "["):
                self.take(word)
            values = [self.signed()]
            while self.peek() == ",":
                self.take(",")
                values.append(self.signed())
            self.take("]")
            assert len(values) == last + 1
            return f"ARRAY OF {kind}", values
        kind = self.take("LREAL", "REAL", "DINT", "BOOL")
        value = {"DINT": 0, "BOOL": False}.get(kind, 0.0)
        if self.peek() == ":=":
            self.take(":=")
            value = self.signed()
        return kind, value

    def signed(self):
        sign = -1.0 if self.peek() == "-" and self.take("-") else 1.0
        return sign * float(self.take("real"))

    def statements(self, *ends):
        found = []
        while self.peek() not in ends:
            found.append(self.statement())
        self.take(*ends) if ends[0] == "END_FUNCTION_BLOCK" else None
        return found

    def statement(self):
        if self.peek() == "IF":
            self.take("IF")
            test = self.expression()
            self.take("THEN")
            then, otherwise = self.statements("ELSE", "END_IF"), []
            if self.peek() == "ELSE":
                self.take("ELSE")
                otherwise = self.statements("END_IF")
            self.take("END_IF")
            self.take(";")
            return "if", test, then, otherwise
        if self.peek() == "FOR":
            self.take("FOR")
            name = self.take("name")
            self.take(":=")
            first = self.expression()
            self.take("TO")
            last = self.expression()
            self.take("DO")
            body = self.statements("END_FOR")
            self.take("END_FOR")
            self.take(";")
            return "for", name, first, last, body
        if self.peek() == "WHILE":
            self.take("WHILE")
            test = self.expression()
            self.take("DO")
            body = self.statements("END_WHILE")
            self.take("END_WHILE")
            self.take(";")
            return "while", test, body
        name = self.take("name")
        assert name in self.types, f"{name} is not declared"
        assert name not in self.constants
        self.take(":=")
        value = self.expression()
        self.take(";")
        return "set", name, value

    def expression(self, level=0):
        levels = [("OR",), ("AND",), ("=", "<>"), ("<", ">", "<=", ">="), ("+", "-"), ("*", "/")]
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
            while self.take("(", ",") and True:
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
                case ("set", name, value):
                    found = self.value(value)
                    kinds = {"BOOL": bool, "DINT": int}
                    assert type(found) is kinds.get(self.types[name], float), f"{name} : {self.types[name]} := {found}"
                    self.variables[name] = found
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
    block = Block(function_block(unit))
    worst = 0.0
    names = [n for n in block.inputs if n != "time_step"]
    step = {"time_step": STEP} if "time_step" in block.inputs else {}
    for vector in vectors(unit):
        found = block(**dict(zip(names, vector.inputs, strict=True)), **step)
        for k, wanted in enumerate(vector.outputs):
            value, valid = found[2 * k], found[2 * k + 1]
            assert valid == (wanted == wanted), f"{vector} {found}"
            if valid:
                worst = max(worst, abs(value - wanted) / unit.tolerance(k))
            else:
                assert value == 0.0
    return worst


GUARDED = """system s
and product
defuzzifier weighted_average
input x in [-4, 4]
  low  = triangle(-inf, -3, 1)
  high = triangle(-1, 3, inf)
input y in [-2, 2]
  on = function({degree})
  off = triangle(-inf, -1, 1)
output u in [-9, 9] else nan
  p = constant(1)
  q = function({value})
if x is low and y is off then u is p
if x is high or y is on then u is q
"""


class TestGuards:
    """Functions are called only where they have a value: the machine of this test stops elsewhere."""

    @pytest.mark.parametrize(
        "value",
        [
            *("sqrt(x)", "log(x)", "1 / x", "x^0.5", "x^(-2)", "x^(-0.5)", "(x - 1)^y", "0 * log(y)", "sqrt(y) / y"),
            *(
                "max(sqrt(x), y)",
                "max(y, sqrt(x))",
                "min(log(x), 2) + sqrt(y)",
                "abs(sqrt(x))",
                "1 / (1 + 1 / (x * x))",
            ),
            *("lt(x, y)", "ne(sqrt(x), y) + eq(y, y)", "ge(x, y) * le(1 / x, y) - gt(x, 0.5)", "ne(x, y)"),
            *("exp(-1 / (x * x))", "sign(sqrt(x))", "sqrt(sqrt(x) - 1)", "1 / sqrt(x)", "log(1 / x)", "sin(1 / y)"),
        ],
    )
    def test_give_the_numbers_and_validity_of_the_kernel(self, value):
        text = GUARDED.format(value=value, degree="y / 2")
        unit = prepare(loads(text), text)
        assert differences(unit) <= 1.0
        assert sum(v.outputs[0] == v.outputs[0] for v in vectors(unit)) > 20

    @pytest.mark.parametrize("degree", ["sqrt(y)", "log(y)", "1 / y", "max(sqrt(y), 0.2)", "1 - y^0.5"])
    def test_of_degrees_do_too(self, degree):
        text = GUARDED.format(value="x", degree=degree)
        assert differences(prepare(loads(text), text)) <= 1.0

    def test_of_rates_do_too(self):
        text = GUARDED.format(value="x", degree="y / 2").replace("else nan", "else nan adaptive rate sqrt(x) / y")
        text = text.replace("function(x)", "constant(2)")
        assert differences(prepare(loads(text), text)) <= 1.0

    def test_a_lost_guard_is_found(self):
        text = GUARDED.format(value="sqrt(x)", degree="y / 2")
        written = function_block(prepare(loads(text), text))
        test = re.search(r"\(v\d+ < 0\.0\)(?= THEN\n +v\d+ := 0\.0;\n +v\d+_no := TRUE)", written)
        with pytest.raises(ValueError, match="math domain error"):
            Block(written.replace(test[0], "FALSE"))(x=-1.0, y=1.0)


INFINITE = """system s
and product
defuzzifier weighted_average
input x in [0, 10] extrapolate
  low  = triangle(-inf, 1, 4)
  high = triangle(1, 4, inf)
input y in [-1, 1] extrapolate
  down = gaussian(0, 1)
  up   = triangle(-0.6, 0.4, inf)
output u in [-50, 50] {adaptive}else -1
  a = {first}
  b = {second}
if x is low or y is up then u is a
if x is high and y is down then u is b
"""


class TestInfinity:
    """The machine of these tests stops where a selection is handed NaN."""

    @pytest.mark.parametrize(
        ("first", "second"),
        [
            ("function(x - y)", "function(2 * x - x * y)"),
            ("linear(1, -1, 0)", "constant(3)"),
            ("function(min(x - y, 4))", "function(max(3, x * y))"),
            ("function(sqrt(abs(x)) - y)", "function(x / (y - 7))"),
        ],
    )
    def test_less_infinity_and_times_zero_has_no_value(self, first, second):
        system = loads(INFINITE.format(first=first, second=second, adaptive=""))
        block, kernel = Block(function_block(prepare(system, ""))), compile(system, "python")
        places = [math.inf, -math.inf, 1e308, -1e308, 0.0, 2.5]
        undefined = 0
        for x, y in product(places, places):
            value, valid = block(x=x, y=y)
            wanted = kernel(x, y)
            assert valid == (wanted == wanted), (x, y)
            assert value == (pytest.approx(wanted, rel=1e-12) if valid else 0.0), (x, y)
            undefined += not valid
        assert 0 < undefined < len(places) ** 2

    def test_in_a_rate_keeps_the_consequent(self):
        text = INFINITE.format(first="constant(1)", second="constant(3)", adaptive="adaptive rate x - y ")
        block = Block(function_block(prepare(loads(text), "")))
        assert block(x=2.5, y=0.5, time_step=0.125)[1]
        before = block.variables["consequent_0"]
        assert before > 1.0
        block(x=math.inf, y=math.inf, time_step=0.125)
        assert block.variables["consequent_0"] == before

    def test_costs_nothing_where_inputs_are_clamped(self):
        text = INFINITE.format(first="linear(1, -1, 0)", second="constant(3)", adaptive="")
        assert "<>" in function_block(prepare(loads(text), ""))
        assert "<>" not in function_block(prepare(loads(text.replace(" extrapolate", "")), ""))


class TestNumbers:
    def test_are_those_of_the_kernel(self, unit_of, kind):
        assert differences(unit_of(kind)) <= 1.0

    def test_of_rules_too_where_the_system_interpolates(self, unit_of):
        assert differences(unit_of("ais_reaction", algorithm="rules")) <= 1.0

    def test_of_a_table(self, unit_of):
        assert differences(unit_of("ais_reaction", table=21)) <= 1.0

    def test_a_wrong_number_is_found(self, unit_of):
        unit = unit_of("boundary_layer")
        text = function_block(unit)
        assert "0.0275" in text
        block = Block(text.replace("0.0275", "0.0274"))
        assert block(abs_sigma=0.03)[0] != pytest.approx(Block(text)(abs_sigma=0.03)[0], rel=1e-6)

    def test_single_precision_is_declared_and_within_its_tolerance(self, unit_of):
        unit = unit_of("ais_reaction", precision="float")
        assert "LREAL" not in function_block(unit)
        assert differences(unit) <= 1.0


class TestText:
    def test_names_that_differ_by_case_only_are_told_apart(self):
        text = (
            "system If\ndefuzzifier weighted_average\ninput X in [0, 1]\n  terms a b\ninput x in [0, 1]\n  terms a b\n"
            "output Y in [0, 1]\n  p = constant(0)\n  q = constant(1)\nif X is a then Y is p\nif x is b then Y is q\n"
            "if X is b or x is a then Y is q\n"
        )
        block = Block(function_block(prepare(loads(text), text)))
        assert block.name == "If_fz".lower()
        assert len({*block.inputs}) == 2

    def test_a_title_cannot_leave_its_comment(self, unit_of):
        unit = unit_of("boundary_layer")
        system = unit.system.model_copy(update={"title": "ends *) here (* there"})
        changed = type(unit)(**{f: getattr(unit, f) for f in unit.__dataclass_fields__} | {"system": system})
        assert Block(function_block(changed)).name == "boundary_layer"

    def test_a_function_without_a_standard_one_is_refused(self):
        text = (
            "system s\ndefuzzifier weighted_average\ninput x in [0, 1]\n  terms a b\noutput y in [-9, 9]\n"
            "  p = function(atan2(x, 2))\n  q = constant(1)\nif x is a then y is p\nif x is b then y is q\n"
        )
        with pytest.raises(CodegenError, match="atan2"):
            function_block(prepare(loads(text), text))
        for function in ("floor", "fmod"):
            rounding = text.replace("atan2(x, 2)", "round(x) + x" if function == "floor" else "mod(x, 2)")
            with pytest.raises(CodegenError, match=function):
                function_block(prepare(loads(rounding), rounding))

    def test_what_is_held_at_first_must_be_a_number(self):
        text = (
            "system s\ninput x in [0, 9]\n  low = triangle(-inf, 0, 4)\noutput y in [0, 1] else hold({})\n"
            "  p = triangle(0, 0.5, 1)\nif x is low then y is p\n"
        )
        with pytest.raises(CodegenError, match="'y' holds NaN at first"):
            function_block(prepare(loads(text.format("nan")), text))
        assert "held_y : LREAL := 0.25;" in function_block(prepare(loads(text.format("0.25")), text))
