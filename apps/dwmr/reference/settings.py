"""Settings of references in a scenario: one section for each kind, chosen by `kind`."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, Strict, model_validator

from dwmr.config.quantities import FARTHEST, Section, place, quantity

#: A place in the plane, x and y [m].
Coordinate = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST)]
Point = Annotated[tuple[Coordinate, Coordinate], Strict(False)]


class Eight(Section):
    """Figure eight, Eq. (76)."""

    kind: Literal["eight"]
    amplitude_x: float = quantity("half the extent along x", "m", gt=0, le=FARTHEST)
    amplitude_y: float = quantity("half the extent along y", "m", gt=0, le=FARTHEST)
    period: float = quantity("time of one round", "s", ge=1e-3)
    along: Literal["x", "y"] = Field(
        default="y", description="axis along which the two loops lie; the other one is travelled twice per period"
    )


class Circle(Section):
    """Circle at constant speed."""

    kind: Literal["circle"]
    centre_x: float = place("centre, x")
    centre_y: float = place("centre, y")
    radius: float = quantity("radius", "m", gt=0, le=FARTHEST)
    period: float = quantity("time of one round", "s", ge=1e-3)
    direction: Literal["counter-clockwise", "clockwise"] = Field(description="sense of travel")
    start_angle: float = quantity("angle of the place at t = 0, seen from the centre", "rad", default=0.0)


class Line(Section):
    """Straight line at constant speed."""

    kind: Literal["line"]
    start_x: float = place("place at t = 0, x")
    start_y: float = place("place at t = 0, y")
    angle: float = quantity("direction, counter-clockwise from the x axis", "rad")
    speed: float = quantity("speed", "m/s", gt=0, le=1e6)


class Waypoints(Section):
    """Smooth path through places at nearly constant speed; an open one goes on straight behind its last place."""

    kind: Literal["waypoints"]
    points: Annotated[tuple[Point, ...], Strict(False)] = Field(
        description="places [x, y] in order", min_length=2, max_length=2000, json_schema_extra={"unit": "m"}
    )
    closed: bool = Field(default=False, description="whether the path leads back to its first place, again and again")
    speed: float | None = quantity("speed", "m/s", gt=0, le=1e6, default=None)
    duration: float | None = quantity("time of the whole way, or of one round", "s", ge=1e-3, default=None)

    @model_validator(mode="after")
    def _one_tempo(self) -> Waypoints:
        if (self.speed is None) == (self.duration is None):
            raise ValueError(f"give speed or duration{', not both' if self.speed is not None else ''}")
        return self


class CsvPath(Section):
    """Smooth path through the rows of a CSV file; an open one goes on straight behind its last row."""

    kind: Literal["csv"]
    file: str = Field(description="CSV file with the columns t [s], x [m], y [m], beside the scenario", min_length=1)
    closed: bool = Field(default=False, description="whether the last row is the first place again, and so on")


ReferenceSettings = Annotated[Eight | Circle | Line | Waypoints | CsvPath, Field(discriminator="kind")]
