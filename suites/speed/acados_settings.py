"""Settings of acados: its own, the best of those that were tried, and what was tried.

`python -m tests.suites.speed.acados_grid` tries them again. Condensing gains nothing where there
are as many noises as states: a block of two stages has twice the inputs of one. A warm interior
point is no quicker than a cold one. Tolerances of 1e-4 save a third with bounds and miss the step
by 3e-2 standard deviations; another first barrier (0.1, 1, 10) saves nothing.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class AcadosSettings:
    """One way to solve a window's quadratic program.

    Parameters
    ----------
    cost : ``NONLINEAR_LS``: acados multiplies JᵀJ out, densely; ``EXTERNAL``: generated C does,
        and knows where J is zero
    hpipm_mode : of its interior-point solver: ``SPEED_ABS``, ``SPEED``, ``BALANCE``
    block : stages that partial condensing makes one of; 1 condenses nothing
    warm_start : of the interior point; 0 begins from nothing
    levenberg : added to the Hessian's diagonal; above 0 the step is not Gauss and Newton's
    riccati : 1 for the square-root recursion, 0 for the classical one
    """

    cost: str = "NONLINEAR_LS"
    hpipm_mode: str = "BALANCE"
    block: int = 1
    warm_start: int = 0
    levenberg: float = 0.0
    riccati: int = 1

    def __str__(self) -> str:
        """Return the settings as a table of results names them."""
        return (
            f"{self.cost}, {self.hpipm_mode}, block {self.block}, warm start {self.warm_start}, "
            f"levenberg {self.levenberg:g}, riccati {self.riccati}"
        )


ACADOS = AcadosSettings()
"""acados' own defaults, with the cost of its example of moving-horizon estimation."""
ACADOS_TUNED = AcadosSettings("EXTERNAL", "SPEED_ABS")
"""The quickest of those tried: `pen15` (N = 20, bounded or not, and 100), `pen24` (N = 20)."""

TRIED: tuple[AcadosSettings, ...] = (
    ACADOS,
    AcadosSettings(hpipm_mode="SPEED"),
    AcadosSettings(hpipm_mode="SPEED", block=2),
    AcadosSettings("EXTERNAL", "BALANCE"),
    AcadosSettings("EXTERNAL", "SPEED"),
    ACADOS_TUNED,
    AcadosSettings("EXTERNAL", "SPEED_ABS", warm_start=1),
    AcadosSettings("EXTERNAL", "SPEED_ABS", riccati=0),
    AcadosSettings("EXTERNAL", "SPEED_ABS", block=2, riccati=0),
    AcadosSettings("EXTERNAL", "SPEED_ABS", block=5, riccati=0),
)
"""With ``EXTERNAL``, a block of 2 and the square-root recursion the step of `pen24` is wrong, by
1.6 standard deviations; so blocks are tried with the classical one."""
