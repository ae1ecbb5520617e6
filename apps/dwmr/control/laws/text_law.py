"""Control laws as text: what the loop takes of a law, from a controller of a rule file."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

from pydantic import ConfigDict, Field

from dwmr.control import law_text
from dwmr.control.laws.settings import LawSettings
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from dwmr.control.fuzzy_gains import Rules
    from dwmr.core import interfaces
    from fuzzyctl.model.controller import Controller


class TextSettings(LawSettings):
    """Gains of a law of one's own that is text: values for its params, by name."""

    model_config = ConfigDict(frozen=True, extra="allow", allow_inf_nan=False, strict=True)
    __pydantic_extra__: dict[str, float] = Field(init=False)


class TextLaw:
    """A control law that is a controller of a rule file.

    Args:
        name: Name of the law.
        part: Name of the param that is 0 in an ablation, else an empty string.
        file: Name of the rule file.
        settings: What a scenario says of its gains.
        rules: Rule files of the scenario.

    Raises:
        DiagnosticError: When the file has mistakes, or is no control law.
    """

    FAULTS: Mapping[int, str] = {}

    def __init__(self, name: str, part: str, file: str, settings: type[LawSettings], rules: Rules) -> None:
        self.name, self.Settings = name, settings
        self.text = rules.law(file)
        self.__file__ = str(self.text.path)
        controller = self.text.controller
        if part and part not in controller.param_values.values:
            message = f"controller '{controller.name}' has no param '{part}', which {name} sets to 0"
            raise DiagnosticError([Diagnostic("FZ905", message, controller.span)])
        self.controller = law_text.with_params(controller, {part: 0.0} if part else {})

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
        """Prove what the law and its rule files require, with the gains of a robot.

        Raises:
            DiagnosticError: When a rule file has mistakes, does not fit its role, or breaks a guarantee; for gains that
                the law does not have.
        """
        settings.prove(rules, robot)
        rules.prove_law(self._with_gains(settings, rules, robot), f"robot {robot}")

    def init(self, settings: LawSettings, rules: Rules, robot: str) -> interfaces.Law:
        """Prepare the law for one robot; its gains are the last states.

        Raises:
            DiagnosticError: As `prove` does.
        """
        import numpy as np

        from dwmr.core.interfaces import Law

        self.prove(settings, rules, robot)
        values = self._with_gains(settings, rules, robot).param_values.values
        step = rules.compiled_law(rules.with_roles(self.controller))
        start = step.start({name: values[name] for name in step.free_names})
        return Law(np.zeros(0), np.concatenate([np.zeros(len(step.output_names)), start]), (step.jit,))

    def _with_gains(self, settings: LawSettings, rules: Rules, robot: str) -> Controller:
        """Return the controller with the gains of a robot.

        Raises:
            DiagnosticError: For gains that it does not have, or that are out of their bounds.
        """
        controller, gains = rules.with_roles(self.controller), settings.model_dump(exclude_none=True)
        known, path = tuple(p.name for p in controller.params), self.text.path
        unknown = [rules.files.unknown_gain(path, self.name, robot, name, known) for name in gains if name not in known]
        if unknown:
            raise DiagnosticError(unknown)
        valued = law_text.with_params(controller, gains)
        wrong = [
            rules.files.wrong_gain(self.name, robot, name, reason) for name, reason in law_text.out_of_bounds(valued)
        ]
        if wrong:
            raise DiagnosticError(wrong)
        return valued
