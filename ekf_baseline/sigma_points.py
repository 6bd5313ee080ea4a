"""A model's functions at many points at once: generated, compiled where there is a compiler."""

from __future__ import annotations

import casadi as ca
import numpy as np

from estimation import native
from estimation.chosen import chosen
from estimation.function_call import FunctionCall
from estimation.symbolic_stage import stacked_residual, step_symbols
from models.arrays import Array
from models.state_space import StateSpaceModel


class SigmaPoints:
    """What a model makes of points x ⊞ δᵢ; one instance owns work buffers, for one thread."""

    def __init__(self, model: StateSpaceModel) -> None:
        x, delta = ca.SX.sym("x", model.n_x), ca.SX.sym("delta", model.n_x)
        origin, w, dt = (
            ca.SX.sym("origin", model.n_x),
            ca.SX.sym("w", model.n_w),
            ca.SX.sym("dt"),
        )
        y, r = ca.SX.sym("y", model.n_row), ca.SX.sym("r", model.n_r)
        u = list(step_symbols(model).values())
        at = model.retract(x, delta)
        reached = model.f(at, w, dt, *u)
        self._reach = _call("ukf_reach", [x, w, dt, *u], model.f(x, w, dt, *u))
        self._reach_all = _call(
            "ukf_reach_all",
            [x, delta, w, origin, dt, *u],
            model.difference(reached, origin),
            (2 * (model.n_x + model.n_w), [1, 2]),
        )
        self._read = _call("ukf_read", [x, y], stacked_residual(model, y, x))
        self._read_all = _call(
            "ukf_read_all",
            [x, delta, y, r],
            stacked_residual(model, y, at) - r,
            (2 * model.n_x, [1]),
        )
        self._seen_from = _call(
            "ukf_seen_from",
            [x, delta, origin],
            model.difference(at, origin),
            (2 * model.n_x, [1]),
        )
        self._retract = _call("ukf_retract", [x, delta], at)
        self._no_noise = np.zeros(model.n_w)

    def reached(
        self, x: Array, delta: Array, w: Array, dt: float, inputs: tuple[Array, ...]
    ) -> tuple[Array, Array]:
        """Return f(x, 0) (n_x,) and f(x ⊞ δᵢ, wᵢ) ⊟ f(x, 0) (n_x, 2 (n_x + n_w)).

        Parameters
        ----------
        delta, w : (n_x, n), (n_w, n)
        inputs : (n_u,) at both ends of the step, where the model has some
        """
        [central] = self._reach(x, self._no_noise, dt, *inputs)
        [apart] = self._reach_all(x, delta, w, central, dt, *inputs)
        return central, apart

    def read(self, x: Array, delta: Array, y: Array) -> tuple[Array, Array]:
        """Return residual(y, x) (n_r,) and residual(y, x ⊞ δᵢ) less that (n_r, 2 n_x)."""
        [central] = self._read(x, y)
        [apart] = self._read_all(x, delta, y, central)
        return central, apart

    def seen_from(self, origin: Array, x: Array, delta: Array) -> Array:
        """Return (x ⊞ δᵢ) ⊟ origin (n_x, 2 n_x)."""
        [apart] = self._seen_from(x, delta, origin)
        return apart

    def retract(self, x: Array, delta: Array) -> Array:
        """Return x ⊞ δ (n_x,)."""
        [moved] = self._retract(x, delta)
        return moved


def _call(
    name: str,
    given: list[ca.SX],
    result: ca.SX,
    several: tuple[int, list[int]] | None = None,
) -> FunctionCall:
    """Return a function on arrays.

    Parameters
    ----------
    several : at how many points at once, and which arguments differ from point to point
    """
    function = ca.Function(name, given, [ca.densify(result)], {"cse": True})
    if several is not None:
        n, differ = several
        same = [i for i in range(len(given)) if i not in differ]
        function = function.map(name, "serial", n, same, [])
    made = function
    return FunctionCall(chosen(lambda: native.compiled(made), lambda: made))
