"""FML as JFML writes it, as drafts had it, and as people break it."""

import math

import pytest

from tests.effort import at_most
from tests.fuzzyctl.formats.files import errors as errors_of
from tests.fuzzyctl.formats.files import examined, read, rules, said
from tests.sizes import examples

FOOD = """<fuzzyVariable name="food" scale="" domainleft="0.0" domainright="10.0" type="input">
<fuzzyTerm name="rancid" complement="false"><triangularShape param1="0.0" param2="2.0" param3="5.5"/></fuzzyTerm>
<fuzzyTerm name="delicious" complement="false">SHAPE</fuzzyTerm>
</fuzzyVariable>"""
TIP = """<fuzzyVariable name="tip" scale="%" domainleft="0" domainright="20" type="output" SETTINGS>
<fuzzyTerm name="cheap"><triangularShape param1="0" param2="5" param3="10"/></fuzzyTerm>
<fuzzyTerm name="generous"><triangularShape param1="10" param2="15" param3="20"/></fuzzyTerm>
</fuzzyVariable>"""
TSK = """<tskVariable name="tip" scale="" type="output" combination="WA" defaultValue="0.5">
<tskTerm name="cheap" order="0"><tskValue>1.6</tskValue></tskTerm>
<tskTerm name="generous" order="1"><tskValue>1.9</tskValue><tskValue>5.6</tskValue></tskTerm>
</tskVariable>"""
TRAPEZOID = '<trapezoidShape param1="5" param2="8" param3="10" param4="10"/>'


def clause(variable, term, modifier=""):
    said = f' modifier="{modifier}"' if modifier else ""
    return f"<clause{said}>\n  <variable>{variable}</variable>\n  <term>{term}</term>\n</clause>"


def rule(*clauses, then="cheap", attributes='connector="and" weight="1.0"', more="", tsk=False):
    p, names = ("tsk", ("tskRule", "tskConsequent", "tskThen", "tskClause")) if tsk else ("", ())
    tag, consequent, then_tag, clause_tag = names or ("rule", "consequent", "then", "clause")
    conclusion = clause("tip", then).replace("clause>", f"{clause_tag}>")
    return (
        f'<{tag} name="r{p}" {attributes}><antecedent>{"".join(clauses)}</antecedent>'
        f"<{consequent}><{then_tag}>{conclusion}</{then_tag}>{more}</{consequent}></{tag}>"
    )


RULES = rule(clause("food", "rancid")) + rule(clause("food", "delicious"), then="generous")


def document(shape=TRAPEZOID, settings="", rules=RULES, knowledge="", tip=TIP, base="mamdaniRuleBase", methods=""):
    return (
        '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'
        '<fuzzySystem xmlns="http://www.ieee1855.org" name="tipper - MAMDANI">\n<knowledgeBase>\n'
        f"{FOOD.replace('SHAPE', shape)}\n{knowledge}{tip.replace('SETTINGS', settings)}\n</knowledgeBase>\n"
        f'<{base} name="rules" {methods}>\n{rules}\n</{base}>\n</fuzzySystem>\n'
    )


def sound(text):
    return read("fml", text)


def errors(text):
    return errors_of("fml", text)


def codes(text):
    return [code for code, *_ in said("fml", text)]


def test_its_numbers():
    # Food 1: rancid to 0.5, and the triangle cut there has its centre of gravity at 5.
    system = read("x.xml", document())
    assert system(food=1) == pytest.approx(5.0, abs=1e-12)
    assert system(food=5.25 / 2 + 5.5) == pytest.approx(15.0, abs=1e-12)


def test_an_output_without_a_default_is_0_where_no_rule_fires_as_the_standard_has_it():
    far = '<triangularShape param1="8" param2="9" param3="10"/>'
    assert sound(document(far))(food=7) == 0.0


MONOTONE_POINTS = """<pointSetMonotonicShape interpolationMethod="linear">
  <point x="0" y="0"/><point x="10" y="0.8"/><point x="20" y="1"/></pointSetMonotonicShape>"""


