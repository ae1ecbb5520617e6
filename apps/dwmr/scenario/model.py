"""Model of a scenario: every number of a run, with its unit, frozen."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import AfterValidator, Field, Strict, field_validator, model_validator

from dwmr.config.quantities import FARTHEST, Section, place, quantity
from dwmr.control.rule_files import RuleFile
from dwmr.reference.prepared import Coordinate, ReferenceSettings, Settings

#: Table of a scenario whose values every robot takes over unless it has others.
COMMON = "robot"


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


#: Elements that a list of a scenario may have.
LONGEST_LIST = 1000
#: Largest speed of an obstacle [m/s].
FASTEST_OBSTACLE = 1e6
#: Largest difference of a sum of weights from 1, for weights with six decimals [-].
ROUNDED_WEIGHTS = 1e-5
#: From −2π to 2π, with the digits of those who round up [rad].
FULL_TURN = 6.2832


def _printable(text: str) -> str:
    if not text.isprintable():
        where = next(k for k, one in enumerate(text) if not one.isprintable())
        raise ValueError(f"character {where + 1} of {text[:40]!a} cannot be printed")
    return text


Printable = Annotated[str, AfterValidator(_printable)]


class Run(Section):
    """Length and resolution of the run."""

    controller: str = Field(description="control law of the run when the command line names none")
    horizon: float = quantity("duration", "s", gt=0, le=100_000)
    dt: float = quantity("control period", "s", ge=1e-6, le=1)
    substeps: int = quantity("integration steps in one control period", "-", ge=1, le=1000)
    save_every: int = quantity("control periods between two saved samples", "-", ge=1, le=1_000_000)
    record_every: int | None = quantity(
        "control periods between two recorded samples, absent for as many as the record has room for", "-",
        ge=1, le=1_000_000, default=None,
    )  # fmt: skip
    plant: Literal["equations", "mujoco"] = Field(
        default="equations",
        description="what moves the robots: the paper's equations, or rigid bodies in the physics engine MuJoCo",
    )
    arrival: float = quantity(
        "a robot has arrived where it stays as near to its place on the reference or in the formation", "m",
        gt=0, le=FARTHEST, default=0.5,
    )  # fmt: skip
    seed: int = quantity("first number of the measurement noise", "-", ge=0, le=2**63 - 1, default=0)

    @property
    def steps(self) -> int:
        """Number of control periods."""
        return max(1, round(self.horizon / self.dt))


class Body(Section):
    """Outline of a robot seen from above, a rectangle."""

    front: float = quantity("from the axle to the front", "m", ge=0, le=FARTHEST)
    rear: float = quantity("from the axle to the rear", "m", ge=0, le=FARTHEST)
    width: float = quantity("width", "m", gt=0, le=FARTHEST)


class RigidBody(Section):
    """Constants of a rigid body in MuJoCo besides mass, inertia, wheels and outline; the equations do not need them."""

    height: float = quantity("height of the chassis's top", "m", gt=0, le=FARTHEST)
    clearance: float = quantity("from the ground to the chassis", "m", gt=0, le=FARTHEST)
    com_height: float = quantity("centre of mass above the ground", "m", gt=0, le=FARTHEST)
    wheel_mass: float = quantity("mass of one wheel, a part of `mass`", "kg", gt=0)
    wheel_width: float = quantity("width of one wheel", "m", gt=0, le=FARTHEST)
    wheel_friction: float = quantity("sliding friction between wheel and ground", "-", ge=0)
    wheel_spin_friction: float = quantity("friction of a wheel that turns on the spot", "m", ge=0)
    caster_front: float = quantity("from the axle to the front caster", "m", gt=0, le=FARTHEST)
    caster_rear: float = quantity("from the axle to the rear caster", "m", gt=0, le=FARTHEST)
    caster_radius: float = quantity("radius of a caster", "m", gt=0, le=FARTHEST)
    caster_friction: float = quantity("friction between caster and ground", "-", ge=0)
    caster_gap: float = quantity("from the front caster to the ground at rest", "m", ge=0, le=FARTHEST)


class Friction(Section):
    """Friction the controllers do not know of."""

    coulomb_force: float = quantity("Coulomb friction along the robot", "N", ge=0)
    coulomb_torque: float = quantity("Coulomb friction of turning", "N m", ge=0)
    viscous_force: float = quantity("viscous friction along the robot", "N s/m", ge=0)
    viscous_torque: float = quantity("viscous friction of turning", "N m s/rad", ge=0)
    stick_v: float = quantity("velocity over which Coulomb friction changes sign", "m/s", gt=0)
    stick_omega: float = quantity("angular velocity over which Coulomb friction changes sign", "rad/s", gt=0)


class Actuator(Section):
    """Limits and lag of the drives."""

    lag: float = quantity("time constant of the torques", "s", ge=0.001)
    torque_limit: float = quantity("largest torque of one wheel", "N m", gt=0)
    v_limit: float = quantity("largest linear velocity that the inner loop is commanded", "m/s", gt=0)
    omega_limit: float = quantity("largest angular velocity that the inner loop is commanded", "rad/s", gt=0)
    acceleration: float | None = quantity(
        "largest rate of the commanded linear velocity, absent for none", "m/s²", gt=0, default=None
    )
    angular_acceleration: float | None = quantity(
        "largest rate of the commanded angular velocity, absent for none", "rad/s²", gt=0, default=None
    )


class InnerLoop(Section):
    """PD velocity loop, Eq. (75)."""

    torque_reading: Literal["acceleration", "force"] = Field(
        description="unit of the PD output: accelerations, multiplied by mass and inertia, or forces"
    )
    k_p_v: float = quantity("proportional gain, linear", "1/s or N s/m", ge=0)
    k_p_omega: float = quantity("proportional gain, angular", "1/s or N m s/rad", ge=0)
    k_d_v: float = quantity("derivative gain, linear", "1 or kg", ge=0)
    k_d_omega: float = quantity("derivative gain, angular", "1 or kg m²", ge=0)
    n_v: float = quantity("derivative filter, linear", "1/s", gt=0)
    n_omega: float = quantity("derivative filter, angular", "1/s", gt=0)


class Edge(NamedTuple):
    """A place that a follower is to keep, relative to a robot or to the body of a virtual structure.

    Attributes:
        leader: Name of the robot, None for the body.
        separation: From the robot's axle, or from the reference [m].
        bearing: Counter-clockwise from the direction of either [rad].
        weight: Share in the follower's place [-].
        key: Of the leader's name, below `formation`.
    """

    leader: str | None
    separation: float
    bearing: float
    weight: float = 1.0
    key: str = "leader"


class SeparationBearing(Section):
    """Place of a follower relative to one robot, the formation of the paper."""

    kind: Literal["separation-bearing"]
    leader: str = Field(description="name of the robot it follows")
    separation: float = quantity("desired distance L_ijd from the leader's axle", "m", gt=0, le=FARTHEST)
    bearing: float = quantity("desired bearing Ψ_ijd", "rad", ge=-FULL_TURN, le=FULL_TURN)

    @property
    def edges(self) -> tuple[Edge, ...]:
        """The places whose weighted mean the follower keeps."""
        return (Edge(self.leader, self.separation, self.bearing),)


class VirtualStructure(Section):
    """Place of a robot in a rigid body that moves along the reference."""

    kind: Literal["virtual-structure"]
    separation: float = quantity("distance from the reference", "m", ge=0, le=FARTHEST)
    bearing: float = quantity("bearing from its direction of travel", "rad", ge=-FULL_TURN, le=FULL_TURN)

    @property
    def edges(self) -> tuple[Edge, ...]:
        """The only place."""
        return (Edge(None, self.separation, self.bearing),)


class Neighbour(Section):
    """Place of a follower relative to one of its neighbours."""

    leader: str = Field(description="name of the neighbour")
    separation: float = quantity("desired distance from the neighbour's axle", "m", gt=0, le=FARTHEST)
    bearing: float = quantity("desired bearing from the neighbour", "rad", ge=-FULL_TURN, le=FULL_TURN)
    weight: float | None = quantity("share in the mean, absent for equal shares", "-", gt=0, le=1, default=None)


class Consensus(Section):
    """Place of a follower as the weighted mean of those relative to its neighbours."""

    kind: Literal["consensus"]
    neighbours: Annotated[tuple[Neighbour, ...], Strict(False)] = Field(
        description="robots and places relative to them", min_length=1, max_length=LONGEST_LIST
    )

    @model_validator(mode="after")
    def _shares(self) -> Consensus:
        weights = [one.weight for one in self.neighbours if one.weight is not None]
        if weights and len(weights) < len(self.neighbours):
            raise ValueError("give a weight to each neighbour, or to none")
        if weights and abs(math.fsum(weights) - 1.0) > ROUNDED_WEIGHTS:
            raise ValueError(f"the weights sum to {math.fsum(weights):.6g}, expected 1")
        return self

    @property
    def edges(self) -> tuple[Edge, ...]:
        """The places whose weighted mean the follower keeps."""
        weights = [one.weight or 1.0 for one in self.neighbours]
        total = math.fsum(weights)
        return tuple(
            Edge(one.leader, one.separation, one.bearing, weight / total, f"neighbours.{k}.leader")
            for k, (one, weight) in enumerate(zip(self.neighbours, weights, strict=True))
        )


class FormationSettings(Section):
    """Knowledge of the robots of a formation about one another."""

    leader_velocity: Literal["ground", "wheels"] = Field(
        default="ground",
        description="leader's velocity as its followers know it: over ground, or from its wheels",
    )


class Communication(Section):
    """Messages by which a leader tells its followers its measured state and velocities."""

    delay: float = quantity("age of a message, rounded to control periods", "s", ge=0, le=10, default=0.0)
    loss: float = quantity("share of a robot's messages that no follower gets", "-", ge=0, lt=1, default=0.0)


#: Noise is cut at this many standard deviations [-].
LARGEST_NOISE = 4.0


class Noise(Section):
    """Standard deviations of the measured state of a robot, drawn anew every control period."""

    x: float = quantity("position, x", "m", ge=0, le=FARTHEST, default=0.0)
    y: float = quantity("position, y", "m", ge=0, le=FARTHEST, default=0.0)
    theta: float = quantity("orientation", "rad", ge=0, le=FARTHEST, default=0.0)
    v: float = quantity("linear velocity from the wheels", "m/s", ge=0, le=FARTHEST, default=0.0)
    omega: float = quantity("angular velocity from the wheels", "rad/s", ge=0, le=FARTHEST, default=0.0)


class Sensors(Section):
    """Sensors of a robot's posture and wheels' velocities; noise is added to them."""

    pose: Literal["exact", "odometry"] = Field(
        default="exact", description="posture as it is, or as the wheels' ways add up from the start"
    )
    encoder_steps: int = quantity(
        "steps of an encoder in one turn of a wheel, 0 for none", "-", ge=0, le=10**9, default=0
    )


class Robot(Section):
    """One robot: body, start, drives, inner loop, gains and its place in the formation."""

    mass: float = quantity("mass", "kg", gt=0)
    inertia: float = quantity("moment of inertia about the axle centre", "kg m²", gt=0)
    com_offset: float = quantity("centre of mass ahead of the axle, negative behind", "m")
    half_track: float = quantity("half the distance between the wheels b", "m", gt=0)
    wheel_radius: float = quantity("wheel radius r", "m", gt=0)
    radius: float = quantity("radius R_R that encloses the robot", "m", gt=0)
    d: float = quantity("reference point of the control law ahead of the axle", "m", gt=0)
    x_0: float = place("start, x of the reference point")
    y_0: float = place("start, y of the reference point")
    theta_0: float = place("start, orientation", "rad")
    avoids_obstacles: bool = Field(description="whether it avoids obstacles")
    body: Body | None = Field(default=None, description="outline; absent, the circle of R_R about the axle's middle")
    vehicle: Differential | Ackermann | Omnidirectional | None = Field(
        default=None, discriminator="kind", description="kind of vehicle and its numbers; absent, a differential drive"
    )
    rigid_body: RigidBody | None = Field(default=None, description='needed by run.plant = "mujoco" only')
    friction: Friction
    actuator: Actuator
    inner_loop: InnerLoop
    reference: Settings | None = Field(
        default=None,
        discriminator="kind",
        description="its own path, for a robot without a formation; absent, that of the scenario",
    )
    formation: SeparationBearing | VirtualStructure | Consensus | None = Field(
        default=None, discriminator="kind", description="absent for a robot that follows a reference"
    )
    delay: float = quantity(
        "time by which a robot on the reference is behind it, negative ahead", "s", ge=-1e6, le=1e6, default=0.0
    )
    sensors: Sensors = Field(default=Sensors(), description="exact when absent")
    noise: Noise | None = Field(default=None, description="of what it measures of itself; none when absent")
    conditional_adaptation: bool | None = Field(
        default=None,
        description="whether adaptive gains rest while limits or the safety filter change the robot's command; absent, "
        "with [safety] only",
    )
    controllers: dict[str, dict[str, Any]] = Field(default={}, description="gains by control law")

    @field_validator("formation", mode="before")
    @classmethod
    def _usual_kind(cls, value: object) -> object:
        return {"kind": "separation-bearing", **value} if isinstance(value, dict) else value

    @property
    def edges(self) -> tuple[Edge, ...]:
        """The places whose weighted mean it keeps; none on a reference."""
        return self.formation.edges if self.formation else ()

    @property
    def leaders(self) -> tuple[str, ...]:
        """Names of the robots that it follows."""
        return tuple(one.leader for one in self.edges if one.leader is not None)


#: Time, x and y of an obstacle [s, m, m].
Moment = Annotated[
    tuple[Annotated[float, Field(gt=0.0, le=1e6)], Coordinate, Coordinate], Strict(False)
]  # fmt: skip
Component = Annotated[float, Field(ge=-FASTEST_OBSTACLE, le=FASTEST_OBSTACLE)]


class Obstacle(Section):
    """One round obstacle, at rest or on a given way."""

    x: float = place("centre at the start, x")
    y: float = place("centre at the start, y")
    radius: float = quantity("radius r_a", "m", gt=0, le=FARTHEST)
    velocity: Annotated[tuple[Component, Component], Strict(False)] | None = Field(
        default=None, description="velocity along x and y, for ever", json_schema_extra={"unit": "m/s"}
    )
    path: Annotated[tuple[Moment, ...], Strict(False)] | None = Field(
        default=None,
        description="moments [t, x, y] on its way, straight between them; behind the last it rests",
        json_schema_extra={"unit": "s, m, m"},
        min_length=1,
        max_length=2000,
    )

    @model_validator(mode="after")
    def _one_way(self) -> Obstacle:
        if self.velocity is not None and self.path is not None:
            raise ValueError("give velocity or path, not both")
        before, x, y = 0.0, self.x, self.y
        for k, (t, x_t, y_t) in enumerate(self.path or ()):
            if t <= before:
                raise ValueError(f"path.{k} is at {t:g} s, not after {before:g} s")
            speed = math.hypot(x_t - x, y_t - y) / (t - before)
            if speed > FASTEST_OBSTACLE:
                raise ValueError(f"path.{k} is reached at {speed:.4g} m/s; at most {FASTEST_OBSTACLE:g} is possible")
            before, x, y = t, x_t, y_t
        return self


class SafetySettings(Section):
    """Safety filter of the commands: all robots keep apart and away from obstacles."""

    alpha: float = quantity("rate α at which the barrier h may decline", "1/s", gt=0, le=1e6)
    lookahead: float = quantity("guarded point ahead of the axle", "m", gt=0, le=FARTHEST)
    margin: float = quantity("distance kept between guarded discs and obstacles", "m", ge=0, le=FARTHEST)
    acceleration: float = quantity("rate at which commands may change", "m/s²", gt=0, le=1e6)
    angular_acceleration: float = quantity("rate at which commands may change", "rad/s²", gt=0, le=1e6)
    velocity_error: float = quantity(
        "bound of the difference between a guarded point's velocity and its command", "m/s", ge=0, le=FASTEST_OBSTACLE
    )
    discs: Literal[1, 2] = Field(
        default=1,
        description="discs about a body: one about the point `lookahead` ahead of the axle, or one about each half",
    )
    keep_right: float = quantity(
        "speed to the right of the line of sight, over the closing speed that the barrier takes; 0 for none",
        "-", ge=0, le=10, default=1.0,
    )  # fmt: skip


#: Control periods from one switch of the avoidance to the next within which the second one is fast.
FAST = 10
#: Time before and after an avoidance that counts as part of it in the chattering outside of avoidances [s].
SETTLING = 1.0


class AvoidanceSettings(Section):
    """Variable avoidance radius and slowdown, Eqs. (57)-(63), (71)."""

    margin: float = quantity("safety margin δ_Rd beyond obstacle and robot", "m", ge=0)
    largest_radius: float = quantity("bound R̄_b of the avoidance radius", "m", gt=0)
    kappa: float = quantity("gain κ of the expansion", "s", ge=0)
    gamma: float = quantity("divisor γ of the expansion", "-", gt=0)
    rho: float = quantity("decline ϱ of the expansion with distance", "1/m", ge=0)
    slowdown: float = quantity("share ρ_v of the reference velocity kept", "-", gt=0, le=1)
    hysteresis: float = quantity("distance beyond R_d at which an avoidance ends", "m", ge=0, le=FARTHEST, default=0.0)


class Window(Section):
    """A window of time, its begin included, its end not."""

    start: float = quantity("begin", "s", ge=0)
    stop: float = quantity("end", "s", ge=0)

    @model_validator(mode="after")
    def _order(self) -> Window:
        if self.stop < self.start:
            raise ValueError(f"stop = {self.stop:g} s lies before start = {self.start:g} s")
        return self


class DisturbanceSettings(Window):
    """One disturbance in one window of time."""

    kind: Literal["sinusoid", "constant"]
    angular_frequency: float = quantity("of a sinusoid", "rad/s", gt=0, default=1.0)
    phase: float = quantity("of a sinusoid at t = 0", "rad", ge=-FULL_TURN, le=FULL_TURN, default=0.0)
    v: float = quantity("velocity-equivalent amplitude, linear", "m/s")
    omega: float = quantity("velocity-equivalent amplitude, angular", "rad/s")
    force: float = quantity("force amplitude", "N")
    torque: float = quantity("torque amplitude", "N m")
    robots: Annotated[tuple[str, ...], Strict(False), Field(max_length=LONGEST_LIST)] | None = Field(
        default=None, description="all when absent"
    )

    @model_validator(mode="after")
    def _keys_of_a_sinusoid(self) -> DisturbanceSettings:
        for key in ("angular_frequency", "phase"):
            if self.kind == "constant" and key in self.model_fields_set:
                raise ValueError(f"{key} has no effect on a constant disturbance; leave it out")
        return self


class LoadSettings(Window):
    """Change of mass and inertia in a window of time."""

    mass_factor: float = quantity("loaded over nominal mass", "-", gt=0)
    inertia_factor: float = quantity("loaded over nominal inertia", "-", gt=0)


class Scenario(Section):
    """Everything a run depends on, rule files aside."""

    name: Printable
    run: Run
    reference: ReferenceSettings
    robots: dict[Printable, Robot] = Field(min_length=1, max_length=1000)
    formation: FormationSettings = FormationSettings()
    communication: Communication = Communication()
    obstacles: Annotated[tuple[Obstacle, ...], Strict(False), Field(max_length=LONGEST_LIST)] = ()
    avoidance: AvoidanceSettings
    safety: SafetySettings | None = Field(default=None, description="absent: commands are not filtered")
    disturbances: Annotated[tuple[DisturbanceSettings, ...], Strict(False), Field(max_length=LONGEST_LIST)] = ()
    load: LoadSettings
    rules: dict[str, RuleFile]
