"""A window goes on to another measurement: mhe/compiled/slide.c in Python."""

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
from mhe.late import StagePlace, joined, readings_there, shares
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

    def choose_points(self, window: View, k: int) -> None:
        """Choose what the next pass is linearised at: the first k stages keep their points."""
        step = max(k - 1, 0)  # the noise that leads to stage k goes with it
        window.x_lin[k:], window.w_lin[step:] = window.x[k:], window.w[step:]
        window.moved[k:] = np.inf  # until a pass says
        if k == 0:
            [deviation] = self._pass.call["difference"](window.x_lin[0], window.prior.mean)
            window.prior_deviation[:] = -deviation

    def slide(
        self, given: Array, place: StagePlace, time_s: float, y: Array, stays: int
    ) -> tuple[Array, View]:
        """Return the window with a measurement in it, flat and as its view; slide.c does so in C.

        Parameters
        ----------
        stays : how many of the oldest stages keep their factors
        """
        memory = self._shifted(given, place)
        old, new = View.of(self._memory, given), View.of(self._memory, memory, told=place.at)
        if place.joins:
            self._join(new, y)
        else:
            w = self._put(old, new, place, time_s, y)
            if place.drop:
                prior, new.prior_deviation[:] = self._arrive(old, new, w, stays > 0)
                put(self._memory, memory, "prior", prior)
            if not place.is_late:
                self._memory.view(memory, "inputs")[:] = y[self._model.n_y :]
        new = View.of(self._memory, memory, told=place.at)  # with its new prior
        self.choose_points(new, stays)
        new.stayed[...] = stays
        return memory, new

    def _shifted(self, given: Array, place: StagePlace) -> Array:
        """Return the stages, without the oldest where it goes, with room for one of its own."""
        layout, memory, old = self._memory, given.copy(), View.of(self._memory, given)
        if place.joins:
            return memory
        kept = len(old.times) - place.drop
        layout.view(memory, "count")[...] = kept + 1
        new = View.of(layout, memory)
        for blocks, less in ((PER_STAGE, 0), (BETWEEN_STAGES, 1)):
            for block in blocks:
                to, stages = getattr(new, block), getattr(old, block)[place.drop :]
                before, end = max(place.at - less, 0), kept - less
                to[:before] = stages[:before]
                if end > place.at:
                    to[place.at + 1 : end + 1] = stages[place.at : end]
        return memory

    def _take_readings(self, window: View, k: int, y: Array) -> None:
        window.y[k], window.present[k] = without_gaps(y), rows_present(self._model, y)
        window.demanded[k], window.active[k] = constraint_rows.demanded(self._model, y), 0

    def _join(self, window: View, y: Array) -> None:
        """The readings of a measurement join those of a stage."""
        k, demanded = window.told, window.demanded[window.told].copy()
        there = readings_there(self._model, window.present[k])
        stage = window.y[k].copy()
        stage[: self._model.n_y][~there] = np.nan
        self._take_readings(window, k, joined(stage, y))
        window.demanded[k] = np.maximum(window.demanded[k], demanded)

    def _put(self, old: View, new: View, place: StagePlace, time_s: float, y: Array) -> Array:
        """Fill a stage of its own; return the noise that leads to it, or what led on."""
        k, last = place.at, place.behind - 1
        new.times[k] = time_s
        self._take_readings(new, k, y)
        w = old.w[0] if len(old.w) else np.zeros(self._model.n_w)
        if place.is_late:
            new.apart[...] = 1
        if place.is_late and last < 0:
            new.x[k], new.w[k] = old.x[0], 0
        elif last < 0:
            new.x[k] = old.prior.mean
        else:
            first, second = shares(old.times, last + 1, time_s) if place.is_late else (0.0, 0.0)
            noise = first * old.w[last] if place.is_late else np.zeros(self._model.n_w)
            if place.is_late:
                new.w[k] = second * old.w[last]
            if k > 0:
                new.w[k - 1] = noise
            else:
                w = noise
            inputs = self._model.step_inputs(old.y[last], new.y[k])
            dt = time_s - float(old.times[last])
            new.x[k] = self._pass.call["move"](old.x[last], noise, dt, *inputs)[0]
        new.x[k] = inside(self._model, new.x[k])
        new.predicted[k] = new.x[k]
        return w

    def _arrive(self, window: View, new: View, w: Array, kept: bool) -> tuple[GaussianState, Array]:
        """Return the prior of the first stage of a `new` window, and its deviation from its point.

        Where factors are kept the dropped stage is eliminated as its own were made.

        Parameters
        ----------
        w : (n_w,) the noise that led from the dropped stage to the first
        """
        if kept:
            stage, dt = self._pass.stage, float(new.times[0] - window.times[0])
            at = window.x_lin[0], window.prior_deviation
            rows, _ = self._pass.weigh(window, 0, window.x_lin[0])
            updated = stage.update(window.prior, window.y[0], rows, *at)
            point = window.x_lin[0], window.w_lin[0], None, updated.deviation
            inputs = self._model.step_inputs(window.y[0], new.y[0])
            predicted = stage.predict(updated.state, dt, *point, inputs=inputs)
            [defect] = self._pass.call["difference"](predicted.reached, new.x_lin[0])
            return predicted.state, predicted.deviation + defect
        rows, _ = self._pass.weigh(window, 0, window.x[0])
        noises, _ = self._pass.call["shake"](w, self._config.noise_threshold)
        slide = Slide(
            window.prior,
            Measurement(float(window.times[0]), window.y[0]),
            Measurement(float(new.times[0]), new.y[0]),
            Trajectory(window.x, w[None]),
            new.predicted[0],
            rows,
            noises,
        )
        prior = ARRIVAL_COSTS[self._config.arrival_cost](self._pass.stage, slide)
        [deviation] = self._pass.call["difference"](prior.mean, new.x_lin[0])
        return prior, deviation