@pytest.mark.parametrize(
    ("shape", "place"),
    [
        # The place whose degree is exp(-1/2), one deviation from the center.
        ('<rightGaussianShape param1="15" param2="2"/>', 13.0),
        ('<leftGaussianShape param1="5" param2="2"/>', 7.0),
        (MONOTONE_POINTS, 10 * math.exp(-0.5) / 0.8),
    ],
)
def test_one_sided_gaussians_and_monotone_points_are_inverted(shape, place):
    text = f"""<fuzzySystem name="t"><knowledgeBase>
<fuzzyVariable name="x" domainleft="0" domainright="1" type="input">
<fuzzyTerm name="on"><triangularShape param1="0" param2="1" param3="1"/></fuzzyTerm></fuzzyVariable>
<tsukamotoVariable name="y" domainleft="0" domainright="20" type="output" combination="WA">
<tsukamotoTerm name="a">{shape}</tsukamotoTerm></tsukamotoVariable></knowledgeBase>
<tsukamotoRuleBase name="r"><rule name="1">
<antecedent><clause><variable>x</variable><term>on</term></clause></antecedent>
<consequent><then><clause><variable>y</variable><term>a</term></clause></then></consequent></rule>
</tsukamotoRuleBase></fuzzySystem>"""
    assert sound(text)(x=math.exp(-0.5)) == pytest.approx(place, rel=1e-14)


def test_what_tools_read_differently_is_reported_once_for_each():
    shapes = '<leftLinearShape param1="1" param2="2"/>'
    both = document(shapes).replace('<triangularShape param1="0.0" param2="2.0" param3="5.5"/>', shapes)
    assert codes(both) == ["FZ609"]
    assert codes(document('<piShape param1="1" param2="2"/>')) == ["FZ609"]
    assert codes(document(tip=TSK, base="tskRuleBase", rules=rule(clause("food", "rancid"), tsk=True)))[0] == "FZ609"


ONE_OR_ZERO = """<tskVariable name="tip" type="output">
<tskTerm name="one" order="0"><tskValue>1</tskValue></tskTerm>
<tskTerm name="zero" order="0"><tskValue>0</tskValue></tskTerm>
</tskVariable>"""


def degree_of(modifier, shape, x, *, more=""):
    """Return the degree of `food is MODIFIER delicious`: 1 counts with it, beside 0, which counts with 1."""
    rules = rule(clause("food", "delicious", modifier), then="one", tsk=True)
    rules += rule(clause("food", "delicious", "any"), then="zero", tsk=True) + more
    system = sound(document(shape=shape, rules=rules, tip=ONE_OR_ZERO, base="tskRuleBase"))
    y = system(food=x)
    return y / (1 - y)


@pytest.mark.parametrize(
    ("shape", "places"),
    [
        ('<triangularShape param1="2" param2="5" param3="9"/>', {1: (0, 1), 3.5: (0, 0.5), 5: (0, 0), 8: (0.75, 0)}),
        (
            '<trapezoidShape param1="1" param2="3" param3="5" param4="9"/>',
            {2: (0, 0.5), 4: (0, 0), 8: (0.75, 0), 10: (1, 0)},
        ),
        (
            '<gaussianShape param1="5" param2="2"/>',
            {3: (0, 1 - math.exp(-0.5)), 5: (0, 0), 7: (1 - math.exp(-0.5), 0)},
        ),
        ('<leftGaussianShape param1="5" param2="2"/>', {3: (0, 0), 7: (1 - math.exp(-0.5), 0)}),
        ('<rightLinearShape param1="2" param2="6"/>', {1: (0, 1), 4: (0, 0.5), 7: (0, 0)}),
        ('<leftLinearShape param1="2" param2="6"/>', {1: (0, 0), 4: (0.5, 0), 7: (1, 0)}),
        ('<sShape param1="2" param2="6"/>', {1: (0, 1), 4: (0, 0.5), 7: (0, 0)}),
        ('<zShape param1="2" param2="6"/>', {1: (0, 0), 4: (0.5, 0), 7: (1, 0)}),
        ('<piShape param1="2" param2="6"/>', {4: (0, 0.5), 6: (0, 0), 8: (0.5, 0)}),
        ('<rectangularShape param1="2" param2="6"/>', {1: (0, 1), 4: (0, 0), 7: (1, 0)}),
        ('<singletonShape param1="4"/>', {3: (0, 1), 4: (0, 0), 5: (1, 0)}),
        (
            '<pointSetShape><point x="3" y="1"/><point x="1" y="0.2"/><point x="4" y="1"/>'
            '<point x="8" y="0"/></pointSetShape>',
            {2: (0, 0.4), 3.5: (0, 0), 6: (0.5, 0), 9: (1, 0)},
        ),
    ],
    ids=lambda v: v.split()[0] if isinstance(v, str) else "",
)
def test_above_and_below_are_the_complement_beyond_the_place_where_a_term_is_largest(shape, places):
    for x, (above, below) in places.items():
        assert degree_of("above", shape, x) == pytest.approx(above, abs=1e-14), x
        assert degree_of("below", shape, x) == pytest.approx(below, abs=1e-14), x


