"""The section of a scenario that names a rule file."""

import pytest
from pydantic import ValidationError

from dwmr.control.rule_files import RuleFile


def test_every_key_besides_the_file_is_a_param():
    assert RuleFile(file="ais_reaction", k_s=2, k_h=0.5).params == {"k_s": 2.0, "k_h": 0.5}
    assert RuleFile(file="ais_reaction").params == {}


@pytest.mark.parametrize("section", [{}, {"file": ""}, {"file": "x", "k_s": "2"}, {"file": "x", "k_s": float("nan")}])
def test_a_file_needs_a_name_and_a_param_a_finite_number(section):
    with pytest.raises(ValidationError):
        RuleFile.model_validate(section)
