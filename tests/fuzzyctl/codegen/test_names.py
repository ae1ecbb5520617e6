import re

import pytest

from fuzzyctl.codegen.names import C_RESERVED, PYTHON_RESERVED, ST_RESERVED, Names, ascii_name

IDENTIFIER = re.compile(r"[A-Za-z](_?[A-Za-z0-9])*")


class TestNames:
    @pytest.mark.parametrize(
        ("name", "expected"),
        [
            ("sigma", "sigma"),
            ("σ", "sigma"),
            ("Σ", "Sigma"),
            ("dσ_dt", "dsigma_dt"),
            ("ά", "alpha"),
            ("größe", "grou00DFe"),
            ("naïve", "naive"),
            ("скорость", "u0441u043Au043Eu0440u043Eu0441u0442u044C"),
            ("_hidden", "hidden"),
            ("a__b_", "a_b"),
            ("_1", "n1"),
            ("__", "name"),
        ],
    )
    def test_are_spelt_in_ascii(self, name, expected):
        assert ascii_name(name) == expected
        assert IDENTIFIER.fullmatch(ascii_name(name))

    @pytest.mark.parametrize("reserved", [C_RESERVED, ST_RESERVED, PYTHON_RESERVED])
    def test_are_never_words_of_the_language(self, reserved):
        for word in reserved:
            assert Names(reserved).claim(word) not in reserved

    @pytest.mark.parametrize("own", ["x0", "v12", "T0", "t3", "C", "c1", "K0", "u1", "rate0", "result1", "Rv1"])
    def test_are_never_those_of_generated_values(self, own):
        assert Names(()).claim(own) == f"{own}_fz"

    def test_are_given_out_once(self):
        names = Names(C_RESERVED)
        assert [names.claim(n) for n in ("σ", "sigma", "sigma", "sigma_2")] == [
            "sigma",
            "sigma_2",
            "sigma_3",
            "sigma_2_2",
        ]

    def test_may_differ_by_case_where_the_language_knows_it(self):
        names, folded = Names(()), Names((), fold=True)
        assert [names.claim("A"), names.claim("a")] == ["A", "a"]
        assert [folded.claim("A"), folded.claim("a")] == ["A", "a_2"]
        assert Names(ST_RESERVED, fold=True).claim("Real") == "Real_fz"