@pytest.mark.parametrize("x", [0.0, 0.3, 0.6474639298936405, 0.8, 1.0])
def test_slightly_is_plus_and_not_very_made_to_reach_one_and_intensified(x):
    part = min(x**1.25, 1 - x**2) / 0.580790459486683
    expected = 2 * part**2 if part <= 0.5 else 1 - 2 * (1 - part) ** 2
    shape = '<rightLinearShape param1="0" param2="10"/>'
    assert degree_of("slightly", shape, 10 * x) == pytest.approx(expected, abs=1e-14)
    _, diagnostics = examined("fml", document(rules=rule(clause("food", "delicious", "slightly"))))
    assert [d.message for d in diagnostics if "slightly" in d.message] == [
        "'slightly' is plus and not very by the smaller degree, made to reach 1; JFML takes their product"
    ]


@pytest.mark.parametrize("x", [0.0, 0.3, 0.5, 0.8, 1.0])
def test_intensify_and_extremely_are_two_hedges(x):
    shape = '<rightLinearShape param1="0" param2="10"/>'
    no_more = 'connector="and" weight="0"'
    more = rule(clause("food", "delicious", "extremely"), then="one", tsk=True, attributes=no_more)
    intensified = 2 * x**2 if x <= 0.5 else 1 - 2 * (1 - x) ** 2
    assert degree_of("intensify", shape, 10 * x, more=more) == pytest.approx(intensified, abs=1e-14)
    more = rule(clause("food", "delicious", "intensify"), then="one", tsk=True, attributes=no_more)
    assert degree_of("extremely", shape, 10 * x, more=more) == pytest.approx(x**3, abs=1e-14)


def defined(joined):
    term = f'<aggregatedFuzzyTerm name="bad">{joined}</aggregatedFuzzyTerm>'
    return f'<aggregatedFuzzyVariable name="quality" type="input">{term}</aggregatedFuzzyVariable>'


EITHER = (
    f'<or t-conorm="MAX">{clause("food", "rancid")}<and t-norm="MIN">'
    f"{clause('food', 'delicious', 'not')}{clause('food', 'rancid', 'very')}</and></or>"
)


@pytest.mark.parametrize(
    ("joined", "word"),
    [(EITHER.replace("MIN", "PROD"), "very"), (EITHER.replace("MAX", "PROBOR"), "plus"), (EITHER, "slightly")],
)
def test_other_modifiers_of_terms_that_others_define_are_refused(joined, word):
    text = document(knowledge=defined(joined), rules=rule(clause("quality", "bad", word)))
    assert [(d.code, d.message) for d in errors(text)] == [
        ("FZ602", f"the modifier '{word}' of 'bad', which is defined by others, is not available")
    ]


def test_data_clouds_are_refused_and_not_missed_as_inputs():
    text = (
        '<fuzzySystem name="t"><knowledgeBase><anYaDataCloud name="food"><datum>1</datum></anYaDataCloud>'
        f'{TIP.replace("SETTINGS", "")}</knowledgeBase><anYaRuleBase name="r"/></fuzzySystem>'
    )
    _, diagnostics = examined("fml", text)
    assert [d.message for d in diagnostics] == [
        "AnYa data clouds are not available",
        "AnYa rule bases are not available",
    ]


def test_many_terms_of_one_name_are_told_apart_in_time():
    one = '<fuzzyTerm name="rancid"><triangularShape param1="0" param2="2" param3="5"/></fuzzyTerm>'
    with at_most(5):
        system = sound(document(shape=TRAPEZOID).replace("</fuzzyVariable>", f"{one * 2000}</fuzzyVariable>", 1))
        assert len({t.name for t in system.inputs[0].terms}) == 2002


LOW_POINTS = '<pointSetShape><point x="1" y="0"/><point x="3" y="0.8"/><point x="8" y="0"/></pointSetShape>'
TWO_PEAKS = (
    '<pointSetShape><point x="1" y="1"/><point x="3" y="0.8"/><point x="4" y="1"/><point x="8" y="0"/></pointSetShape>'
)


