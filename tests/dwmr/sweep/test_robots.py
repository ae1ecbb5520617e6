"""Formations of robots as what a sweep runs."""

import pickle

import pytest

from dwmr.sweep.robots import Robots, read_spec
from fuzzyctl import DiagnosticError
from fuzzyctl.experiments import sweep_plan


def test_workers_get_the_folder_of_rule_files_but_not_what_is_known(tmp_path):
    robots = Robots(tmp_path)
    robots.known.sound.add((tmp_path, ()))
    copy = pickle.loads(pickle.dumps(robots))
    assert (copy, copy.rules_folder) == (robots, tmp_path)
    assert copy.known.sound == set()
    assert copy != Robots()


def test_a_factor_on_the_common_table_is_answered_with_the_key_of_each_robot(tmp_path):
    path = tmp_path / "spec.toml"
    path.write_text('scenario = "paper"\n[random]\n"robot.mass" = { uniform = [1, 2], relative = "factor" }\n')
    with pytest.raises(DiagnosticError) as caught:
        sweep_plan.make(Robots(), read_spec(path), ())
    (found,) = caught.value.diagnostics
    assert (found.help, found.span.line) == ("give robots.*.KEY in place of robot.KEY", 3)


def test_a_spec_has_its_keys_in_the_order_of_its_description(tmp_path):
    path = tmp_path / "spec.toml"
    path.write_text('scenario = "paper"\n')
    keys = list(read_spec(path).spec.model_dump())
    assert keys == ["scenario", "controllers", "runs", "seed", "measures", "set", "grid", "random"]
