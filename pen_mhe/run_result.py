"""What came out of one run of an estimator on a recording."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from estimation.consistency import Consistency
from estimation.history import EstimateHistory
from estimation.recording import Recording
from estimation.truth import Truth
from estimation.watch.words import watch_sentences
from models.state_space import StateSpaceModel
from pen_mhe.run_summary import RunSummary, bias_and_tilt, claimed_tilt
from pen_mhe.truth.judged import JudgedByTruth
from pen_mhe.unseen import output_table, unseen
from recordings.finding import Finding
from recordings.ink import InkMatch
from recordings.thinning import LeftOutError

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


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
    judged : by a truth from elsewhere, where one was given
    findings : what an estimate of the recording may suffer from
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
    judged: JudgedByTruth | None = None
    findings: tuple[Finding, ...] = ()

    def __repr__(self) -> str:
        summary = self.summary()
        title = f"{summary.estimator} on {summary.recording}: {summary.size}"
        return "\n".join([title, *summary.sentences()])

    def plot(self) -> Figure:
        """Draw the tip's path, over the ink where there is a scan, angles and step times."""
        from pen_mhe.figures import estimate_figure  # slow to import

        return estimate_figure(self.output, self.ink, truth=self.truth, unseen=self.unseen)

    @property
    def truth(self) -> Truth | None:
        """The truth that was given, in the estimate's frame, else the one of the recording."""
        given = None if self.judged is None else self.judged.truth
        return self.used.truth if given is None else given

    @property
    def unseen(self) -> frozenset[str]:
        """Of place and attitude, what no reading shows in most rows of `output`."""
        return unseen(self.model, self.output)

    def to_pandas(self) -> pd.DataFrame:
        """Return the table of `output`, with what is not observable in each row.

        Beside a given truth it has ``<name>_true`` and ``<name>_error`` too.
        """
        table = output_table(self.model, self.output)
        if self.judged is not None:
            for name, column in self.judged.columns().items():
                table[name] = column
        return table

    def summary(self) -> RunSummary:
        """Return the run's figures without its arrays."""
        history = self.history
        return RunSummary(
            recording=self.used.name,
            estimator=history.estimator,
            samples=len(self.output),
            steps=len(history),
            statuses=Counter(history.status),
            median_step_s=float(np.median(history.step_time_s)),
            p99_step_s=float(np.quantile(history.step_time_s, 0.99)),
            left_out=self.left_out,
            true_rms=self.true_rms,
            nis=self.nis,
            nees=self.nees,
            zero_delay=self.zero_delay,
            delays_s=self.delays_s,
            bias_and_tilt=tuple(bias_and_tilt(self.model, history)),
            watch=tuple(watch_sentences(history)),
            ink_mm=None if self.ink is None else self.ink.mean_distance_mm,
            is_causal=self.is_causal,
            lag_samples=self.lag_samples,
            is_smoothed=self.is_smoothed,
            rows_without=self.rows_without,
            notes=self.notes,
            judged=() if self.judged is None else self.judged.said,
            unseen=self.unseen,
            findings=self.findings,
            tilt_std_rad=claimed_tilt(history),
        )

    def sentences(self) -> list[str]:
        """Return what the run says of itself: statuses, times, errors, consistency, ink."""
        return self.summary().sentences()
