"""Settings of the control laws in a scenario, and the properties that each law requires of its rule files.

They are apart from the laws, so that a mistake in a scenario or a rule file is reported without the compiler.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from dwmr.config.quantities import Section, quantity

if TYPE_CHECKING:
    from dwmr.control.fuzzy_gains import Rules


class LawSettings(Section):
    """Gains of a control law for one robot."""

    def prove(self, rules: Rules, robot: str) -> None:
        """Prove the assumptions of the law; a law without gain kernels has none.

        Raises:
            DiagnosticError: When a rule file has mistakes, does not fit its role, or breaks a guarantee.
        """


class SurfaceSettings(LawSettings):
    """What all laws on the sliding variables of Eq. (9) share, section 7."""

    lambda_1: float = quantity("slope of the longitudinal surface", "-", gt=0)
    lambda_2: float = quantity("weight of the lateral error", "rad/m", gt=0)
    lambda_3: float = quantity("weight of the orientation error", "-", gt=0)
    p_v: float = quantity("reaching gain of the linear channel", "1/s", ge=0)
    p_omega: float = quantity("reaching gain of the angular channel", "1/s", ge=0)


class SmcSettings(SurfaceSettings):
    """Gains of SMC, Eq. (11)."""

    g_v: float = quantity("switching gain of the linear channel", "m/s", ge=0)
    g_omega: float = quantity("switching gain of the angular channel", "rad/s", ge=0)


class AifqsmcSettings(SurfaceSettings):
    """Gains of AIFQSMC, Eqs. (20)-(22); k_s and k̄_h come from the rule file's params unless given for a robot."""

    gamma_v: float = quantity("adaptation gain Γ_h of the linear channel", "1/s²", gt=0)
    gamma_omega: float = quantity("adaptation gain Γ_h of the angular channel", "1/s²", gt=0)
    epsilon_v: float = quantity("margin between growth and decline of k̂_h, linear channel", "m", gt=0)
    epsilon_omega: float = quantity("margin between growth and decline of k̂_h, angular channel", "rad", gt=0)
    k_h_min_v: float | None = quantity("floor k̄_h and start of k̂_h, linear channel", "m/s", gt=0, default=None)
    k_h_min_omega: float | None = quantity("floor k̄_h and start of k̂_h, angular channel", "rad/s", gt=0, default=None)
    k_s_v: float | None = quantity("suppression gain, linear channel", "m/s", gt=0, default=None)
    k_s_omega: float | None = quantity("suppression gain, angular channel", "rad/s", gt=0, default=None)
    adaptation: float | None = quantity(
        "share of the adaptation of k̂_h, 0 for a constant gain", "-", ge=0, le=1, default=None
    )

    def prove(self, rules: Rules, robot: str) -> None:
        """Prove G_AIS >= G_min > 0 for both channels, and β > 0."""
        rules.prove_reaction(robot, "v", self.k_h_min_v, self.k_s_v)
        rules.prove_reaction(robot, "omega", self.k_h_min_omega, self.k_s_omega)
        rules.prove_boundary_layer()


class FcafsmcSettings(SurfaceSettings):
    """Gains of FCAFSMC, Eqs. (77), (78); its adaptation gain is a param of the rule file."""

    def prove(self, rules: Rules, robot: str) -> None:
        """Prove the guarantees of the rule file, whose role is checked; its consequents are bounded anyway."""
        rules.prove_adaptive_gain()
