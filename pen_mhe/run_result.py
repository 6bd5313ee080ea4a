"""What came out of one run of an estimator on a recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from estimation.consistency import Consistency
from estimation.history import EstimateHistory
from estimation.information_bound import OBSERVABLE_FRACTION
from estimation.recording import Recording
from models.state_space import StateSpaceModel
from recordings.ink import InkMatch
from recordings.thinning import LeftOutError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


TILT, STANDARD_GRAVITY_M_S2 = "elevation_rad", 9.80665
ALIKE = 0.5
"""A tilt's deviation over that of a bias' tilt, from which the two are not told apart."""


@dataclass(frozen=True, eq=False, repr=False)
class EstimateRun:
    """What came out of one run; prints itself as a few sentences.

    Parameters
    ----------
    history : one estimate per instant, camera instants included
    output : one estimate per sample of the fastest sensor, the IMU
    left_out : error against the camera frames that were left out
    true_rms : RMS errors against the truth, where the recording has it, or that a column
        is not observable
    nis, nees : consistency of innovations, and of errors where the truth of every state is
        known; None where there is nothing to judge by
    ink : the path laid over the ink, where there is a scan
    zero_delay : sensors whose readings were used at their capture in spite of a delay
    delays_s : of the sensors that are late, by how much: the median from capture to arrival, s
    is_causal : whether readings were taken as they arrived, none at its capture before
    lag_samples : how many samples before the newest that it knows a row of `output` speaks of
        (of a causal run: samples of the fastest sensor); errors and ink are at this lag too
    is_smoothed : whether each row of `output` knows the whole recording; errors and ink too
    rows_without : samples of the fastest sensor that no row speaks of: so long has not passed since
    notes : what was recognised, ignored and repaired in the file
    """

    model: StateSpaceModel
    used: Recording
    history: EstimateHistory
    output: EstimateHistory
    left_out: LeftOutError | None
    true_rms: dict[str, float | str]
    nis: Consistency | None
    nees: Consistency | None
    ink: InkMatch | None
    zero_delay: tuple[str, ...]
    delays_s: Mapping[str, float]
    is_causal: bool = False
    lag_samples: int = 0
    is_smoothed: bool = False
    rows_without: int = 0
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        samples = f"{len(self.output)} samples, {len(self.history)} steps"
        title = f"{self.history.estimator} on {self.used.name}: {samples}"
        return "\n".join([title, *self.sentences()])

    def plot(self) -> Figure:
        """Draw the tip's path, over the ink where there is a scan, angles and step times."""
        from pen_mhe.figures import estimate_figure  # slow to import

        return estimate_figure(self.output, self.ink, truth=self.used.truth)

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

    def sentences(self) -> list[str]:
        """Return what the run says of itself: statuses, times, errors, consistency, ink."""
        history, steps_ms = self.history, self.history.step_time_s * 1e3
        said = [*self.notes, f"solved {history.solved_fraction:.2%} of the steps"]
        remarks = [status for status in history.status if status.label != "solved"]
        said += [
            f"{remarks.count(status)} × {status.label}: {status.sentence}"
            for status in dict.fromkeys(remarks)
        ]
        median, p99 = np.median(steps_ms), np.quantile(steps_ms, 0.99)
        said.append(f"step time: median {median:.3g} ms, p99 {p99:.3g} ms")
        said += self._delay_sentences()
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
        said += bias_and_tilt(self.model, history)
        if self.ink is not None:
            said.append(f"mean ink distance: {self.ink.mean_distance_mm:.4f} mm")
        return said


def bias_and_tilt(model: StateSpaceModel, history: EstimateHistory) -> list[str]:
    """Say, once, where an accelerometer's bias and a tilt are not told apart.

    That is where the bias stays about as unknown as it was, and the tilt with it.
    """
    if TILT not in history.names or not len(history):
        return []
    tilt = float(history.std_of(TILT)[-1])
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
