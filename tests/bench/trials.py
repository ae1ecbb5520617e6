"""The optimisations of kernels, how each is switched off, and systems of the sizes for which they are made."""

from __future__ import annotations

import random
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import product
from pathlib import Path
from typing import Any

import fuzzyctl
from fuzzyctl import DiagnosticError, FuzzySystem
from fuzzyctl.kernels.algorithms import interpolation, select
from fuzzyctl.kernels.backends import numpy_backend
from fuzzyctl.kernels.backends.numba import machine_code
from fuzzyctl.kernels.backends.numba import source as numba_backend
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.inference.defuzzify import centroid, defuzzify
from fuzzyctl.kernels.program import scalar
from fuzzyctl.kernels.program.printer import SCALAR, counted_or_searched
from tests.bench.growth import complete

ROOT = Path(__file__).parents[2]
#: Where files of rules are that people have: shipped ones, the gallery, published ones, those of other tools.
PLACES = ("rules", "apps/gallery", "tests/registry/published", "tests/peers/documentation", "tests/fuzzyctl/formats")


@cache
def files() -> dict[str, FuzzySystem]:
    """Return the systems of all files of rules, by the name of the file and of the system."""
    found: dict[str, FuzzySystem] = {}
    for path in (p for place in PLACES for p in sorted((ROOT / place).rglob("*"))):
        if path.suffix in (".fz", ".fis", ".fll", ".fcl", ".fml"):
            with suppress(DiagnosticError):  # some show mistakes
                found |= {f"{path.name} {b.name}": b for b in fuzzyctl.load_all(path) if isinstance(b, FuzzySystem)}
    return found


def sugeno(inputs: int, terms: int, kind: str = "gaussian") -> str:
    """Return a complete first-order Takagi-Sugeno table."""
    rng = random.Random(1)
    lines = ["system s", "and product", "defuzzifier weighted_average"]
    for i in range(inputs):
        lines.append(f"input x{i} in [0, 1]")
        shape = "{}, 0.2" if kind == "gaussian" else "{} - 0.3, {}, {} + 0.3"
        lines += [f"  t{k} = {kind}({shape.replace('{}', repr(k / (terms - 1)))})" for k in range(terms)]
    combinations = list(product(range(terms), repeat=inputs))
    lines.append("output u in [-50, 50]")
    for n, _ in enumerate(combinations):
        lines.append(f"  c{n} = linear({', '.join(f'{rng.uniform(-2, 2):.3f}' for _ in range(inputs + 1))})")
    for n, own in enumerate(combinations):
        lines.append(f"if {' and '.join(f'x{i} is t{k}' for i, k in enumerate(own))} then u is c{n}")
    return "\n".join(lines) + "\n"


def mamdani(terms: int, defuzzifier: str = "centroid") -> str:
    """Return a table of two inputs whose consequents follow no pattern."""
    rng = random.Random(1)
    names = " ".join(f"t{k}" for k in range(terms))
    lines = ["system s", f"defuzzifier {defuzzifier}"]
    lines += [line for v in ("input x0", "input x1", "output u") for line in (f"{v} in [0, 1]", f"  terms {names}")]
    lines += ["table u = x0 x x1", f"  {names}"]
    lines += [f"  t{k} | {' '.join(rng.choices(names.split(), k=terms))}" for k in range(terms)]
    return "\n".join(lines) + "\n"


def curves(count: int, corners: int) -> str:
    """Return a system of measured curves of many corners."""
    rng = random.Random(1)
    lines = ["system s", "defuzzifier weighted_average"]
    for i in range(2):
        lines.append(f"input x{i} in [0, 1]")
        for k in range(count // 2):
            pairs = ", ".join(f"{n / (corners - 1):.6g}, {rng.uniform(0.1, 1):.3f}" for n in range(corners))
            lines.append(f"  t{k} = piecewise({pairs})")
    lines += ["output u in [0, 1]", *(f"  c{k} = constant({k / count})" for k in range(count // 2))]
    lines += [f"if x0 is t{k} and x1 is t{k} then u is c{k}" for k in range(count // 2)]
    return "\n".join(lines) + "\n"


SIZES: Mapping[str, str] = {
    "product, 729 rules of 6 inputs": complete(6, 3, "product", "weighted_average"),
    "product, 256 rules of 8 inputs": complete(8, 2, "product", "weighted_average"),
    "product, 441 rules of 2 inputs": complete(2, 21, "product", "weighted_average"),
    "min, 625 rules of 4 inputs": complete(4, 5, "min", "weighted_average"),
    "min, 121 rules of 2 inputs": complete(2, 11, "min", "weighted_average"),
    "centroid, 49 rules, any table": mamdani(7),
    "centroid, 121 rules, any table": mamdani(11),
    "centroid(resolution=100), 49 rules": mamdani(7, "centroid(resolution=100)"),
    "bisector, 9 rules, any table": mamdani(3, "bisector"),
    "Sugeno, Gaussian, 49 rules of 2 inputs": sugeno(2, 7),
    "Sugeno, Gaussian, 125 rules of 3 inputs": sugeno(3, 5),
    "Sugeno, triangles, 49 rules of 2 inputs": sugeno(2, 7, "triangle"),
    "20 curves of 50 corners": curves(20, 50),
}


@dataclass(frozen=True)
class Optimisation:
    """One optimisation.

    Args:
        name: Its name in docs/explanation/optimisations.md.
        patches: Owner, attribute and value of what switches it off.
    """

    name: str
    patches: tuple[tuple[Any, str, Any], ...]


def _refused(*_given: Any, **_named: Any) -> str:
    return "it is switched off"


def _dialects(**changed: Any) -> tuple[tuple[Any, str, Any], ...]:
    names = ("COMPILED", "_COMPILED_MANY")
    return tuple((numba_backend, n, replace(getattr(numba_backend, n), **changed)) for n in names)


class _InText(numba_backend.Numbers):
    """The numbers of a program, all of them in its text."""

    def __init__(self, program: Any) -> None:
        super().__init__(program)
        self.shares, self.values = False, []


_ALL_COUNTED = partial(counted_or_searched, most=10**9)

_INTERPRETED = scalar.INTERPRETED
_EVALUATION = inference.evaluation

OPTIMISATIONS = (
    Optimisation("interpolation", ((select, "grid_of", _refused),)),
    Optimisation("cells", ((interpolation, "_has_cells", lambda *_: False),)),
    Optimisation("loops over corners", ((interpolation, "LOOPED", 99),)),
    Optimisation("rule cells", ((select.rule_cells, "active_of", _refused),)),
    Optimisation("neighbours", ((centroid, "is_handover", lambda _: False),)),
    Optimisation("exact bisector", ((defuzzify, "LARGEST", -1),)),
    Optimisation("tables of degrees", ((inference, "degree_of", lambda _, term, x: term.degree(x)),)),
    Optimisation("decisions", ((scalar, "INTERPRETED", replace(_INTERPRETED, locate=_ALL_COUNTED)),)),
    Optimisation("search", _dialects(locate=_ALL_COUNTED)),
    Optimisation("intrinsics", _dialects(smaller=SCALAR.smaller, larger=SCALAR.larger)),
    Optimisation(
        "degrees without choices",
        ((inference, "evaluation", lambda *own, many=False, **named: _EVALUATION(*own, **named)),),
    ),
    Optimisation("release", ((numpy_backend, "_last_uses", lambda program: [set() for _ in program.body]),)),
    Optimisation("parameters", ((machine_code, "Numbers", _InText),)),
)
