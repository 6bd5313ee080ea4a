"""What a run says of itself, in figures that fit on a page, and in sentences."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from estimation.consistency import Consistency
from estimation.history import EstimateHistory
from estimation.information_bound import OBSERVABLE_FRACTION
from estimation.status import Status
from models.state_space import StateSpaceModel
from pen_mhe.trust import Trust, trust_of
from pen_mhe.unseen import COLUMN, unseen_words
from recordings.finding import Finding, finding_lines
from recordings.thinning import LeftOutError

TILT, STANDARD_GRAVITY_M_S2 = "elevation_rad", 9.80665
ALIKE = 0.5
"""A tilt's deviation over that of a bias' tilt, from which the two are not told apart."""


@dataclass(frozen=True)
class RunSummary:
    """Figures of a run; see `pen_mhe.run_result.EstimateRun` for what is not explained here.

    Parameters
    ----------
    recording, estimator : their names
    samples, steps : rows of the output, and steps that the estimator made
    statuses : how many steps ended in each, in the order in which they came first
    median_step_s, p99_step_s : of the steps' times
    bias_and_tilt : what `bias_and_tilt` says of the last step
    watch : what `estimation.watch.words.watch_sentences` says of the steps
    ink_mm : mean distance from the ink, where there is a scan
    judged : what `pen_mhe.truth.judged.JudgedByTruth` says of a truth from elsewhere
    unseen : quantities that are not observable in most rows, see `pen_mhe.unseen`
    findings : of checks of the recording
    tilt_std_rad : of `claimed_tilt`
    """

    recording: str
    estimator: str
    samples: int
    steps: int
    statuses: Mapping[Status, int]
    median_step_s: float
    p99_step_s: float
    left_out: LeftOutError | None
    true_rms: Mapping[str, float | str]
    nis: Consistency | None
    nees: Consistency | None
    zero_delay: tuple[str, ...]
    delays_s: Mapping[str, float]
    bias_and_tilt: tuple[str, ...]
    watch: tuple[str, ...] = ()
    ink_mm: float | None = None
    is_causal: bool = False
    lag_samples: int = 0
    is_smoothed: bool = False
    rows_without: int = 0
    notes: tuple[str, ...] = ()
    judged: tuple[str, ...] = ()
    unseen: frozenset[str] = frozenset()
    findings: tuple[Finding, ...] = ()
    tilt_std_rad: float | None = None

    @property
    def trust(self) -> Trust:
        """How far to trust the answer."""
        return trust_of(
            self.findings,
            self.statuses,
            self.nis,
            nees=self.nees,
            tilt_std_rad=self.tilt_std_rad,
        )

    @property
    def size(self) -> str:
        """How many samples and steps, in words."""
        return f"{self.samples} samples, {self.steps} steps"

    def sentences(self) -> list[str]:
        """Return what the run says of itself: its file, statuses, times, errors, consistency."""
        solved = sum(count for status, count in self.statuses.items() if status.is_solved)
        share = solved / self.steps if self.steps else np.nan
        said = [*self.notes, *("\n".join(finding_lines(one)) for one in self.findings)]
        said.append(f"solved {share:.2%} of the steps")
        said += [
            f"{count} × {status.label}: {status.sentence}"
            for status, count in self.statuses.items()
            if status.label != "solved"
        ]
        said += self.watch
        median, p99 = 1e3 * self.median_step_s, 1e3 * self.p99_step_s
        said.append(f"step time: median {median:.3g} ms, p99 {p99:.3g} ms")
        said += [*self._delay_sentences(), *self._lag_sentences(), *self._error_sentences()]
        if self.unseen:
            said.append(
                f"not observable: {unseen_words(self.unseen)}; no reading shows more than was "
                f"known before (column {COLUMN})"
            )
        said += [*self.judged, *self.bias_and_tilt]
        if self.ink_mm is not None and np.isfinite(self.ink_mm):
            said.append(f"mean ink distance: {self.ink_mm:.4f} mm")
        return [*said, self.trust.sentence]

    def _delay_sentences(self) -> list[str]:
        if self.is_causal:
            late = ", ".join(f"{name} {1e3 * s:.3g} ms" for name, s in self.delays_s.items())
            what = f"after their capture ({late})" if late else "at their capture, none later"
            return [
                f"causal: an estimate uses what had arrived, and no more; readings arrive {what}"
            ]
        if not self.zero_delay:
            return []
        return [
            f"zero delay: readings of {', '.join(self.zero_delay)} are used at the instant of "
            "their stamp, taken as that of capture; figures do not compare with causal ones"
        ]

    def _lag_sentences(self) -> list[str]:
        said = []
        if self.lag_samples:
            said.append(
                f"lag: each row speaks of the instant {self.lag_samples} samples before the newest "
                f"that it knows; {self.rows_without} samples at the end, not followed by "
                "so many, have no row"
            )
        elif self.rows_without:
            said.append(
                f"{self.rows_without} samples, older than another sensor's when they arrived, have "
                "no row"
            )
        if self.is_smoothed:
            said.append("smoothed: each row knows the whole recording, what came later included")
        return said

    def _error_sentences(self) -> list[str]:
        said = []
        if self.left_out is not None:
            errors = (_in_readable_unit(unit, rms) for unit, rms in self.left_out.rms.items())
            frames = self.left_out.frames
            said.append(f"RMS error against {frames} frames left out: {', '.join(errors)}")
        if self.true_rms:
            shown = (
                f"{column} {value:.4g}" if isinstance(value, float) else f"{column} {value}"
                for column, value in self.true_rms.items()
            )
            said.append(f"RMS error against the truth: {', '.join(shown)}")
        for name, found in (("NIS of the innovations", self.nis), ("NEES", self.nees)):
            if found is not None:
                said.append(
                    f"{name}: mean {found.mean:.4g}, expected {found.expected:.4g} "
                    f"(95 % of consistent runs: {found.lower:.4g} to {found.upper:.4g}, "
                    "if instants were independent)"
                )
        return said


def claimed_tilt(history: EstimateHistory) -> float | None:
    """Return the standard deviation of the elevation at the last step; None where it has none."""
    if TILT not in history.names or not len(history):
        return None
    return float(history.std_of(TILT)[-1])


def bias_and_tilt(model: StateSpaceModel, history: EstimateHistory) -> list[str]:
    """Say, once, where an accelerometer's bias and a tilt are not told apart.

    That is where the bias stays about as unknown as it was, and the tilt with it.
    """
    tilt = claimed_tilt(history)
    if tilt is None:
        return []
    for sensor in model.sensors:
        if not sensor.bias_states or set(sensor.unit_of_axis) != {"m_s2"}:
            continue
        bias = float(np.mean([history.std_of(name)[-1] for name in sensor.bias_states]))
        before = model.prior.std[model.state_names.index(sensor.bias_states[0])]
        as_tilt = bias / STANDARD_GRAVITY_M_S2
        if tilt > ALIKE * as_tilt and bias > OBSERVABLE_FRACTION * before:
            return [
                f"bias and tilt are not told apart: the bias of {sensor.name}, known to "
                f"{bias:.2g} m/s², looks like a tilt of {np.degrees(as_tilt):.2g}°; elevation is "
                f"claimed to {np.degrees(tilt):.2g}° (a camera, or a calibrated bias_std, tells "
                "more)"
            ]
    return []


def _in_readable_unit(unit: str, value: float) -> str:
    return f"{value * 1e3:.3f} mm" if unit == "m" else f"{np.degrees(value):.3f}°"
