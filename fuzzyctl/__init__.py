"""Declarative fuzzy control: rule files in, compiled kernels out.

Nothing heavy is imported before it is used: `import fuzzyctl` loads neither numpy nor a parser.
No submodule is named like a function here: importing it would put the module in the function's place.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from fuzzyctl.operations import register

if TYPE_CHECKING:
    from fuzzyctl import plot as plot
    from fuzzyctl.analysis.bounds import OutputBound
    from fuzzyctl.analysis.check import check
    from fuzzyctl.analysis.extremes import output_bounds
    from fuzzyctl.analysis.prove import prove
    from fuzzyctl.analysis.verdicts import Proved, Refuted, Undecided, Verdicts, Witness
    from fuzzyctl.building import build as build
    from fuzzyctl.diagnostics.diagnostic import (
        ArgumentError,
        BackendUnavailableError,
        Diagnostic,
        DiagnosticError,
        FuzzyctlError,
        NoRuleFiresError,
        UnknownNameError,
        ValueOutOfBoundsError,
    )
    from fuzzyctl.explain.block_trace import BlockTrace, why
    from fuzzyctl.explain.trace import Trace
    from fuzzyctl.formats.fz import dump, dumps
    from fuzzyctl.kernels.compile import Kernel, compile
    from fuzzyctl.loading.load import load, load_all, loads
    from fuzzyctl.model.as_profile import as_profile
    from fuzzyctl.model.block import Block, Guarantee, Hedge, Param
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.loop import Loop
    from fuzzyctl.model.method import Activation, Defuzzifier, Method, Semantics
    from fuzzyctl.model.plant import Plant
    from fuzzyctl.model.rule import And, Antecedent, Cell, Consequent, Is, Not, Or, Rule, RuleBlock, RuleTable
    from fuzzyctl.model.system import FuzzySystem
    from fuzzyctl.model.variable import Hold, Input, Let, LinguisticVariable, Membership, Output, Term
    from fuzzyctl.simulation.experiment import Experiment
    from fuzzyctl.simulation.run import Run
    from fuzzyctl.simulation.simulate import simulate

__version__ = "0.1.0"

_HOMES = {
    "Activation": "fuzzyctl.model.method",
    "And": "fuzzyctl.model.rule",
    "Antecedent": "fuzzyctl.model.rule",
    "ArgumentError": "fuzzyctl.diagnostics.diagnostic",
    "BackendUnavailableError": "fuzzyctl.diagnostics.diagnostic",
    "Block": "fuzzyctl.model.block",
    "BlockTrace": "fuzzyctl.explain.block_trace",
    "Cell": "fuzzyctl.model.rule",
    "Consequent": "fuzzyctl.model.rule",
    "Controller": "fuzzyctl.model.controller",
    "Defuzzifier": "fuzzyctl.model.method",
    "Diagnostic": "fuzzyctl.diagnostics.diagnostic",
    "DiagnosticError": "fuzzyctl.diagnostics.diagnostic",
    "Experiment": "fuzzyctl.simulation.experiment",
    "FuzzySystem": "fuzzyctl.model.system",
    "FuzzyctlError": "fuzzyctl.diagnostics.diagnostic",
    "Guarantee": "fuzzyctl.model.block",
    "Hedge": "fuzzyctl.model.block",
    "Hold": "fuzzyctl.model.variable",
    "Input": "fuzzyctl.model.variable",
    "Is": "fuzzyctl.model.rule",
    "Kernel": "fuzzyctl.kernels.compile",
    "Let": "fuzzyctl.model.variable",
    "LinguisticVariable": "fuzzyctl.model.variable",
    "Loop": "fuzzyctl.model.loop",
    "Membership": "fuzzyctl.model.variable",
    "Method": "fuzzyctl.model.method",
    "NoRuleFiresError": "fuzzyctl.diagnostics.diagnostic",
    "Not": "fuzzyctl.model.rule",
    "Or": "fuzzyctl.model.rule",
    "Output": "fuzzyctl.model.variable",
    "OutputBound": "fuzzyctl.analysis.bounds",
    "Param": "fuzzyctl.model.block",
    "Plant": "fuzzyctl.model.plant",
    "Proved": "fuzzyctl.analysis.verdicts",
    "Refuted": "fuzzyctl.analysis.verdicts",
    "Rule": "fuzzyctl.model.rule",
    "RuleBlock": "fuzzyctl.model.rule",
    "RuleTable": "fuzzyctl.model.rule",
    "Run": "fuzzyctl.simulation.run",
    "Semantics": "fuzzyctl.model.method",
    "Term": "fuzzyctl.model.variable",
    "Trace": "fuzzyctl.explain.trace",
    "Undecided": "fuzzyctl.analysis.verdicts",
    "UnknownNameError": "fuzzyctl.diagnostics.diagnostic",
    "ValueOutOfBoundsError": "fuzzyctl.diagnostics.diagnostic",
    "Verdicts": "fuzzyctl.analysis.verdicts",
    "Witness": "fuzzyctl.analysis.verdicts",
    "as_profile": "fuzzyctl.model.as_profile",
    "check": "fuzzyctl.analysis.check",
    "compile": "fuzzyctl.kernels.compile",
    "dump": "fuzzyctl.formats.fz",
    "dumps": "fuzzyctl.formats.fz",
    "load": "fuzzyctl.loading.load",
    "load_all": "fuzzyctl.loading.load",
    "loads": "fuzzyctl.loading.load",
    "output_bounds": "fuzzyctl.analysis.extremes",
    "prove": "fuzzyctl.analysis.prove",
    "simulate": "fuzzyctl.simulation.simulate",
    "why": "fuzzyctl.explain.block_trace",
}

__all__ = [
    "Activation",
    "And",
    "Antecedent",
    "ArgumentError",
    "BackendUnavailableError",
    "Block",
    "BlockTrace",
    "Cell",
    "Consequent",
    "Controller",
    "Defuzzifier",
    "Diagnostic",
    "DiagnosticError",
    "Experiment",
    "FuzzySystem",
    "FuzzyctlError",
    "Guarantee",
    "Hedge",
    "Hold",
    "Input",
    "Is",
    "Kernel",
    "Let",
    "LinguisticVariable",
    "Loop",
    "Membership",
    "Method",
    "NoRuleFiresError",
    "Not",
    "Or",
    "Output",
    "OutputBound",
    "Param",
    "Plant",
    "Proved",
    "Refuted",
    "Rule",
    "RuleBlock",
    "RuleTable",
    "Run",
    "Semantics",
    "Term",
    "Trace",
    "Undecided",
    "UnknownNameError",
    "ValueOutOfBoundsError",
    "Verdicts",
    "Witness",
    "as_profile",
    "check",
    "compile",
    "dump",
    "dumps",
    "load",
    "load_all",
    "loads",
    "output_bounds",
    "prove",
    "simulate",
    "why",
]

register(
    {
        "by_name": "fuzzyctl.kernels.compile:ByName",
        "html": "fuzzyctl.display.display:html",
        "line": "fuzzyctl.display.display:line",
        "plot_run": "fuzzyctl.plot.time_series:runs",
        "plot_surface": "fuzzyctl.plot.surfaces:surface",
        "plot_trace": "fuzzyctl.plot.rule_viewer:viewer",
        "require_well_formed": "fuzzyctl.model.checks.checks:require_well_formed",
        "text": "fuzzyctl.display.display:text",
        "with_numbers": "fuzzyctl.model.free_numbers:with_numbers",
        "with_params": "fuzzyctl.loading.block_equations:with_params",
        "with_values": "fuzzyctl.loading.block_equations:with_numbers",
    }
)

#: The public modules.
_MODULES = {"build": "fuzzyctl.building.build", "plot": "fuzzyctl.plot"}


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return import_module(_MODULES[name])
    if name not in _HOMES:
        raise AttributeError(f"module 'fuzzyctl' has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, *_MODULES, "__version__"]
