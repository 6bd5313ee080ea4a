"""Errors of an estimate against a truth from elsewhere, and whether its covariance covers them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from estimation.consistency import Consistency, consistency_of
from estimation.history import EstimateHistory
from estimation.mahalanobis import squared_distances
from estimation.outputs import output_jacobian, outputs_of
from estimation.truth import Truth
from models.arrays import Array
from models.state_space import StateSpaceModel
from models.units import split_unit
from pen_mhe.errors import ERROR_COLUMNS
from pen_mhe.truth.align import Alignment, NotAligned, aligned
from pen_mhe.truth.frame_names import SAME
from pen_mhe.truth.motion import track_of_estimate
from pen_mhe.truth.words import alignment_sentence
from recordings.truths.track import TruthTrack


@dataclass(frozen=True)
class ErrorFigures:
    """Of one quantity, in the unit of its name; `claimed` is the RMS of its standard deviation."""

    rms: float
    median: float
    largest: float
    claimed: float


@dataclass(frozen=True, eq=False)
class JudgedByTruth:
    """An estimate beside a truth from elsewhere.

    Parameters
    ----------
    name : of the truth
    truth : at the instants of the output, in the estimate's frame; None where it cannot be laid
    errors : (n, k) estimate minus truth of the truth's names, NaN where there is none
    figures : quantity, like ``elevation_deg`` → its errors
    nees : of all quantities together, where the run kept covariances
    said : sentences: how it was read and laid on the estimate, what it covers, what errors are
    """

    name: str
    truth: Truth | None
    errors: Array
    figures: Mapping[str, ErrorFigures]
    nees: Consistency | None
    said: tuple[str, ...]

    def columns(self) -> pd.DataFrame:
        """Return ``<name>_true`` and ``<name>_error`` of each quantity, a row for each estimate."""
        if self.truth is None:
            return pd.DataFrame()
        found = {}
        for k, name in enumerate(self.truth.names):
            found[f"{name}_true"] = self.truth.values[:, k]
            found[f"{name}_error"] = self.errors[:, k]
        return pd.DataFrame(found)


def judged_by(
    track: TruthTrack,
    model: StateSpaceModel,
    output: EstimateHistory,
    *,
    offset_s: float | None = None,
    frame: str | None = None,
) -> JudgedByTruth:
    """Lay a truth on the rows of an output and judge them.

    Parameters
    ----------
    offset_s, frame : see `pen_mhe.truth.align.aligned`

    Raises
    ------
    InputError
        If these make no sense, or the output is no pen's.
    """
    estimate = track_of_estimate(output)
    found = aligned(track, estimate, offset_s=offset_s, frame=frame)
    where = f"truth {track.name}"
    if isinstance(found, NotAligned):
        why = f"{where}: {found.why}; no errors against it"
        return JudgedByTruth(track.name, None, np.zeros((0, 0)), {}, None, (*track.said, why))
    truth, errors = _errors(found, estimate, output)
    figures = figures_of(truth.names, errors, output)
    consistency = _nees(model, output, truth.names, errors)
    said = [*track.said, f"{where}: {alignment_sentence(found)}", _coverage(where, truth)]
    said.append(f"error against it (RMS, median, largest): {_shown(figures)}")
    said += _nees_sentences(output, truth.names, errors, consistency)
    if offset_s is not None and frame == SAME:
        said += _if_aligned(track, estimate, output)
    return JudgedByTruth(track.name, truth, errors, figures, consistency, tuple(said))


def _errors(found: Alignment, estimate: TruthTrack, output: EstimateHistory) -> tuple[Truth, Array]:
    truth = found.truth(estimate, output.time_s)
    every = output.errors(truth)
    return truth, every[:, [output.names.index(name) for name in truth.names]]


def figures_of(
    names: Sequence[str], errors: Array, output: EstimateHistory
) -> dict[str, ErrorFigures]:
    """Return by column of `ERROR_COLUMNS`, of those states that are among the names, its errors.

    ``tip_mm`` of x and y alone is ``tip_xy_mm``.
    """
    found = {}
    for column, (states, factor) in ERROR_COLUMNS.items():
        known = [name for name in states if name in names]
        sizes = np.linalg.norm(errors[:, [names.index(name) for name in known]], axis=1) * factor
        there = np.isfinite(sizes)
        if not known or not there.any():
            continue
        sizes = sizes[there]
        variance = sum(output.std_of(name)[there] ** 2 for name in known)
        if len(known) < len(states):
            axes = "".join(split_unit(name)[0].rpartition("_")[2] for name in known)
            column = column.replace("_", f"_{axes}_", 1)
        rms = float(np.sqrt((sizes**2).mean()))
        claimed = float(np.sqrt(np.mean(variance))) * factor
        found[column] = ErrorFigures(rms, float(np.median(sizes)), float(sizes.max()), claimed)
    return found


def _shown(figures: Mapping[str, ErrorFigures]) -> str:
    parts = [
        f"{column} {one.rms:.3g}, {one.median:.3g}, {one.largest:.3g} (claimed {one.claimed:.3g})"
        for column, one in figures.items()
    ]
    return "; ".join(parts)


def _coverage(where: str, truth: Truth) -> str:
    known = np.asarray(np.isfinite(truth.values).any(axis=1))
    times = truth.time_s[known]
    if known.all():
        return f"{where}: it covers all {len(known)} rows"
    return (
        f"{where}: it covers {known.mean():.1%} of the rows, from {times[0]:.6g} to "
        f"{times[-1]:.6g} s; the others have no error"
    )


def _nees(
    model: StateSpaceModel, output: EstimateHistory, names: Sequence[str], errors: Array
) -> Consistency | None:
    if output.covariances is None:
        return None
    known = np.isfinite(errors)
    if not known.any():
        return None
    rows = [outputs_of(model).names.index(name) for name in names]
    jacobian = output_jacobian(model)
    n, n_x = output.mean.shape
    J = jacobian(output.mean.T).full().reshape(-1, n, n_x).transpose(1, 0, 2)[:, rows]
    P = J @ output.covariances.state @ J.transpose(0, 2, 1)
    squared = squared_distances(np.nan_to_num(errors), P, known)
    return consistency_of(squared, known.sum(axis=1))


def _nees_sentences(
    output: EstimateHistory,
    names: Sequence[str],
    errors: Array,
    consistency: Consistency | None,
) -> list[str]:
    each = []
    for k, name in enumerate(names):
        squared = (errors[:, k] / output.std_of(name)) ** 2
        squared = squared[np.isfinite(squared)]
        if len(squared):
            each.append(f"{name} {squared.mean():.3g}")
    said = []
    if each:
        said.append(f"squared error over claimed variance, 1 is expected: {', '.join(each)}")
    if consistency is not None:
        said.append(
            f"NEES of them together: mean {consistency.mean:.4g}, expected "
            f"{consistency.expected:.4g} (95 % of consistent runs: {consistency.lower:.4g} to "
            f"{consistency.upper:.4g}, if instants were independent)"
        )
    return said


def _if_aligned(track: TruthTrack, estimate: TruthTrack, output: EstimateHistory) -> list[str]:
    """Say what errors were if clock and frame, which are said to be the same, were fitted."""
    found = aligned(track, estimate)
    if isinstance(found, NotAligned):
        return [f"if it were aligned all the same: {found.why}"]
    truth, errors = _errors(found, estimate, output)
    return [
        f"if it were aligned all the same: {alignment_sentence(found)}; then "
        f"{_shown(figures_of(truth.names, errors, output))}"
    ]
