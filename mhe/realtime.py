"""The real-time moving-horizon estimators: Gauss-Newton passes of the Kalman stage.

A Gauss-Newton step of the window problem (`mhe.reference.window`) is a pass of the EKF's own stage
over the window, linearised at the current trajectory, and a smoother's pass back
(`mhe.stage_functions`). Both run in compiled C, mhe/compiled/*.c; without a compiler the same
stages run in CasADi's virtual machine (`mhe.interpreted.loop`).

``mhe-rti`` makes one pass per sample and takes its full step. ``mhe`` makes passes until a
step is shorter than the tolerance, in standard deviations; a backtracking line search
keeps the window's cost from ever rising, so it cannot diverge.

References
----------
Bell (1994), The iterated Kalman smoother as a Gauss-Newton method, SIAM J. Optim. 4(3).
Diehl, Bock, Schlöder (2005), A real-time iteration scheme for nonlinear optimization in
optimal feedback control, SIAM J. Control Optim. 43(5).
Särkkä, Svensson (2020), Levenberg-Marquardt and line-search extended Kalman smoothers,
ICASSP.
"""

from __future__ import annotations

from collections.abc import Callable

from estimation.estimate import Estimate, EstimateHistory
from estimation.exclusive import Exclusive, in_turn
from estimation.recording import Measurement
from estimation.settings import checked_config
from mhe.config import Clock, MheConfig, MheRtiConfig
from mhe.trajectory import Trajectory, WindowSolution
from mhe.window_loop import WindowLoop
from mhe.window_memory import WindowState
from models.arrays import Array
from models.gaussian import GaussianState
from models.given_prior import Prior
from models.state_space import StateSpaceModel


class MheRti(Exclusive):
    """Real-time iteration: one Gauss-Newton pass per sample.

    Parameters
    ----------
    clock : of `MheRtiConfig.deadline_s`; the machine's own by default
    """

    name = "mhe-rti"

    def __init__(
        self,
        model: StateSpaceModel,
        config: MheRtiConfig | None = None,
        *,
        clock: Clock | None = None,
    ) -> None:
        self.model, self.config = model, checked_config(self.name, config, MheRtiConfig)
        super().__init__(model, self.config, clock=clock)
        self.lags = self.config.lags
        self._loop = WindowLoop(self.name, model, self.config, clock)
        self.engine, self.told = self._loop.engine, self._loop.told  # what makes steps, and of them

    def init(self, prior: Prior | None = None) -> WindowState:
        """Return the state before the first measurement; see `ekf_baseline.ekf.Ekf.init`."""
        return self._loop.start(prior)

    @in_turn
    def step(self, state: WindowState, measurement: Measurement) -> tuple[WindowState, Estimate]:
        """Slide the window onto the measurement and make one pass."""
        return self._loop.step(state, measurement)

    @in_turn
    def batch(
        self,
        state: WindowState,
        time_s: Array,
        y: Array,
        *,
        covariances: bool = False,
        on_progress: Callable[[int], None] | None = None,
    ) -> tuple[WindowState, EstimateHistory]:
        """Take n measurements in compiled calls; see `WindowLoop.batch`."""
        return self._loop.batch(state, time_s, y, covariances=covariances, on_progress=on_progress)


class Mhe(Exclusive):
    """Passes to convergence, with a line search.

    Parameters
    ----------
    clock : of `MheConfig.deadline_s`; the machine's own by default
    """

    name = "mhe"

    def __init__(
        self,
        model: StateSpaceModel,
        config: MheConfig | None = None,
        *,
        clock: Clock | None = None,
    ) -> None:
        self.model, self.config = model, checked_config(self.name, config, MheConfig)
        super().__init__(model, self.config, clock=clock)
        self.lags = self.config.lags
        self._loop = WindowLoop(self.name, model, self.config, clock)
        self.engine, self.told = self._loop.engine, self._loop.told  # what makes steps, and of them

    def init(self, prior: Prior | None = None) -> WindowState:
        """Return the state before the first measurement; see `ekf_baseline.ekf.Ekf.init`."""
        return self._loop.start(prior)

    @in_turn
    def step(self, state: WindowState, measurement: Measurement) -> tuple[WindowState, Estimate]:
        """Slide the window onto the measurement and solve it."""
        return self._loop.step(state, measurement)

    @in_turn
    def batch(
        self,
        state: WindowState,
        time_s: Array,
        y: Array,
        *,
        covariances: bool = False,
        on_progress: Callable[[int], None] | None = None,
    ) -> tuple[WindowState, EstimateHistory]:
        """Take n measurements in compiled calls; see `WindowLoop.batch`."""
        return self._loop.batch(state, time_s, y, covariances=covariances, on_progress=on_progress)

    @in_turn
    def solve(
        self, prior: GaussianState, measurements: tuple[Measurement, ...], guess: Trajectory
    ) -> WindowSolution:
        """Solve one window of at most N + 1 stages from a given start; see `WindowLoop.solve`."""
        return self._loop.solve(prior, measurements, guess)
