"""Settings of acados: what was tried, and what of it a problem is raced with."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class AcadosSettings:
    """One way to solve a window's quadratic program.

    Parameters
    ----------
    cost : ``NONLINEAR_LS``: acados multiplies JᵀJ out, densely; ``EXTERNAL``: generated C does,
        and uses where J is zero
    hpipm_mode : of its interior-point solver
    block : stages that partial condensing makes one of; 1 condenses nothing
    warm_start : of the interior point: 0 from nothing, 1 from zero steps
    levenberg : added to the Hessian's diagonal; above 0 the step is another
    """

    cost: str = "NONLINEAR_LS"
    hpipm_mode: str = "SPEED"
    block: int = 1
    warm_start: int = 0
    levenberg: float = 0.0

    def __str__(self) -> str:
        """Return the settings as a table of results names them."""
        return f"{self.cost}, {self.hpipm_mode}, block {self.block}, warm start {self.warm_start}"
