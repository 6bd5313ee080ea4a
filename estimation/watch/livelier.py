"""The same estimator for a body that moves more than its model says."""

from __future__ import annotations

from typing import Any

import casadi as ca

from models.state_space import StateSpaceModel

LEVELS = (1.0, 4.0, 16.0, 32.0)
"""By how much its process noise is larger, in standard deviations."""


def factor_down(level: int) -> float:
    """Return by how much energies grow where a motion of a level is taken for one level less."""
    return (LEVELS[level] / LEVELS[level - 1]) ** 2


def livelier_model(model: StateSpaceModel, factor: float) -> StateSpaceModel:
    """Return a model whose process noise is larger by a factor."""
    f: Any = model.f
    kind = ca.SX if f.is_a("SXFunction") else ca.MX
    given = [kind.sym(f.name_in(i), f.sparsity_in(i)) for i in range(f.n_in())]
    x, w, *rest = given
    moved = f(x, factor * w, *rest)
    names = [[f.name_in(i) for i in range(f.n_in())], [f.name_out(0)]]
    made: Any = ca.Function
    return model.replace(f=made(f.name(), given, [moved], *names))


class MotionLevels:
    """An estimator and its livelier ones, each made when it is first needed."""

    def __init__(self, estimator: Any) -> None:
        self._made = {0: estimator}

    @property
    def count(self) -> int:
        """How many there may be."""
        return len(LEVELS) if hasattr(self._made[0], "config") else 1

    def __getitem__(self, level: int) -> Any:
        if level not in self._made:
            usual = self._made[0]
            model = livelier_model(usual.model, LEVELS[level])
            self._made[level] = type(usual)(model, usual.config)
        return self._made[level]
