"""Control laws as text: the interface of the loop, from a controller of a rule file."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

from dwmr.control import law_text
from dwmr.control.laws.settings import LawSettings, TextSettings
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from dwmr.control.fuzzy_gains import Rules
    from dwmr.core import interfaces


class TextLaw:
    """A control law that is a controller of a rule file.

    Args:
        name: Name of the law.
        part: Name of the param that is 0 in an ablation, else an empty string.
        file: Name of the rule file.
        rules: Rule files of the scenario.
    """

    FAULTS: Mapping[int, str] = {}
    Settings = TextSettings

    def __init__(self, name: str, part: str, file: str, rules: Rules) -> None:
        self.name = name
        self._part, self._rules, self._file = part, rules, file

    @cached_property
    def text(self) -> law_text.LawText:
        """The law as its file has it."""
        return self._rules.law(self._file)

    @cached_property
    def assembled(self) -> law_text.Assembled:
        """The law with the rule files of the scenario, before robots give it their gains."""
        controller = self.text.controller
        if self._part and self._part not in controller.param_values.values:
            message = f"controller '{controller.name}' has no param '{self._part}', which {self.name} sets to 0"
            raise DiagnosticError([Diagnostic("FZ905", message, controller.span)])
        return self._rules.assembled(self.text, self._part)

    @property
    def __file__(self) -> str:
        """The file, as modules have it."""
        return str(self.text.path)

    @cached_property
    def SIGNALS(self) -> tuple[interfaces.Signal, ...]:  # noqa: N802 - a part of every control law
        """What `step` records."""
        from dwmr.core.interfaces import Signal

        return tuple(Signal(r.name, r.unit or "-", r.label) for r in self.text.recorded)

    @property
    def step(self) -> Any:
        """The step that the loop calls."""
        from dwmr.control.laws import text_step

        return text_step.step

    def require_period(self, dt: float) -> None:
        """Refuse a law whose sample time is not the control period of the run [s].

        Raises:
            DiagnosticError: At its `every` line.
        """
        law_text.require_period(self.text.controller, dt)

    def prove(self, settings: LawSettings, rules: Rules, robot: str) -> None:
        """Prove the guarantees of the law and of its rule files, with the gains of a robot.

        Raises:
            DiagnosticError: When a rule file has mistakes, does not fit its role, or breaks a guarantee; for gains that
                the law does not have.
        """
        rules.prove_law(self.assembled, self.values(settings, robot), f"robot {robot}")

    def init(self, settings: LawSettings, rules: Rules, robot: str) -> interfaces.Law:
        """Prepare the law for one robot; its gains are the last states.

        Raises:
            DiagnosticError: For gains that the law does not have.
        """
        import numpy as np

        from dwmr.core import jit
        from dwmr.core.interfaces import Law

        step = self.assembled.step("numba" if jit.COMPILED else "python")
        values, outputs = self.values(settings, robot), len(step.output_names)
        state = np.concatenate([np.zeros(outputs), self.assembled.start(values)])
        frozen = tuple(outputs + k for k in self.assembled.adaptive(values))
        return Law(np.zeros(0), state, (step.jit,), frozen)

    def values(self, settings: LawSettings, robot: str) -> Mapping[str, float]:
        """Return the values of all params with the gains of a robot.

        Raises:
            DiagnosticError: For gains that it does not have, or that are out of their bounds.
        """
        files, gains = self._rules.files, settings.model_dump(exclude_none=True)
        params, path = tuple(p.name for p in self.assembled.controller.params), self.text.path
        unknown = [files.key_of_gain(robot, self.name, name) for name in gains if name not in params]
        if unknown:
            raise DiagnosticError([files.unknown_param(key, path, params) for key in unknown])
        values, wrong = self.assembled.values(gains)
        if wrong:
            mistakes = [files.wrong_gain(self.name, robot, n, why) for n, why in wrong.items() if n in gains]
            mistakes += [m for n, why in wrong.items() if n not in gains for m in self._rules.wrong_params(n, why)]
            raise DiagnosticError(mistakes or [files.wrong_gain(self.name, robot, *one) for one in wrong.items()])
        return values