@pytest.mark.parametrize(
    ("modifier", "shape", "message"),
    [
        ("norm", LOW_POINTS, "'norm' of 'delicious', whose degrees do not reach 1, is not available"),
        ("slightly", LOW_POINTS, "'slightly' of 'delicious', whose degrees do not reach 1, is not available"),
        ("above", LOW_POINTS, "'above' of 'delicious', which has several peaks or none of 1, is not available"),
        ("below", TWO_PEAKS, "'below' of 'delicious', which has several peaks or none of 1, is not available"),
        ("custom_bent", TWO_PEAKS, "there is no modifier 'custom_bent'"),
    ],
)
def test_modifiers_that_cannot_be_had_are_refused_where_they_stand(modifier, shape, message):
    text = document(shape=shape, rules=rule(clause("food", "delicious", modifier)))
    (found,) = errors(text)
    assert (found.code, found.message) == ("FZ602", message)
    assert text[found.span.start : found.span.end] == f'"{modifier}"'


def test_no_set_is_above_a_function_of_the_inputs():
    (error,) = errors(document(tip=TSK, base="tskRuleBase", rules=rule(clause("tip", "generous", "above"), tsk=True)))
    assert error.message == "'above' of 'generous', which has several peaks or none of 1, is not available"


def test_a_name_with_line_ends_is_the_same_in_attributes_and_elements():
    broken = document().replace('name="food"', 'name="good\n  food"').replace('name="rancid"', 'name="very&#10;old"')
    broken = broken.replace(">food<", ">\n good   food\n<").replace(">rancid<", ">very\told<")
    system = sound(broken)
    assert (system.inputs[0].name, system.inputs[0].label) == ("good_food", "good food")
    assert rules("fml", broken)[0] == "if good_food is very_old then tip is cheap"


def test_a_definition_that_uses_itself_is_reported():
    circular = (
        "<circularDefinition><or><termName>rancid</termName><termName>delicious</termName></or></circularDefinition>"
    )
    assert errors(document(circular))[0].code == "FZ106"


def test_the_dialect_of_pyit2fls():
    text = document(base="RuleBase").replace("fuzzySystem", "FuzzySystem").replace("knowledgeBase", "KnowledgeBase")
    short = '<Rule name="a" connector="and"><Antecedent><Clause var="food" term="rancid" NOT="true"/></Antecedent>'
    short += '<Consequent><Clause var="tip" term="cheap"/></Consequent></Rule>'
    assert rules("fml", text.replace(RULES, short)) == ["if food is not rancid then tip is cheap"]


def test_an_unknown_attribute_is_reported_and_not_dropped_silently():
    assert codes(document().replace("weight=", "wieght=")) == ["FZ603", "FZ603"]
    assert codes(document().replace('name="tipper', 'networkAddress="10.0.0.7" name="tipper')) == ["FZ603"]


@pytest.mark.parametrize(
    ("tag", "behind"),
    [
        ("antecedent", "</antecedent>"),
        ("consequent", "</consequent>"),
        ("then", "</then>"),
        ("else", "<consequent>"),
        ("variable", "</variable>"),
        ("term", "</term>"),
    ],
)
def test_what_a_rule_has_once_is_not_dropped_where_it_stands_twice(tag, behind):
    text = document(rules=rule(clause("food", "rancid")))
    again = f"<{tag}>{clause('food', 'delicious') if tag == 'antecedent' else clause('tip', 'generous')}</{tag}>"
    changed = text.replace(behind, behind + again * (2 if tag == "else" else 1), 1)
    (error,) = (e for e in errors(changed) if e.code == "FZ215")
    assert error.message.startswith(f"a second <{tag}> in <")
    assert error.span.start == changed.rindex(again)


def test_more_parameters_than_inputs_have_no_effect_which_is_reported():
    tip = (
        '<takagiSugenoVariable name="tip"><sugenoTerm name="cheap" param0="1" param1="2" PARAM/></takagiSugenoVariable>'
    )
    text = document(rules=rule(clause("food", "delicious"), tsk=True), tip=tip, base="tskRuleBase")
    assert codes(text.replace("PARAM", "")) == []
    assert codes(text.replace("PARAM", 'param2="3"')) == ["FZ603"]


def test_drafts_accumulate_by_the_plain_sum_which_is_reported():
    text = document(settings='accumulation="SUM"', rules=rule(clause("food", "rancid")) * 2)
    assert codes(text) == ["FZ609"]
    assert sound(text).method.aggregation == "sum"


