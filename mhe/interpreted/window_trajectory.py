"""A window's trajectory in Python: roll it out, and what it costs; mhe/compiled/trajectory.c."""

from __future__ import annotations

import numpy as np

from estimation.function_call import FunctionCall
from estimation.kalman_stage import KalmanStage
from mhe import constraint_rows
from mhe.config import WindowConfig
from mhe.stage_functions import carry_function, pass_functions, window_functions
from mhe.window_memory import Scales, View
from models.arrays import Array
from models.state_space import StateSpaceModel


class WindowTrajectory:
    """Cost and roll-out on a window's views."""

    def __init__(self, model: StateSpaceModel, config: WindowConfig) -> None:
        self.stage = KalmanStage(model)
        functions = [*window_functions(model), *pass_functions(model, *self.stage.functions)]
        if (carry := carry_function(model)) is not None:
            functions.append(carry)
        self.call = {function.name(): FunctionCall(function) for function in functions}
        self.n_c = constraint_rows.count(model)
        self._thresholds = config.thresholds([sensor.name for sensor in model.sensors])
        self._noise_threshold, self._has_losses = config.noise_threshold, config.has_losses

    def measure(self, window: View, x: Array, w: Array) -> tuple[float, Scales]:
        """Return the cost of readings and noises, and the scales of their losses."""
        cost, rows, noises = 0.0, np.zeros(window.present.shape), np.ones(w.shape)
        for k in range(len(x)):
            rows[k], part = self.weigh(window, k, x[k])
            cost += part
        for k in range(len(w)):
            noises[k], noise_cost = self.call["shake"](w[k], self._noise_threshold)
            cost += float(noise_cost[0])
        return cost, Scales(rows, noises)

    def weigh(self, window: View, k: int, x: Array) -> tuple[Array, float]:
        """Return the scales (n_r,) of a stage's rows at x, and their cost."""
        seen = window.y[k], window.present[k], self._thresholds
        rows, cost = self.call["measure"](x, *seen)
        return rows, float(cost[0])

    def excess(self, window: View, x: Array) -> Array:
        """Return by how much states (n, n_x) exceed each row, (n, n_c), 0 where they do not."""
        if self.n_c == 0:
            return np.zeros(window.demanded.shape)
        g = np.array([self.call["constrain"](state)[0] for state in x])
        return np.where(window.demanded > 0, np.maximum(g, 0), 0.0)

    def largest_excess(self, window: View, row_std: Array) -> float:
        """Return what the trajectory exceeds a row by at most, in standard deviations."""
        excess = self.excess(window, window.x)
        exceeded = excess > 0
        return float((excess[exceeded] / row_std[exceeded]).max(initial=0.0))

    def move(self, window: View, k: int, x: Array, w: Array) -> Array:
        """Return f(x, w) (n_x,) of the step behind stage k."""
        dt = window.times[k + 1] - window.times[k]
        inputs = self.stage.model.step_inputs(window.y[k], window.y[k + 1])
        return self.call["move"](x, w, dt, *inputs)[0]

    def roll_out(self, window: View, d: Array, w: Array) -> Array:
        """Return the states (n, n_x) that start at x̄ ⊞ d and are driven by w."""
        return self.states_from(window, self.stage.retract(window.prior.mean, d), w)

    def states_from(self, window: View, x_0: Array, w: Array) -> Array:
        """Return the states (n, n_x) that start at x_0 and are driven by w."""
        x = [x_0]
        for k in range(len(window.times) - 1):
            x.append(self.move(window, k, x[-1], w[k]))
        return np.array(x)
