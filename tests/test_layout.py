"""Tests mirror the code: a module has a test of its name, or is listed with the tests that run it."""

from pathlib import Path

ROOT = Path(__file__).parent.parent
MIRRORS = {"fuzzyctl": ROOT / "fuzzyctl", "dwmr": ROOT / "apps" / "dwmr", "gallery": ROOT / "apps" / "gallery"}

#: Packages whose modules are parts of one entry point, and modules, with the tests that run them. A row holds for the
#: packages inside, too, unless they have their own.
THROUGH = {
    "fuzzyctl/analysis": "fuzzyctl/analysis/test_prove.py fuzzyctl/analysis/test_bounds.py fuzzyctl/cli/test_check.py",
    "fuzzyctl/analysis/branch_and_bound": "fuzzyctl/analysis/test_prove.py fuzzyctl/analysis/test_prove_slopes.py "
    "fuzzyctl/analysis/test_extremes.py",
    "fuzzyctl/analysis/coverage": "fuzzyctl/analysis/coverage/test_coverage.py",
    "fuzzyctl/analysis/induction": "fuzzyctl/analysis/test_controllers.py properties/test_controller_proofs.py",
    "fuzzyctl/analysis/multilinear": "fuzzyctl/analysis/test_prove.py fuzzyctl/analysis/test_prove_slopes.py",
    "fuzzyctl/building": "fuzzyctl/building/test_build.py",
    "fuzzyctl/cli": "fuzzyctl/cli/test_check.py fuzzyctl/cli/test_compare.py fuzzyctl/cli/test_doctor.py "
    "fuzzyctl/cli/test_eval.py fuzzyctl/cli/test_help.py fuzzyctl/cli/test_show.py",
    "fuzzyctl/codegen": "fuzzyctl/codegen/test_c.py fuzzyctl/codegen/test_st.py fuzzyctl/codegen/test_fixed.py "
    "fuzzyctl/codegen/test_table.py fuzzyctl/codegen/test_python.py fuzzyctl/codegen/test_javascript.py",
    "fuzzyctl/comparison": "fuzzyctl/comparison/test_changes.py fuzzyctl/comparison/test_differences.py "
    "fuzzyctl/cli/test_compare.py",
    "fuzzyctl/convert": "fuzzyctl/convert/test_markdown.py fuzzyctl/cli/test_convert.py",
    "fuzzyctl/diagnostics": "fuzzyctl/diagnostics/test_diagnostic.py fuzzyctl/cli/test_terminal.py",
    "fuzzyctl/display": "fuzzyctl/display/test_display.py e2e/test_notebooks.py",
    "fuzzyctl/displayed.py": "fuzzyctl/display/test_display.py",
    "fuzzyctl/editor": "fuzzyctl/editor/test_server.py fuzzyctl/editor/test_hover.py",
    "fuzzyctl/experiments": "fuzzyctl/experiments/sweep/test_run.py",
    "fuzzyctl/experiments/sweep": "fuzzyctl/experiments/sweep/test_run.py dwmr/sweep/test_sweep.py",
    "fuzzyctl/explain": "fuzzyctl/cli/test_why.py",
    "fuzzyctl/formats": "fuzzyctl/formats/test_round_trips.py fuzzyctl/formats/test_odd_files.py",
    "fuzzyctl/formats/fcl": "fuzzyctl/formats/fcl/test_fcl_reader.py fuzzyctl/formats/fcl/test_fcl_round_trip.py",
    "fuzzyctl/formats/fis": "fuzzyctl/formats/fis/test_fis_reader.py fuzzyctl/formats/fis/test_fis_writer.py",
    "fuzzyctl/formats/fll": "fuzzyctl/formats/fll/test_fll_reader.py fuzzyctl/formats/fll/test_fll_writer.py",
    "fuzzyctl/formats/fml": "fuzzyctl/formats/fml/test_fml_reader.py fuzzyctl/formats/fml/test_fml_round_trip.py",
    "fuzzyctl/formulas": "fuzzyctl/formulas/test_memberships.py fuzzyctl/kernels/test_exact.py",
    "fuzzyctl/interop": "fuzzyctl/interop/test_gymnasium.py fuzzyctl/interop/test_control.py",
    "fuzzyctl/kernels": "fuzzyctl/kernels/test_engine.py fuzzyctl/kernels/test_exact.py properties/test_engine.py",
    "fuzzyctl/lang": "fuzzyctl/lang/test_parser.py fuzzyctl/lang/test_mistakes.py fuzzyctl/lang/test_recovery.py",
    "fuzzyctl/loading/block_equations.py": "fuzzyctl/resolve/test_loops.py fuzzyctl/resolve/test_plants.py",
    "fuzzyctl/model/checks/block_numbers.py": "fuzzyctl/resolve/test_loops.py fuzzyctl/resolve/test_plants.py "
    "fuzzyctl/resolve/test_controllers.py",
    "fuzzyctl/loading/choice.py": "fuzzyctl/loading/test_load.py fuzzyctl/cli/test_loading.py",
    "fuzzyctl/loading/policy.py": "fuzzyctl/cli/test_check.py fuzzyctl/loading/test_load.py",
    "fuzzyctl/model": "fuzzyctl/model/test_system.py fuzzyctl/model/checks/test_checks.py fuzzyctl/cli/test_as.py",
    "fuzzyctl/page": "fuzzyctl/cli/test_page.py",
    "fuzzyctl/plot": "fuzzyctl/cli/test_plot.py fuzzyctl/cli/test_why.py fuzzyctl/plot/test_figures.py",
    "fuzzyctl/resolve": "fuzzyctl/resolve/test_rules.py fuzzyctl/resolve/test_settings.py",
    "fuzzyctl/ros": "fuzzyctl/ros/test_controller.py dwmr/ros/test_main.py",
    "fuzzyctl/simulation": "fuzzyctl/simulation/test_experiment.py fuzzyctl/cli/test_simulate.py",
    "fuzzyctl/studio": "fuzzyctl/studio/test_answers.py",
    "fuzzyctl/sweep": "fuzzyctl/sweep/test_loops.py",
    "fuzzyctl/support": "fuzzyctl/test_arbitrary_arguments.py fuzzyctl/loading/test_load.py",
    "dwmr/calibration": "dwmr/calibration/test_calibration.py",
    "dwmr/cli": "dwmr/cli/test_cli.py dwmr/cli/test_sweep.py",
    "dwmr/config": "dwmr/config/test_layers.py dwmr/scenario/test_file.py",
    "dwmr/control": "dwmr/control/test_fuzzy_gains.py",
    "dwmr/control/laws": "dwmr/control/laws/test_laws.py",
    "dwmr/core": "dwmr/simulation/test_simulate.py dwmr/sweep/test_sweep.py",
    "dwmr/figures": "dwmr/figures/test_figures.py dwmr/figures/test_paper.py dwmr/figures/test_animation.py",
    "dwmr/output": "dwmr/output/test_data.py dwmr/cli/test_cli.py",
    "dwmr/page": "dwmr/page/test_page.py",
    "dwmr/reference": "dwmr/reference/test_compiled.py dwmr/simulation/test_simulate.py",
    "dwmr/scenario": "dwmr/scenario/test_file.py dwmr/scenario/test_checks.py dwmr/cli/test_scenarios.py",
    "dwmr/simulation": "dwmr/simulation/test_simulate.py",
    "dwmr/sweep": "dwmr/sweep/test_sweep.py",
}