def test_a_rule_that_joins_by_two_methods_is_refused():
    terms = '<and t-norm="PROD"><termName>rancid</termName><termName>other</termName></and>'
    other = '<fuzzyTerm name="other"><singletonShape param1="3"/></fuzzyTerm>'
    both = rule(clause("food", "delicious"), clause("food", "rancid"), attributes='connector="and" andMethod="MIN"')
    text = document(f"<circularDefinition>{terms}</circularDefinition>", rules=both)
    (found,) = errors(text.replace("</fuzzyVariable>", other + "</fuzzyVariable>", 1))
    assert (found.code, found.message) == ("FZ602", "a rule with different methods for AND: 'product' and 'min'")


def test_truncated_xml_is_reported_with_what_is_open():
    found = errors(document()[:700])
    assert found[0].code == "FZ601"
    assert "ends before" in found[0].message
    assert found[0].facts[-1].startswith("not closed: <")
    mismatched = errors(document().replace("</knowledgeBase>", "</knowledge>"))
    assert (mismatched[0].code, mismatched[0].message) == ("FZ601", "the XML is broken: mismatched tag")
    assert mismatched[0].span.line == 12


BOMB = (
    '<?xml version="1.0"?>\n<!DOCTYPE lolz [<!ENTITY a "ha">'
    + "".join(f'<!ENTITY a{i} "{f"&a{i - 1};" * 10 if i > 1 else "&a;" * 10}">' for i in range(1, 12))
    + ']>\n<fuzzySystem name="&a11;"/>'
)


@pytest.mark.parametrize(
    "text",
    [
        BOMB,
        '<!DOCTYPE f SYSTEM "file:///etc/passwd">\n<fuzzySystem/>',
        '<!DOCTYPE f [<!ENTITY x SYSTEM "file:///etc/passwd">]>\n<fuzzySystem name="&x;"/>',
    ],
)
def test_what_could_expand_is_refused_at_once(text):
    with at_most(1):
        found = errors(text)
        assert [e.code for e in found] == ["FZ602"]
        assert "document type declaration" in found[0].message


@pytest.mark.parametrize("text", [" \n", "<frbsPMML/>"])
def test_a_file_without_fml_is_reported(text):
    assert errors(text)[0].code == "FZ004"


def test_an_undeclared_entity_and_deep_nesting_are_reported():
    assert errors('<fuzzySystem name="&x;"/>')[0].message == "there is no entity '&x;'"
    assert errors("<a>" * 100_000)[0].code == "FZ106"
    deep = document().replace("<knowledgeBase>", "<knowledgeBase>" + "<x>" * 150, 1)
    assert errors(deep)[0].code == "FZ106"


def test_places_count_characters_not_bytes():
    text = (
        document()
        .replace('name="tipper - MAMDANI"', 'name="Trinkgeld für Gäste €"')
        .replace('param2="2.0"', 'param2="zwölf"')
    )
    assert [(e.span.line, e.span.text) for e in errors(text)] == [(5, '"zwölf"')]


def test_an_encoding_that_is_declared_says_nothing_of_a_text():
    text = document().replace("UTF-8", "ISO-8859-1").replace("tipper - MAMDANI", "Gäste")
    assert sound(text).name == "Gäste"


def test_many_unknown_attributes_take_no_long():
    count = examples(20_000, 5_000)
    many = " ".join(f'a{i}="1"' for i in range(count))
    with at_most(10):
        diagnostics = examined("fml", f"<fuzzySystem {many}></fuzzySystem>")[1]
    assert sum("has no effect" in d.message for d in diagnostics) == count


def test_attributes_are_found_behind_values_that_hold_angle_brackets():
    text = "<fuzzySystem name='a>b foo=\"1\"'  foo = 'x' />"
    (warning,) = [d for d in examined("fml", text)[1] if d.code == "FZ603"]
    assert (warning.span.text, warning.span.start) == ("'x'", text.index("'x'"))


@pytest.mark.parametrize("text", ['<fuzzySystem name="a&lt;&foo;b"/>', "<fuzzySystem>&lt;\n&#65; &foo;</fuzzySystem>"])
def test_an_undefined_entity_is_reported_at_its_place(text):
    (error,) = examined("fml", text)[1]
    assert (error.code, error.span.text, error.span.start) == ("FZ601", "&foo;", text.index("&foo;"))
