"""Clock and frame by least squares: what the correlation found, refined.

    min Σ w |e(offset, drift, W, s, M, l)|²,   w of Huber's loss, in units of the errors' own spread

An error of an estimate lasts, so its neighbours say the same again: standard deviations are of the
gradients of whole stretches (a sandwich of H⁻¹), not of single instants.

References
----------
Huber (1981), Robust Statistics; Liang, Zeger (1986), Biometrika 73(1), of the sandwich.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from models.arrays import Array
from pen_mhe.truth.frame import Frame
from pen_mhe.truth.residuals import Clocks, Compared
from pen_mhe.truth.starts import LEVER_STD_M

HUBER = 1.5
ROUNDS, STEPS = 6, 4
"""Weights are taken so often, with so many steps in between …"""
SETTLED = 1e-6
"""… until nothing moves by more than this part of what it may."""
STRETCHES = 40
FLOORS = (1e-7, 1e-8, 1e-6)
"""Least spread of each kind of errors, rad, m, rad/s: those of a copy are none."""


@dataclass(frozen=True)
class Unknowns:
    """What is fitted.

    Parameters
    ----------
    clock, drift : of `Clocks`
    turns : 0, 1 about the vertical, or 3
    shifts : 0, 2 or 3
    mount : 0 or 3, the marker's turn on the pen
    lever : 0 or 3, the way from the marker to the tip
    """

    clock: bool = False
    drift: bool = False
    turns: int = 0
    shifts: int = 0
    mount: int = 0
    lever: int = 0

    @property
    def count(self) -> int:
        """How many numbers these are."""
        frame = self.turns + self.shifts + self.mount + self.lever
        return int(self.clock) + int(self.drift) + frame


@dataclass(frozen=True, eq=False)
class Fitted:
    """Clock and frame; standard deviations of the offset, s, the drift and the heading, rad."""

    clocks: Clocks
    frame: Frame
    unknowns: Unknowns
    offset_std_s: float = 0.0
    drift_std: float = 0.0
    heading_std_rad: float = 0.0


def fitted(compared: Compared, clocks: Clocks, frame: Frame, unknowns: Unknowns) -> Fitted:
    """Refine clock and frame from a start near the best."""
    if not unknowns.count:
        return Fitted(clocks, frame, unknowns)
    problem = _Problem(compared, clocks, frame, unknowns)
    x = np.zeros(unknowns.count)
    for _ in range(ROUNDS):
        problem.weigh(x)
        found = least_squares(problem.residuals, x, x_scale=problem.scale, max_nfev=STEPS)
        moved, x = np.abs(found.x - x), found.x
        if (moved < SETTLED * problem.scale).all():
            break
    covariance = problem.covariance(x, np.asarray(found.jac))
    std = dict(zip(problem.names, np.sqrt(np.maximum(np.diag(covariance), 0)), strict=True))
    best_clocks, best_frame = problem.at(x)
    heading = "turn 2" if unknowns.turns == 3 else "turn 0"
    return Fitted(
        best_clocks,
        best_frame,
        unknowns,
        std.get("clock", 0.0),
        std.get("drift", 0.0),
        std.get(heading, 0.0),
    )


class _Problem:
    def __init__(
        self, compared: Compared, clocks: Clocks, frame: Frame, unknowns: Unknowns
    ) -> None:
        self._compared, self._clocks, self._frame = compared, clocks, frame
        self._unknowns = unknowns
        self._known = [np.isfinite(part) for part in compared.errors(clocks, frame)]
        self._weights: list[Array] = [np.ones(len(part)) for part in self._known]
        self._units = list(FLOORS)
        u = unknowns
        sizes = {
            "clock": (int(u.clock), 1e-2),
            "drift": (int(u.drift), 1e-4),
            "turn": (u.turns, 1e-1),
            "shift": (u.shifts, 1e-2),
            "mount": (u.mount, 1e-1),
            "lever": (u.lever, 1e-2),
        }
        names = [(name, k, scale) for name, (n, scale) in sizes.items() for k in range(n)]
        self.names = [name if name in ("clock", "drift") else f"{name} {k}" for name, k, _ in names]
        self.scale = np.array([scale for *_, scale in names])

    def at(self, x: Array) -> tuple[Clocks, Frame]:
        """Return clock and frame of a vector of the unknowns."""
        u, parts = self._unknowns, list(x)

        def take(n: int) -> Array:
            taken = np.array([parts.pop(0) for _ in range(n)])
            return np.append(taken, np.zeros(3 - n)) if n < 3 else taken

        offset, drift = take(int(u.clock))[0], take(int(u.drift))[0]
        turn = take(u.turns)
        if u.turns == 1:
            turn = turn[::-1]
        clocks = Clocks(
            self._clocks.offset_s + offset, self._clocks.drift + drift, self._clocks.middle_s
        )
        return clocks, self._frame.moved(turn, take(u.shifts), take(u.mount), take(u.lever))

    def _parts(self, x: Array) -> list[Array]:
        errors = self._compared.errors(*self.at(x))
        return [
            np.where(known & np.isfinite(part), part, 0.0)
            for part, known in zip(errors, self._known, strict=True)
        ]

    def weigh(self, x: Array) -> None:
        """Take units and weights of the errors as they are now."""
        for k, part in enumerate(self._parts(x)):
            known = self._known[k].all(axis=1)
            if not part.size or not known.any():
                continue
            size = np.linalg.norm(part, axis=1) / np.sqrt(part.shape[1])
            unit = max(float(np.median(size[known])) / 0.6745, FLOORS[k])
            self._units[k] = unit
            self._weights[k] = np.minimum(1.0, HUBER * unit / np.maximum(size, 1e-300))

    def residuals(self, x: Array) -> Array:
        """Return weighted errors, instant by instant, and what keeps the lever short."""
        rows = [
            part * (np.sqrt(weight) / unit)[:, None]
            for part, weight, unit in zip(self._parts(x), self._weights, self._units, strict=True)
        ]
        ridge = []
        if self._unknowns.lever:
            ridge = list(self.at(x)[1].lever / LEVER_STD_M)
        return np.append(np.column_stack(rows).ravel(), ridge)

    def covariance(self, x: Array, jacobian: Array) -> Array:
        """Return the covariance of the unknowns, of the gradients of whole stretches."""
        r = self.residuals(x)
        width = sum(part.shape[1] for part in self._known)
        instants = len(self._known[0])
        here = np.flatnonzero(np.column_stack(self._known).any(axis=1))
        rows = np.arange(instants * width).reshape(instants, width)
        gradients = np.array(
            [
                jacobian[rows[part].ravel()].T @ r[rows[part].ravel()]
                for part in np.array_split(here, STRETCHES)
            ]
        )
        H = np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-12, hermitian=True)
        more = STRETCHES / max(STRETCHES - self._unknowns.count, 1)
        return np.asarray(more * H @ (gradients.T @ gradients) @ H)