def untested(modules):
    """Return the modules that have no test of their name, as `package/module.py`."""
    return [m for m in modules if not (ROOT / "tests" / m).with_name(f"test_{Path(m).name}").exists()]


def modules():
    return [
        (Path(top) / path.relative_to(folder)).as_posix()
        for top, folder in MIRRORS.items()
        for path in sorted(folder.rglob("*.py"))
        if path.stem not in ("__init__", "__main__")
    ]


def row_of(module):
    """Return the row of a module or of the smallest package around it; None where there is none."""
    return next((p.as_posix() for p in (Path(module), *Path(module).parents) if p.as_posix() in THROUGH), None)


def test_each_module_has_a_test_of_its_name_or_is_listed():
    assert [m for m in untested(modules()) if row_of(m) is None] == []


def test_each_row_is_needed():
    assert set(THROUGH) == {row_of(m) for m in untested(modules())}


def test_the_tests_of_a_row_exist():
    assert [t for row in THROUGH.values() for t in row.split() if not (ROOT / "tests" / t).exists()] == []


def test_a_module_without_a_test_is_found():
    assert untested(["fuzzyctl/loading/load.py", "fuzzyctl/loading/absent.py"]) == ["fuzzyctl/loading/absent.py"]
    assert row_of("fuzzyctl/analysis/coverage/absent.py") == "fuzzyctl/analysis/coverage"
    assert row_of("fuzzyctl/loading/absent.py") is None
