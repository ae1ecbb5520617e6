"""Files at the documented limits are refused with the number, and what `check` passes runs; the script draws more."""

import pytest

from tests.fuzz.runs_what_check_passes import COMMANDS, CONVERTED, LIMITS, drawn, failures_of, system

#: Commands that take no long proof; the script has all of them.
QUICK = [c for c in COMMANDS if not c.startswith("prove")]
FREE = "codegen FILE --target c --free P -o out --unproved"


@pytest.mark.parametrize("name", LIMITS)
def test_a_file_above_a_limit_is_refused_with_its_number(name):
    limit = LIMITS[name]
    assert [error for _, error, _ in failures_of(limit.made(2), limit=limit.most) if error] == []


@pytest.mark.parametrize("name", list(LIMITS)[::9])
def test_a_small_file_of_a_limit_runs(name):
    assert [f for f in failures_of(LIMITS[name].made(0.003), [*QUICK, CONVERTED[0]]) if f[1]] == []


@pytest.mark.parametrize("files", [drawn(0), system(1)], ids=lambda files: "drawn")
def test_drawn_files_that_check_passes_run(files):
    assert [f for f in failures_of(files, [*QUICK, FREE]) if f[1]] == []
