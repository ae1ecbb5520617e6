"""Settings of vehicles other than the differential drive."""

from __future__ import annotations

import math
from typing import Literal

from dwmr.config.quantities import FARTHEST, Section, quantity


class Differential(Section):
    """Two driven wheels on one axle, the robot of the paper."""

    kind: Literal["differential"]


class Ackermann(Section):
    """Car: driven wheels behind, steered ones in front."""

    kind: Literal["ackermann"]
    wheelbase: float = quantity("from the rear axle to the front one", "m", gt=0, le=FARTHEST)
    steering_limit: float = quantity(
        "largest angle of a steered wheel in the middle of the front axle", "rad", gt=0, lt=math.pi / 2
    )
    steering_rate: float = quantity("largest rate of that angle", "rad/s", gt=0)

    @property
    def turning_radius(self) -> float:
        """Least radius of the middle of the rear axle [m]."""
        return self.wheelbase / math.tan(self.steering_limit)


class Omnidirectional(Section):
    """Four mecanum wheels."""

    kind: Literal["omnidirectional"]
    half_base: float = quantity("half the distance between the front axle and the rear one", "m", gt=0, le=FARTHEST)
