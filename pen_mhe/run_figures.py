"""What a run is judged by: errors of a truth, and whether claims and noise levels hold."""

from __future__ import annotations

import numpy as np

from estimation.consistency import Consistency, consistency_of, nees, nis
from estimation.estimate import EstimateHistory
from estimation.recording import Recording
from models.state_space import StateSpaceModel
from pen_mhe.errors import known_columns, root_mean_square, seen_only, state_errors
from pen_mhe.sensor_verdict import judge


def true_rms(
    model: StateSpaceModel, history: EstimateHistory, recording: Recording
) -> dict[str, float | str]:
    """Return RMS errors, not observable where a complete truth shows that no sensor sees them."""
    truth = recording.truth
    if truth is None:
        return {}
    known = known_columns(history.names, truth.names)
    errors = state_errors(model, history, truth)
    rms = root_mean_square(history.names, errors, known)
    if np.isnan(truth.states(model.state_names, recording.time_s)).any():
        return dict(rms)
    return seen_only(model, rms, judge(model, recording))


def nis_of(model: StateSpaceModel, history: EstimateHistory) -> Consistency | None:
    """Return what the innovations say of the noise levels; None without any."""
    squared, rows = nis(history, model.measured_rows)
    return consistency_of(squared, rows) if rows.any() else None


def nees_of(
    model: StateSpaceModel, history: EstimateHistory, recording: Recording
) -> Consistency | None:
    """Return what the errors say of the claims, where the truth of every state is known."""
    truth = recording.truth
    if truth is None or not has_nees(model, recording):
        return None
    squared = nees(model, history, truth.states(model.state_names, history.time_s))
    return None if np.isnan(squared).all() else consistency_of(squared, model.n_x)


def has_nees(model: StateSpaceModel, recording: Recording) -> bool:
    """Whether the truth of every state is known."""
    return recording.truth is not None and set(model.state_names) <= set(recording.truth.names)
