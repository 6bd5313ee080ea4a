"""Figures of a run that comes in parts: what `pen_mhe.run_summary.RunSummary` holds."""

from __future__ import annotations

from collections import Counter
from typing import Any

from estimation.consistency import ConsistencyInParts, nees, nis
from estimation.estimate import EstimateHistory
from estimation.recording import Truth
from estimation.status import Status
from estimation.tallies import Mean, Quantiles
from estimation.watch.words import WatchInParts
from models.state_space import StateSpaceModel
from pen_mhe.errors import (
    ERROR_COLUMNS,
    known_columns,
    rms_of,
    seen_only,
    squared_errors,
    state_errors,
)
from pen_mhe.run_summary import RunSummary, bias_and_tilt, claimed_tilt
from pen_mhe.streaming.seen import SeenInParts
from pen_mhe.unseen import UnseenInParts
from recordings.left_out import LeftOutInParts
from recordings.parts import RecordingPart


class Judging:
    """Judges a run by its steps, by the truth and by left-out frames, part by part.

    Parameters
    ----------
    instants : how many there will be
    true_names : of the states that the recording knows
    """

    def __init__(
        self, model: StateSpaceModel, *, instants: int, true_names: tuple[str, ...]
    ) -> None:
        self._model, self._true_names = model, true_names
        self._statuses: Counter[Status] = Counter()
        self._step_times = Quantiles()
        self._nis, self._watch = ConsistencyInParts(), WatchInParts()
        self._bias_and_tilt: tuple[str, ...] = ()
        self._tilt_std_rad: float | None = None
        self.knows_states = set(model.state_names) <= set(true_names)
        cameras = [sensor for sensor in model.sensors if sensor.sees_pose]
        self._left_out = LeftOutInParts(model, cameras[0]) if cameras else None
        self._nees = ConsistencyInParts()
        self._squared: dict[str, Mean] = {}
        self._unseen = UnseenInParts(model)
        self._seen = SeenInParts(model, instants) if self.knows_states else None

    def read(self, part: RecordingPart) -> None:
        """Look at the next part of the recording."""
        if self._left_out is not None:
            self._left_out.read(part.recorded, part.used)
        if self._seen is not None and part.used is not None and part.raw.truth is not None:
            self._seen.take(part.used, part.raw.truth)

    def step(self, history: EstimateHistory) -> None:
        """Look at what the next steps say, at least one."""
        self._statuses.update(history.status)
        self._step_times.add(history.step_time_s)
        self._watch.add(history)
        self._nis.add(*nis(history, self._model.measured_rows))
        self._bias_and_tilt = tuple(bias_and_tilt(self._model, history))
        self._tilt_std_rad = claimed_tilt(history)

    def tell(self, told: EstimateHistory, truth: Truth | None) -> None:
        """Look at what the next steps tell of instants; see `pen_mhe.streaming.telling`."""
        if not len(told):
            return
        self._unseen.add(told)
        if self._left_out is not None:
            self._left_out.take(told)
        if truth is None:
            return
        errors = state_errors(self._model, told, truth)
        columns = known_columns(told.names, truth.names)
        for column, squared in squared_errors(told.names, errors, columns).items():
            self._squared.setdefault(column, Mean()).add(squared)
        if self.knows_states:
            states = truth.states(self._model.state_names, told.time_s)
            self._nees.add(nees(self._model, told, states), self._model.n_x)

    def summary(self, **facts: Any) -> RunSummary:
        """Return what the parts together say, with what else `RunSummary` holds."""
        rms: dict[str, float] = {
            column: rms_of(mean.value, ERROR_COLUMNS[column][1])
            for column, mean in self._squared.items()
            if mean.count
        }
        verdict = None if self._seen is None else self._seen.result()
        return RunSummary(
            steps=sum(self._statuses.values()),
            statuses=self._statuses,
            median_step_s=self._step_times.median,
            p99_step_s=self._step_times.at(0.99),
            left_out=None if self._left_out is None else self._left_out.result(),
            true_rms=rms if verdict is None else seen_only(self._model, rms, verdict),
            nis=self._nis.result(),
            nees=self._nees.result(),
            bias_and_tilt=self._bias_and_tilt,
            tilt_std_rad=self._tilt_std_rad,
            watch=tuple(self._watch.sentences()),
            unseen=self._unseen.result(),
            **facts,
        )
