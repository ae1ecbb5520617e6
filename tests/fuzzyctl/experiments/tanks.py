"""Tanks that run dry: what experiments run in the tests."""

import hashlib
import os
import signal
from dataclasses import dataclass
from pathlib import Path

from fuzzyctl.diagnostics.diagnostic import DiagnosticError, UnknownNameError
from fuzzyctl.experiments.runnable import Computed, Prepared, Runnable, UsedFile
from fuzzyctl.experiments.scenario_keys import Places, override
from fuzzyctl.experiments.scenario_layers import Shipped, merge, read_layers

#: What a tank may say.
KEYS = ("area", "level", "steps", "seed", "law")
VALVES = ("open", "shut")


@dataclass(frozen=True)
class Tank:
    name: str
    path: Path
    settings: dict
    places: Places
    sha256: str
    warnings: tuple = ()

    @property
    def texts(self):
        return self.places.texts()


@dataclass(frozen=True)
class Tanks(Runnable[Tank]):
    """A level that falls by level / area in each step; a level above 100 stops the run.

    Args:
        folder: Of the shipped tanks.
        dies_at: A worker is killed by a run with this level.
        raises_at: Computing a run with this level is a mistake.
    """

    seed = "tank.seed"

    folder: Path = Path()
    dies_at: float = float("nan")
    raises_at: float = float("nan")

    def read(self, path, overrides):
        layers = read_layers(path, Shipped(self.folder))
        written = {}
        data, places = merge(layers, written, {})
        for argument in overrides:
            key, given = override(data, argument)
            written[key] = given
        found = [
            places.diagnostic("FZ902", f"tank.{key}", f"unknown key tank.{key}", help=places.did_you_mean(key, KEYS))
            for key in data["tank"]
            if key not in KEYS
        ]
        if data["tank"]["area"] <= 0:
            found.append(places.diagnostic("FZ904", "tank.area", f"tank.area must be > 0, got {data['tank']['area']}"))
        if found:
            raise DiagnosticError(found)
        return Tank(path.stem, path, data, places, hashlib.sha256(layers[0].content).hexdigest())

    def controllers(self, scenario, names):
        for name in names:
            if name not in VALVES:
                raise UnknownNameError("valve", name, VALVES)
        return tuple(names) or ("open",)

    def measures(self, scenario, controllers):
        return ("level",)

    def check(self, scenario, controllers):
        return self._used(scenario)

    def prepare(self, scenario, controller, measures):
        tank = scenario.settings["tank"]

        def compute():
            if tank["level"] == self.dies_at:
                os.kill(os.getpid(), signal.SIGKILL)
            if tank["level"] == self.raises_at:
                raise DiagnosticError([scenario.places.diagnostic("FZ904", "tank.level", "the valve broke")])
            level = tank["level"]
            for _ in range(tank["steps"]):
                level -= level / tank["area"] * (controller == "open")
            row = {"stopped": level > 100, "stop_reason": "it flows over" if level > 100 else None}
            return Computed({**row, **{f"measures.{name}": {"level": level}[name] for name in measures}}, 0.0)

        return Prepared(self._used(scenario), compute)

    def unread(self, scenario, controllers, used, key):
        return "the area" if key[-1] == "area" and list(controllers) == ["shut"] else ""

    def unit(self, scenario, column):
        return "m" if column == "measures.level" else ""

    def _used(self, scenario):
        """The text of a law that the tank names."""
        name = scenario.settings["tank"].get("law")
        path = scenario.path.parent / str(name)
        return {name: UsedFile(path, hashlib.sha256(path.read_bytes()).hexdigest())} if name else {}
