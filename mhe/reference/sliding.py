"""A window goes on to another measurement, for the estimator that IPOPT solves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from estimation.kalman_stage import KalmanStage
from estimation.recording import Measurement
from mhe.arrival_cost import ARRIVAL_COSTS, Slide
from mhe.config import MheIpoptConfig
from mhe.domain import inside
from mhe.late import StagePlace, joined, shares
from mhe.reference.state import MheState
from mhe.trajectory import Trajectory
from mhe.weights import Weights
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


class Slider:
    """Slides windows on, and their solutions with them.

    Parameters
    ----------
    stage, weights : of the estimator
    """

    def __init__(
        self, model: StateSpaceModel, config: MheIpoptConfig, stage: KalmanStage, weights: Weights
    ) -> None:
        self._model, self._config, self._stage, self._weights = model, config, stage, weights

    def slide(
        self, state: MheState, place: StagePlace, measurement: Measurement
    ) -> tuple[MheState, Trajectory]:
        """Return the window with a measurement in it, and the guess of its solution."""
        if state.trajectory is None:
            x = inside(self._model, state.prior.mean)
            guess = Trajectory(x[None, :], np.zeros((0, self._model.n_w)))
            return replace(state, measurements=(measurement,), predictions=(x,)), guess
        if place.joins:
            return self._joined(state, place.at, measurement), state.trajectory
        x, guess = self._guess(state, place, measurement)
        at = place.behind
        measurements = (*state.measurements[:at], measurement, *state.measurements[at:])
        predictions = (*state.predictions[:at], x, *state.predictions[at:])
        window = replace(state, measurements=measurements, predictions=predictions, trajectory=None)
        return self._without_oldest(window, guess) if place.drop else (window, guess)

    def _joined(self, state: MheState, at: int, measurement: Measurement) -> MheState:
        """Return the window where the readings of a measurement join those of a stage."""
        stages = list(state.measurements)
        stages[at] = replace(stages[at], y=joined(stages[at].y, measurement.y))
        return replace(state, measurements=tuple(stages), trajectory=None)

    def _guess(
        self, state: MheState, place: StagePlace, measurement: Measurement
    ) -> tuple[np.ndarray, Trajectory]:
        """Return the state at a measurement, and the last solution with it."""
        assert state.trajectory is not None
        model, at, last = self._model, place.behind, state.trajectory
        states, noises = last.states, last.noises
        if at == 0:  # in front of all others
            before = np.zeros((1, model.n_w))
            return states[0], Trajectory(
                np.vstack([states[:1], states]), np.vstack([before, noises])
            )
        around = [np.zeros(model.n_w)]
        if place.is_late:
            times = [m.time_s for m in state.measurements]
            around = [share * noises[at - 1] for share in shares(times, at, measurement.time_s)]
        here = state.measurements[at - 1]
        inputs = model.step_inputs(here.y, measurement.y)
        dt = measurement.time_s - here.time_s
        reached = np.asarray(model.f(states[at - 1], around[0], dt, *inputs)).ravel()
        x = inside(model, reached)
        return x, Trajectory(
            np.vstack([states[:at], x, states[at:]]),
            np.vstack([noises[: at - 1], *around, noises[at:]]),
        )

    def _without_oldest(self, window: MheState, guess: Trajectory) -> tuple[MheState, Trajectory]:
        """Return a window whose oldest stage has become its prior."""
        carry = ARRIVAL_COSTS[self._config.arrival_cost]
        measurements, predictions = window.measurements, window.predictions
        rows, _ = self._weights.readings(guess.states[0], measurements[0].y)
        noises, _ = self._weights.noises(guess.noises[0])
        ends = measurements[0], measurements[1]
        slide = Slide(window.prior, *ends, guess, predictions[1], rows, noises)
        prior: GaussianState = carry(self._stage, slide)
        shorter = replace(
            window, prior=prior, measurements=measurements[1:], predictions=predictions[1:]
        )
        return shorter, Trajectory(guess.states[1:], guess.noises[1:])
