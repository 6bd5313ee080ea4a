"""`mhe` on windows with active constraints, against IPOPT and against OSQP.

IPOPT starts where `mhe` starts. Its barrier keeps a weakly active state off its bound by about
the root of its complementarity, so its word is good to 4e-7 standard deviations there. Where the
rows are stiff it may stop early: a sequence of QPs (`mhe.sparse_qp.sequential_qp`) then carries on
there.
The same, from where `mhe` ended, should not move: it has no barrier, and tells the multipliers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from estimation.status import Status
from mhe.config import MheConfig, MheIpoptConfig
from mhe.constraint_rows import constrain_function, demanded
from mhe.realtime import Mhe
from mhe.reference.ipopt import MheIpopt
from mhe.sparse_qp.sequential_qp import SequentialQp
from mhe.trajectory import WindowSolution
from models.arrays import Array
from tests.mhe.bounded_cases import bounded_case
from tests.mhe.bounded_windows import BoundedKey, BoundedWindow, bounded_window

LIMIT = 1e-6
"""How far states may be apart in the same minimum, and a row be exceeded, in standard deviations
of the newest state: Gauss-Newton's, which no constraint narrows."""
SAME_COST = 1e-6
"""Costs farther apart than this, relative, are those of different minima."""
ACTIVE = 1e-8
"""A row nearer to its limit than this, in standard deviations, is active."""
WEAK = 1e-4
"""An active row that costs less than this per standard deviation is weakly active."""


@dataclass(frozen=True)
class BoundedRow:
    """What became of one window.

    Parameters
    ----------
    status, ipopt_status, osqp_status : of the solvers
    ipopt_distance, osqp_distance : of their states from `mhe`'s, the largest over the window
    carried_distance : the same of IPOPT's, carried on by QPs where it is too far
    relative : (J - J of IPOPT) / max(1, |J of IPOPT|)
    excess : what `mhe`'s states exceed a demanded row by at most
    active, weak : numbers of rows, all stages together
    iterations, ipopt_iterations : of the solvers
    """

    key: BoundedKey
    status: Status
    ipopt_status: Status
    osqp_status: Status
    ipopt_distance: float
    osqp_distance: float
    carried_distance: float
    relative: float
    excess: float
    active: int
    weak: int
    iterations: int
    ipopt_iterations: int

    @property
    def is_optimal(self) -> bool:
        """Whether `mhe` says solved, obeys, and OSQP leaves its solution where it is."""
        near = self.osqp_status is Status.SOLVED and self.osqp_distance <= LIMIT
        return self.status.is_solved and near and self.excess <= LIMIT

    @property
    def is_ipopts(self) -> bool:
        """Whether it is where IPOPT ends, or was going."""
        return self.carried_distance <= LIMIT

    @property
    def is_other_minimum(self) -> bool:
        """Whether it is not, and IPOPT's cost is that of another minimum."""
        return not self.is_ipopts and abs(self.relative) > SAME_COST


@cache
def _solvers(case: str, horizon: int) -> tuple[Mhe, MheIpopt, SequentialQp]:
    model = bounded_case(case).bounded
    ours = MheConfig(horizon=horizon, tolerance=1e-10, max_iterations=3000)
    its = MheIpoptConfig(horizon=horizon, tolerance=1e-12, max_iterations=500)
    return Mhe(model, ours), MheIpopt(model, its), SequentialQp(model, ours)


def compare(key: BoundedKey) -> BoundedRow:
    """Solve a window with all three."""
    window, (mhe, ipopt, osqp) = bounded_window(key), _solvers(key.case, key.horizon)
    given = window.prior, window.measurements
    ours, its = mhe.solve(*given, window.guess), ipopt.solve(*given, window.guess)
    referee = osqp.solve_window(*given, ours.trajectory)
    distance = carried = _distance(key, ours, its)
    if distance > LIMIT:
        carried = _distance(key, ours, osqp.solve(*given, its.trajectory))
    value, unit = _rows(window, ours)
    is_active = value > -ACTIVE
    is_weak = is_active & (referee.multipliers * unit < WEAK)
    return BoundedRow(
        key,
        ours.status,
        its.status,
        referee.solution.status,
        distance,
        _distance(key, ours, referee.solution),
        carried,
        (ours.cost - its.cost) / max(1.0, abs(its.cost)),
        float(value.max()),
        int(is_active.sum()),
        int(is_weak.sum()),
        ours.iterations,
        its.iterations,
    )


def listed(rows: Sequence[BoundedRow]) -> str:
    """Return one row a line."""
    return "\n".join(map(str, rows))


def _distance(key: BoundedKey, one: WindowSolution, other: WindowSolution) -> float:
    """Largest difference of any state of the window."""
    difference, std = bounded_case(key.case).bounded.difference, one.newest.std
    apart = [
        np.abs(difference(a, b).full().ravel() / std).max()
        for a, b in zip(one.trajectory.states, other.trajectory.states, strict=True)
    ]
    return float(max(apart))


def _rows(window: BoundedWindow, found: WindowSolution) -> tuple[Array, Array]:
    """Return values of all rows over their standard deviations, -inf where not demanded; units."""
    model = bounded_case(window.key.case).bounded
    constrain, P = constrain_function(model), found.newest.covariance
    values, units = [], []
    for x, measurement in zip(found.trajectory.states, window.measurements, strict=True):
        g, C = (part.full() for part in constrain(x))
        units.append(np.sqrt(np.einsum("ij,ik,kj->j", C, P, C)))
        values.append(np.where(demanded(model, measurement.y), g.ravel() / units[-1], -np.inf))
    return np.array(values), np.array(units)
