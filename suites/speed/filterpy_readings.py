"""Ways in which h and H of a model reach a filter that asks for them as callbacks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Protocol

import casadi as ca
import numpy as np

from estimation.native import compiled
from models.arrays import Array
from models.state_space import StateSpaceModel
from suites.bound_call import BoundCall


class Readings(Protocol):
    """h and H of all sensors of a model, stacked."""

    def expect(self, x: Array) -> None:
        """Get ready for a predicted state (n_x,); outside the clock."""

    def h(self, x: Array) -> Array:
        """Return h(x), (n_y,)."""

    def H(self, x: Array) -> Array:
        """Return the derivative of h at x, (n_y, n_x)."""


def reading_functions(model: StateSpaceModel) -> tuple[ca.Function, ca.Function]:
    """Return h and H as CasADi functions with dense results."""
    x = ca.SX.sym("x", model.n_x)
    h = ca.vertcat(*(sensor.h(x) for sensor in model.sensors))
    return (
        ca.Function("h", [x], [ca.densify(h)]),
        ca.Function("H", [x], [ca.densify(ca.jacobian(h, x))]),
    )


class Calls:
    """CasADi functions called as CasADi documents it, results made NumPy arrays."""

    def __init__(self, model: StateSpaceModel) -> None:
        self._h, self._H = reading_functions(model)

    def expect(self, x: Array) -> None:
        """Do nothing."""

    def h(self, x: Array) -> Array:
        """Call h."""
        return np.asarray(self._h(x).full()[:, 0])

    def H(self, x: Array) -> Array:
        """Call H."""
        return np.asarray(self._H(x).full())


class Buffers:
    """The functions compiled, between fixed arrays: a result is overwritten by the next."""

    def __init__(self, model: StateSpaceModel) -> None:
        self._h, self._H = (BoundCall(compiled(f)) for f in reading_functions(model))
        # CasADi stores column by column.
        self._slopes = self._H.results[0].reshape(model.n_x, model.n_y).T

    def expect(self, x: Array) -> None:
        """Do nothing."""

    def h(self, x: Array) -> Array:
        """Evaluate h."""
        self._h.arguments[0][:] = x
        self._h.evaluate()
        return self._h.results[0]

    def H(self, x: Array) -> Array:
        """Evaluate H."""
        self._H.arguments[0][:] = x
        self._H.evaluate()
        return self._slopes


class Arrays:
    """Values made beforehand: a callback costs nothing."""

    def __init__(self, model: StateSpaceModel) -> None:
        self._buffers = Buffers(model)

    def expect(self, x: Array) -> None:
        """Evaluate both."""
        h, H = self._buffers.h(x), self._buffers.H(x)
        self._values, self._slopes = h.copy(), H.copy(order="K")

    def h(self, x: Array) -> Array:
        """Hand over h."""
        return self._values

    def H(self, x: Array) -> Array:
        """Hand over H."""
        return self._slopes


READINGS: Mapping[str, Callable[[StateSpaceModel], Readings]] = MappingProxyType(
    {"calls": Calls, "buffers": Buffers, "arrays": Arrays}
)
"""Name of a way → what makes it for a model."""
