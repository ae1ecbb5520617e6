"""Systems of python-control and scipy, and functions in Python, as plants of loops."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, TypeVar

import numpy as np

from fuzzyctl.diagnostics.diagnostic import ArgumentError, DiagnosticError, UnknownNameError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Expr, Keyword, Name, Number, replace_names
from fuzzyctl.interop.numbers import number, real
from fuzzyctl.interop.packages import required
from fuzzyctl.loading.load import look_through
from fuzzyctl.model.controller import Controller, Definition, Result, Signal, State
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.plant import Plant
from fuzzyctl.simulation.loop_params import blocks_of

#: Complex roots are conjugate up to this part of them.
CONJUGATE: Final = 1e-9
_Named = TypeVar("_Named", Signal, Definition)


def plant_of(system: Any, name: str = "plant") -> Plant | Controller:
    """Return a linear system as the plant that its `tf`, `zpk` or `ss` line in a rule file would be.

    Args:
        system: `TransferFunction` or `StateSpace` of python-control; `lti` or `dlti` of scipy.signal in any of their
            three forms. Transfer functions have one input and one output. Also a `NonlinearIOSystem` of python-control
            in continuous time, whose outputs depend on time and states alone.
        name: Its name.

    Returns:
        A plant whose states start at 0, with inputs `u` and outputs `y`, or `u1`, `u2` and `y1`, `y2`. A linear system
        in discrete time becomes a controller with the period of the system, whose outputs are held between its samples.

    Raises:
        ArgumentError: For another object, a name that no block can have, several inputs of a transfer function, a
            numerator of 0, complex roots without their conjugates, and discrete time without a period or not proper.
        ValueOutOfBoundsError: For coefficients that are complex or not finite.
        DiagnosticError: For a system in continuous time that is not proper.
    """
    _require_name(name)
    if hasattr(system, "dynamics") and not hasattr(system, "A") and not hasattr(system, "num_list"):
        return _nonlinear(system, name)
    period = getattr(system, "dt", None)
    if period is True:
        raise ArgumentError(f"{_kind(system)} is in discrete time without a sample time: give it one as 'dt'")
    if period:
        return _read(_discrete_text(name, float(period), *_matrices(system)), name)
    return _read(f"plant {name} = {_form(system)}\n", name)


def python_plant(
    name: str,
    inputs: Sequence[str],
    states: Mapping[str, float],
    outputs: Sequence[str],
    *,
    derivative: Callable[[float, tuple[float, ...], tuple[float, ...]], Sequence[float]],
    output: Callable[[float, tuple[float, ...]], Sequence[float]],
) -> Plant:
    """Return a plant whose equations are functions in Python, as `python("FILE")` takes them from a file.

    Args:
        name: Its name.
        inputs: Their names.
        states: Their names, with their starts.
        outputs: Their names.
        derivative: Returns the derivative of each state by time from the time [s], the states and the inputs.
        output: Returns the outputs from the time [s] and the states.

    Raises:
        ArgumentError: For a name that no signal can have, and two of the same name.
        ValueOutOfBoundsError: For a start that is not finite.
    """
    for one in (name, *inputs, *states, *outputs):
        _require_name(one)
    names = [*inputs, *states, *outputs]
    twice = next((n for k, n in enumerate(names) if n in names[:k]), None)
    if twice is not None:
        raise ArgumentError(f"'{twice}' names two of the inputs, states and outputs of plant '{name}'")
    return Plant(
        name=name,
        inputs=tuple(Signal(name=n) for n in inputs),
        states=tuple(State(name=n, start=Number(number(f"start of '{n}'", v))) for n, v in states.items()),
        results=tuple(Result(name=n, value=Name(n)) for n in outputs),
        python=f"<{name}>",
        calls=(derivative, output),
    )


def _nonlinear(system: Any, name: str) -> Plant:
    """Return a nonlinear system of python-control in continuous time as a plant."""
    if system.dt:
        raise ArgumentError(f"{_kind(system)} is in discrete time: a plant of a loop is in continuous time")

    def output(t: float, x: tuple[float, ...]) -> Any:
        result = system.output(t, x, np.full(system.ninputs, np.nan))
        if np.isnan(result).any() and not np.isnan(system.output(t, x, np.zeros(system.ninputs))).any():
            raise ArgumentError("the outputs depend on the inputs of the same instant: give it a state in between")
        return result

    return python_plant(
        name, _numbered("u", system.ninputs), dict.fromkeys(_numbered("x", system.nstates), 0.0),
        _numbered("y", system.noutputs), derivative=system.dynamics, output=output,
    )  # fmt: skip


def _numbered(letter: str, count: int) -> list[str]:
    """Return the names of several signals; that of a single input or output is the letter."""
    return [letter] if count == 1 and letter != "x" else [f"{letter}{k + 1}" for k in range(count)]


def with_plant(loop: Loop, block: str, system: Any) -> Loop:
    """Return a loop with a linear system in the place of one of its plants.

    Inputs and outputs keep the names, units and ranges that those of the replaced plant have, in order.

    Args:
        loop: The loop.
        block: Name of the block.
        system: As for `plant_of`, or a `Plant` or `Controller`.

    Raises:
        UnknownNameError: For a name of no block.
        ArgumentError: For a block that is a controller, another number of inputs or outputs, and what `plant_of`
            refuses.
        DiagnosticError: As for `plant_of`.
    """
    plants = {p.name: p for p in loop.plants}
    instance = next((i for i in loop.instances if i.name == block), None)
    if instance is None:
        raise UnknownNameError("block", block, tuple(i.name for i in loop.instances))
    if instance.controller not in plants:
        raise ArgumentError(f"block '{block}' is not a plant, but of the controller '{instance.controller}'")
    old = plants[instance.controller]
    replacement = system if isinstance(system, Plant | Controller) else plant_of(system)
    for what, mine, theirs in (("input", old.inputs, replacement.inputs), ("output", old.results, replacement.results)):
        if len(mine) != len(theirs):
            names = ", ".join(s.name for s in mine)
            raise ArgumentError(
                f"block '{block}' has {counted(len(mine), what)} ({names}), {_kind(system)} {len(theirs)}"
            )
    new = _renamed(replacement, old, _free_name(f"{block}_system", blocks_of(loop)))
    inputs = {s.name for s in old.inputs}
    arguments = tuple(a for a in instance.arguments if not isinstance(a, Keyword) or a.name in inputs)
    instances = tuple(
        dataclasses.replace(i, controller=new.name, arguments=arguments) if i is instance else i for i in loop.instances
    )
    used = {i.controller for i in instances}
    others = tuple(p for p in loop.plants if p.name in used)
    callees: dict[str, Any] = {"plants": others, "controllers": loop.controllers}
    callees[f"{new.kind}s"] += (new,)
    return dataclasses.replace(loop, instances=instances, **callees)


def _require_name(name: object) -> None:
    if not (isinstance(name, str) and name.isidentifier() and name.isascii()):
        raise ArgumentError(f"{name!r} is not a name: expected letters, digits and _")


def _kind(system: Any) -> str:
    return f"the {type(system).__name__}"


def _read(text: str, name: str) -> Plant | Controller:
    examined = look_through(SourceText(f"<{name}>", text))
    mistakes = [d for d in examined.diagnostics if d.severity == "error"]
    if mistakes:
        raise DiagnosticError(mistakes)
    return (examined.plants or examined.controllers)[0]


def _form(system: Any) -> str:
    """Return a continuous system as the one-line form of a plant."""
    if all(hasattr(system, n) for n in "ABCD"):
        a, b, c, d = _matrices(system)
        if not len(a):
            raise ArgumentError(f"{_kind(system)} has no states: a plant has one at least; write a gain in the loop")
        return f"ss(A={_rows(a)}, B={_rows(b)}, C={_rows(c)}, D={_rows(d)})"
    if hasattr(system, "gain") and not callable(system.zeros):
        zeros, poles = _roots(system.zeros), _roots(system.poles)
        return f"zpk(zeros={zeros}, poles={poles}, gain={number('gain', system.gain)!r})"
    num, den = _coefficients(system)
    return f"tf(num={_list(num)}, den={_list(den)})"


def _coefficients(system: Any) -> tuple[Sequence[float], Sequence[float]]:
    """Return numerator and denominator of a transfer function with one input and one output, without leading zeros."""
    if hasattr(system, "num_list"):  # python-control
        if (system.ninputs, system.noutputs) != (1, 1):
            raise ArgumentError(
                f"{_kind(system)} has {system.ninputs} inputs and {system.noutputs} outputs: convert it with control.ss"
            )
        num, den = system.num_list[0][0], system.den_list[0][0]
    elif hasattr(system, "num") and hasattr(system, "den"):  # scipy
        num, den = system.num, system.den
    else:
        raise ArgumentError(
            f"expected a system of python-control or an lti or dlti of scipy.signal, got {type(system).__name__}"
        )
    if np.ndim(num) != 1:
        raise ArgumentError(f"{_kind(system)} has several outputs: convert it with to_ss")
    num, den = (np.trim_zeros(real(what, one), "f") for what, one in (("numerator", num), ("denominator", den)))
    if not len(num):
        raise ArgumentError(f"the numerator of {_kind(system)} is 0: its output is 0 for all inputs")
    return num.tolist(), den.tolist()


def _matrices(system: Any) -> tuple[np.ndarray[Any, Any], ...]:
    """Return the matrices A, B, C, D of a linear system."""
    if not all(hasattr(system, n) for n in "ABCD"):
        _coefficients(system) if not hasattr(system, "gain") else None
        try:
            system = system.to_ss() if hasattr(system, "to_ss") else required("control", "control").ss(system)
        except ValueError as error:
            raise ArgumentError(f"{_kind(system)} has no state space: {error}") from error
    return tuple(np.atleast_2d(real(f"matrix {n}", getattr(system, n))) for n in "ABCD")


def _list(values: Sequence[float]) -> str:
    return f"[{', '.join(repr(float(v)) for v in values)}]"


def _rows(matrix: np.ndarray[Any, Any]) -> str:
    return f"[{', '.join(_list(row) for row in matrix.tolist())}]"


def _roots(roots: Any) -> str:
    """Return real roots as numbers, and pairs of conjugate ones as `pair(a, b)`."""
    numbers = np.atleast_1d(np.asarray(roots, dtype=np.complex128))
    real("roots", [numbers.real, numbers.imag])
    above, below = (sorted(numbers[s * numbers.imag > 0.0], key=lambda r: (r.real, abs(r.imag))) for s in (1, -1))
    if not (len(above) == len(below) and np.allclose(above, np.conj(below), rtol=CONJUGATE, atol=0.0)):
        raise ArgumentError(
            f"roots {numbers.tolist()} are not those of real coefficients: a complex one has no conjugate"
        )
    texts = [repr(float(root.real)) for root in numbers[numbers.imag == 0.0]]
    texts += [f"pair({float(root.real)!r}, {float(root.imag)!r})" for root in above]
    return f"[{', '.join(texts)}]"


def _discrete_text(name: str, period: float, *matrices: np.ndarray[Any, Any]) -> str:
    a, b, c, d = (m.tolist() for m in matrices)
    count = [len(d[0]), len(d)]
    u, y = (_numbered(letter, n) for letter, n in zip("uy", count, strict=True))
    x = _numbered("x", len(a))
    lines = [f"controller {name}", *(f"input {n}" for n in u), *(f"state {n} = 0" for n in x)]
    lines += [f"next {n} = {_sum((*row, *more), (*x, *u))}" for n, row, more in zip(x, a, b, strict=True)]
    lines += [f"output {n} = {_sum((*row, *more), (*x, *u))}" for n, row, more in zip(y, c, d, strict=True)]
    return "\n".join([*lines, f"every {period!r} s", ""])


def _sum(factors: Sequence[float], names: Sequence[str]) -> str:
    terms = [f"({factor!r}) * {name}" for factor, name in zip(factors, names, strict=True) if factor != 0.0]
    return " + ".join(terms) or "0"


def _free_name(name: str, names: Mapping[str, object]) -> str:
    while name in names:
        name = f"{name}_"
    return name


def _renamed(block: Plant | Controller, like: Plant, name: str) -> Plant | Controller:
    """Return a block with the signals of another one, and names that these do not have."""
    signals = {s.name: o for s, o in zip((*block.inputs, *block.results), (*like.inputs, *like.results), strict=True)}
    by_name = {o.name: o for o in signals.values()}
    names = {old: new.name for old, new in signals.items()}
    statements: list[Signal | Definition] = [*block.states, *block.definitions]
    for item in statements:
        names[item.name] = _free_name(item.name, by_name)
    values: dict[str, Expr] = {old: Name(new) for old, new in names.items()}

    def renamed(items: Sequence[_Named]) -> tuple[_Named, ...]:
        changed = []
        for item in items:
            like = signals.get(item.name)
            fields: dict[str, Any] = {"name": names[item.name]}
            if like is not None:
                fields |= {"label": like.label, "unit": like.unit, "bounds": like.bounds}
            if hasattr(item, "value"):
                fields["value"] = replace_names(item.value, values)
            changed.append(dataclasses.replace(item, **fields))
        return tuple(changed)

    moves = "derivatives" if isinstance(block, Plant) else "updates"
    parts: dict[str, Any] = {
        n: renamed(getattr(block, n)) for n in ("inputs", "states", "definitions", "results", moves)
    }
    return dataclasses.replace(block, name=name, **parts)
