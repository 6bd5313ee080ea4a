"""A window slides on by an instant: the oldest stage becomes the prior, a new one is appended."""

from __future__ import annotations

import numpy as np

from estimation.kalman_stage import rows_present, without_gaps
from estimation.layout import Layout
from estimation.recording import Measurement
from mhe import constraint_rows
from mhe.arrival_cost import ARRIVAL_COSTS, Slide
from mhe.config import RealTimeConfig
from mhe.domain import inside
from mhe.interpreted.window_pass import WindowPass
from mhe.trajectory import Trajectory
from mhe.window_memory import BETWEEN_STAGES, PER_STAGE, View, put
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


class WindowSlider:
    """Slides windows on.

    Parameters
    ----------
    memory : see `mhe.window_memory.window_memory`
    passes : over the window, with the functions of its stages
    """

    def __init__(
        self, model: StateSpaceModel, config: RealTimeConfig, memory: Layout, passes: WindowPass
    ) -> None:
        self._model, self._config, self._memory, self._pass = model, config, memory, passes

    def _choose_points(self, window: View, k: int) -> None:
        """Choose what the next pass is linearised at: the first k stages keep their points."""
        step = max(k - 1, 0)  # the noise that leads to stage k goes with it
        window.x_lin[k:], window.w_lin[step:] = window.x[k:], window.w[step:]
        window.moved[k:] = np.inf  # until a pass says
        if k == 0:
            [deviation] = self._pass.call["difference"](window.x_lin[0], window.prior.mean)
            window.prior_deviation[:] = -deviation

    def slide(self, given: Array, time_s: float, y: Array, stays: int) -> Array:
        """Append an instant, without the oldest stage where the window is full."""
        layout, memory, old = self._memory, given.copy(), View.of(self._memory, given)
        before, capacity = len(old.times), layout.shapes["times"][0]
        dropped = int(before == capacity)
        kept = before - dropped
        layout.view(memory, "count")[...] = kept + 1
        new = View.of(layout, memory)
        for block in PER_STAGE:
            getattr(new, block)[:kept] = getattr(old, block)[dropped:]
        for block in BETWEEN_STAGES:
            getattr(new, block)[: max(kept - 1, 0)] = getattr(old, block)[dropped:]
        if dropped:
            prior, new.prior_deviation[:] = self._arrive(old, stays > 0)
            put(layout, memory, "prior", prior)
        new.demanded[-1], new.active[-1] = constraint_rows.demanded(self._model, y), 0
        new.times[-1], new.y[-1] = time_s, without_gaps(y)
        new.present[-1] = rows_present(self._model, y)
        layout.view(memory, "inputs")[:] = y[self._model.n_y :]
        new.x[-1] = old.prior.mean
        if before:
            new.w[-1] = 0
            new.x[-1] = self._pass.move(new, kept - 1, old.x[-1], new.w[-1])
        new.x[-1] = inside(self._model, new.x[-1])
        new.predicted[-1] = new.x[-1]
        self._choose_points(new, stays)
        new.stayed[...] = stays
        return memory

    def _arrive(self, window: View, kept: bool) -> tuple[GaussianState, Array]:
        """Return the prior of the first stage that stays, and its deviation from its point.

        Where factors are kept the dropped stage is eliminated as its own were made.
        """
        if kept:
            stage, dt = self._pass.stage, float(window.times[1] - window.times[0])
            at = window.x_lin[0], window.prior_deviation
            rows, _ = self._pass.weigh(window, 0, window.x_lin[0])
            updated = stage.update(window.prior, window.y[0], rows, *at)
            point = window.x_lin[0], window.w_lin[0], None, updated.deviation
            inputs = self._model.step_inputs(*window.y[:2])
            predicted = stage.predict(updated.state, dt, *point, inputs=inputs)
            [defect] = self._pass.call["difference"](predicted.reached, window.x_lin[1])
            return predicted.state, predicted.deviation + defect
        rows, _ = self._pass.weigh(window, 0, window.x[0])
        noises, _ = self._pass.call["shake"](window.w[0], self._config.noise_threshold)
        slide = Slide(
            window.prior,
            Measurement(float(window.times[0]), window.y[0]),
            Measurement(float(window.times[1]), window.y[1]),
            Trajectory(window.x, window.w),
            window.predicted[1],
            rows,
            noises,
        )
        prior = ARRIVAL_COSTS[self._config.arrival_cost](self._pass.stage, slide)
        [deviation] = self._pass.call["difference"](prior.mean, window.x_lin[1])
        return prior, deviation
