"""Settings of the moving-horizon estimator."""

from __future__ import annotations

from dataclasses import dataclass

from mhe.arrival_cost import ARRIVAL_COSTS
from models.errors import InputError

HESSIANS = ("gauss-newton", "exact")


@dataclass(frozen=True)
class MheConfig:
    """Settings of the moving-horizon estimator.

    Parameters
    ----------
    horizon : N, intervals between stages; more looks further back and costs more
    arrival_cost : one of `mhe.arrival_cost.ARRIVAL_COSTS`
    tolerance : IPOPT's convergence tolerance, in standard deviations; smaller iterates
        longer
    hessian : ``gauss-newton`` or ``exact``. The exact Hessian of a window is often
        indefinite far from the optimum, and IPOPT then may leave for another one
        (on the D-POINT recording it did, into an upright pen); Gauss-Newton always
        descends and ends in the same optimum where both converge
    max_iterations : per step; the best point is returned when it is reached
    max_time_s : wall time per step, s; None has no limit
    """

    horizon: int = 20
    arrival_cost: str = "filtered"
    tolerance: float = 1e-8
    hessian: str = "gauss-newton"
    max_iterations: int = 300
    max_time_s: float | None = None

    def __post_init__(self) -> None:
        if self.horizon < 1:
            raise InputError(f"horizon is {self.horizon}, expected at least 1 interval")
        if self.arrival_cost not in ARRIVAL_COSTS:
            raise InputError(
                f"arrival cost {self.arrival_cost} is unknown, "
                f"expected one of {', '.join(ARRIVAL_COSTS)}"
            )
        if not self.tolerance > 0:
            raise InputError(f"tolerance is {self.tolerance}, expected a positive number")
        if self.hessian not in HESSIANS:
            raise InputError(
                f"hessian {self.hessian} is unknown, expected one of {', '.join(HESSIANS)}"
            )
        if self.max_iterations < 0:
            raise InputError(f"max_iterations is {self.max_iterations}, expected at least 0")
        if self.max_time_s is not None and not self.max_time_s > 0:
            raise InputError(f"max_time_s is {self.max_time_s}, expected a positive time")
