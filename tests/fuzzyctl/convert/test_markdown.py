"""A page for people."""

import pytest

import fuzzyctl
from fuzzyctl.convert.convert import written
from fuzzyctl.testing import run_command


@pytest.fixture
def immune():
    return fuzzyctl.load("ais_reaction")


def page(system):
    return written(system, "markdown")[0]


def tables(text):
    """Return the cells of all tables of a page, row by row."""
    rows = [line for line in text.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in rows]


def test_a_rule_table_stands_as_it_is_printed(immune):
    rows = tables(page(immune))
    assert ["", "NB", "NS", "ZO", "PS", "PB"] in rows
    assert ["**NS**", "NM", "NS", "ZO", "PS", "ZO"] in rows


def test_numbers_are_computed_and_expressions_shown(immune):
    text = page(immune)
    assert "`triangle(0.09, 0.18, inf)`" in text
    assert ["`f_max`", "0.18", "`(k_h_min - G_min) / k_s`", ""] in tables(text)


def test_guarantees_and_source_are_listed(immune):
    text = page(immune)
    assert "- `f <= 0 within 1e-12 when abs(sigma) >= 0.03`" in text
    assert "Source: Goto, Bertol, Martins: Tables 2, 6 and 7" in text


def test_markup_in_names_is_text(base):
    system = fuzzyctl.loads(base.replace('"Base"', '"a_b *c* | [d]"'))
    assert page(system).startswith("# a\\_b \\*c\\* | \\[d\\]\n")


def test_a_bar_in_a_cell_is_escaped_once(base):
    """As GitHub's Markdown asks for: before cells are split; a second escape would show a backslash."""
    system = fuzzyctl.loads(base)
    x = system.input("x")
    terms = (x.terms[0].model_copy(update={"name": "po|or"}), *x.terms[1:])
    text = page(system.model_copy(update={"inputs": (x.model_copy(update={"terms": terms}), *system.inputs[1:])}))
    assert "| po\\|or |" in text


def test_every_table_has_rows_of_one_length(immune):
    tip = fuzzyctl.load("tipper")
    for system in (immune, tip):
        lines = page(system).splitlines()
        blocks = "\n".join(lines).split("\n\n")
        for block in (b.splitlines() for b in blocks if b.startswith("|")):
            assert len({line.replace("\\|", "").count("|") for line in block}) == 1


def test_pictures_are_drawn_beside_the_page_and_linked(changed, tmp_path):
    text = changed(("  Z |  N  P", "  Z |  .  ."), ("[-2, 2]", "[-2, 2] else error"))  # the surface has a hole
    (tmp_path / "base.fz").write_text(text, encoding="utf-8")
    assert run_command("convert", "base.fz", "base.md", folder=tmp_path).exit_code == 0
    shown = (tmp_path / "base.md").read_text(encoding="utf-8")
    pictures = sorted((tmp_path / "base-pictures").iterdir())
    assert [p.name for p in pictures] == ["surface-u.svg", "u.svg", "x.svg", "y.svg"]
    for path in pictures:
        assert path.read_text(encoding="utf-8").lstrip().startswith("<?xml")
        assert f"]({path.relative_to(tmp_path)})" in shown


def test_no_two_lines_are_blank_where_rule_blocks_begin():
    head = "system s\ninput x in [0, 1]\n  terms a b\noutput y in [0, 1]\n  terms p q\n"
    rules = ("if x is a then y is p\n", "if x is b then y is q\n")
    for text in ("rules one\n{}rules two\n{}", "{}rules two\n{}"):
        found = page(fuzzyctl.loads(head + text.format(*rules)))
        assert "## Rule block two" in found
        assert "\n\n\n" not in found
