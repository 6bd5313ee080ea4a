"""Differential equations as transitions of a model of one's own.

    d/dt x = rate(x, w, …)   →   x_{k+1} = f(x_k, w_k, Δt, …)

w is white noise of density 1, held over a step at w_k / √Δt, w_k ~ N(0, I): a rate that reads
``2 * w[0]`` is driven by noise of density 2 (its unit per √Hz), however long the steps are. A
disturbance of standard deviation s that is constant over steps of T seconds is ``s √T w``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import casadi as ca
import numpy as np

from models.errors import InputError
from models.implicit_steps import collocation_step, cvodes_step
from models.names import unknown
from models.own_arguments import check_arguments
from models.own_sensors import column

Rate = Callable[..., ca.SX]
"""(x (n_x,), w (n_w,), …) → d/dt x (n_x,); what a model gives behind Δt comes behind w."""
Transition = Callable[..., ca.SX]
"""(x (n_x,), w (n_w,), Δt, …) → x_{k+1} (n_x,)."""
Step = Callable[[Callable[[ca.SX], ca.SX], ca.SX, ca.SX], ca.SX]
"""(x → d/dt x, x, h) → x after h seconds."""

MORE = ((), ("u or p",), ("u", "p"))
"""What a rate takes behind w, by how many of inputs and parameters the model has."""
SHORTEST_STEP_S = 1e-12
"""Noise is held at w / √Δt from here on; a step of nothing moves nothing."""
MOST_HALVINGS = 10
"""A step is cut at most into 2^this with `longest_step_s`."""


def _euler(slope: Callable[[ca.SX], ca.SX], x: ca.SX, h: ca.SX) -> ca.SX:
    return x + h * slope(x)


def _rk4(slope: Callable[[ca.SX], ca.SX], x: ca.SX, h: ca.SX) -> ca.SX:
    k1 = slope(x)
    k2 = slope(x + h / 2 * k1)
    k3 = slope(x + h / 2 * k2)
    k4 = slope(x + h * k3)
    return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


FORMULAS: Mapping[str, Step] = MappingProxyType({"rk4": _rk4, "euler": _euler})
"""Explicit methods, written out."""
SOLVED = MappingProxyType({"collocation": collocation_step, "cvodes": cvodes_step})
"""Methods that solve equations: functions that the model calls."""


def ode(
    rate: Rate,
    *,
    method: str = "rk4",
    substeps: int = 1,
    longest_step_s: float | None = None,
) -> Transition:
    """Return the transition that follows a differential equation; see the module's equations.

    Parameters
    ----------
    rate : (x (n_x,), w (n_w,)) → d/dt x (n_x,), in symbols. What a model gives behind Δt, inputs
        u (n_u,) and parameters p (n_p,), comes behind w and is held over the step
    method : ``rk4`` (order 4) and ``euler`` (order 1) are explicit. ``collocation`` (Radau IIA,
        order 5) is implicit, for stiff equations: it solves for three stages by Newton's method;
        a step that it cannot solve is NaN, and the estimator says so. ``cvodes`` chooses its own
        steps by tolerance; no C can be written of it, so that such a model runs interpreted and
        is not exported
    substeps : equal ones per step; more is more accurate and costs as much more
    longest_step_s : instead of `substeps`: every step is halved until none is longer, at most
        `MOST_HALVINGS` times. It costs what the step needs; smaller is more accurate

    Raises
    ------
    InputError
        If the method is unknown, or a setting is outside its range or not read by the method.
    """
    if method not in FORMULAS and method not in SOLVED:
        raise unknown("method", method, (*FORMULAS, *SOLVED))
    if isinstance(substeps, bool) or not isinstance(substeps, int) or substeps < 1:
        raise InputError(f"substeps is {substeps!r}, expected a whole number of at least 1")
    if longest_step_s is not None and not longest_step_s > 0:
        raise InputError(f"longest_step_s is {longest_step_s}, expected a positive time")
    if longest_step_s is not None and substeps > 1:
        raise InputError(
            f"substeps is {substeps} and longest_step_s is {longest_step_s}, expected one of them"
        )
    if method == "cvodes" and (longest_step_s is not None or substeps > 1):
        raise InputError("cvodes chooses its own steps, expected no substeps or longest_step_s")

    def transition(x: ca.SX, w: ca.SX, dt: ca.SX, *more: ca.SX) -> ca.SX:
        check_arguments("rate", rate, ("x", "w", *MORE[len(more)]))
        step = _step_function(rate, method, [x, w, *more])
        held = ca.vertcat(w / ca.sqrt(ca.fmax(dt, SHORTEST_STEP_S)), *more)
        if longest_step_s is not None:
            return _halved(step, x, held, dt, longest_step_s)
        for _ in range(substeps):
            x = step(x, held, dt / substeps)
        return x

    return transition


def _step_function(rate: Rate, method: str, arguments: list[ca.SX]) -> ca.Function:
    """Return (x, all that is held, h) → x after h seconds."""
    sizes = [argument.numel() for argument in arguments]
    x, h = ca.SX.sym("x", sizes[0]), ca.SX.sym("h")
    held = [ca.SX.sym("held", size) for size in sizes[1:]]

    def slope(at: ca.SX) -> ca.SX:
        return column(rate(at, *held), sizes[0], "rate", "state")

    if method in FORMULAS:
        after = FORMULAS[method](slope, x, h)
        return ca.Function("step", [x, ca.vertcat(*held), h], [after], {"always_inline": True})
    return SOLVED[method](slope(x), x, ca.vertcat(*held), h)


def _halved(step: ca.Function, x: ca.SX, held: ca.SX, dt: ca.SX, longest_step_s: float) -> ca.SX:
    """Return x after Δt in 2^k equal steps, none longer; only the steps needed are made."""
    arguments = ca.MX.sym("x", x.numel()), ca.MX.sym("held", held.numel()), ca.MX.sym("h")
    x_in, held_in, h_in = arguments
    repeated = [_called("once", arguments, step(*arguments))]
    for _ in range(MOST_HALVINGS):
        half = repeated[-1]
        after = half(half(x_in, held_in, h_in / 2), held_in, h_in / 2)
        repeated.append(_called("twice", arguments, after))
    times = ca.ceil(ca.log(ca.fmax(h_in / longest_step_s, 1.0)) / np.log(2.0) - 1e-9)
    branch = ca.Function.conditional("branch", repeated[:-1], repeated[-1])
    return _called("halved", arguments, branch(times, *arguments))(x, held, dt)


def _called(name: str, arguments: tuple[ca.MX, ...], after: ca.MX) -> ca.Function:
    """Return a function that stays one: written out, repeated steps would double the code."""
    return ca.Function(name, arguments, [after], {"never_inline": True})
