"""How far the answer of a run can be trusted, in one line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from estimation.consistency import Consistency
from estimation.status import Status
from recordings.finding import Finding, not_meant

LIMITS = Status.ITERATION_LIMIT | Status.TIME_LIMIT
"""What ended a solver that was on its way: its best point is an answer."""
FEWEST_ANSWERED = 0.5
"""Part of the steps with an answer below which the whole is none."""
MOSTLY_SOLVED = 0.99
FAR_OFF = 3.0
"""Times by which NIS or NEES differ from what is expected; the deviations, by the root of it."""
TUNE = "pen-mhe tune finds noise and motion that fit"


@dataclass(frozen=True)
class Trust:
    """How far to trust an answer.

    Parameters
    ----------
    is_meant : whether it can be meant at all
    sentence : why, or how far
    """

    is_meant: bool
    sentence: str


def trust_of(
    findings: Sequence[Finding],
    statuses: Mapping[Status, int],
    nis: Consistency | None,
    *,
    nees: Consistency | None = None,
    tilt_std_rad: float | None = None,
) -> Trust:
    """Say how far to trust a run.

    Parameters
    ----------
    findings : of the recording
    statuses : how many steps ended in each
    nis : of the innovations; None where there is nothing to judge by
    nees : of the errors; None where the truth is not known
    tilt_std_rad : standard deviation of the elevation that is claimed at the end
    """
    wrong = not_meant(findings)
    if wrong:
        reasons = "; ".join(f"{found.check}: {found.where}" for found in wrong)
        return Trust(False, f"trust: this answer cannot be meant ({reasons}); mend that first")
    steps = sum(statuses.values())
    solved = sum(n for status, n in statuses.items() if status.is_solved) / max(steps, 1)
    answered = sum(n for status, n in statuses.items() if (status & ~LIMITS).is_solved)
    if answered < FEWEST_ANSWERED * steps:
        return Trust(
            False,
            f"trust: this answer cannot be meant: {answered / steps:.2%} of the steps have one; "
            "see what the others ended in, and what pen-mhe check says of recording and pen",
        )
    claimed = "" if tilt_std_rad is None else f" (elevation: {np.degrees(tilt_std_rad):.2g}°)"
    said = [f"trust: {_of_deviations(nis, nees, claimed)}"]
    if solved < MOSTLY_SOLVED:
        said.append(f"not where steps are not solved ({1 - solved:.1%})")
    if findings:
        said.append(f"with the remarks on {', '.join(dict.fromkeys(f.check for f in findings))}")
    return Trust(True, ", ".join(said))


def _of_deviations(nis: Consistency | None, nees: Consistency | None, claimed: str) -> str:
    if nees is not None and not nees.mean <= FAR_OFF * nees.expected:
        return (
            f"errors are {np.sqrt(nees.mean / nees.expected):.2g} times the claimed deviations on "
            f"the whole, by the truth (NEES {nees.mean:.3g}, expected {nees.expected:.3g}); {TUNE}"
        )
    if nis is None or nis.expected <= 0:
        return f"nothing judges the claimed deviations{claimed}"
    ratio = nis.mean / nis.expected
    times = float(np.sqrt(max(ratio, np.finfo(float).tiny)))
    if not ratio <= FAR_OFF:  # infinite too
        return (
            f"errors may be {times:.2g} times the claimed deviations{claimed}, as innovations are "
            f"(NIS {nis.mean:.3g}, expected {nis.expected:.3g}); {TUNE}"
        )
    if ratio < 1 / FAR_OFF:
        return (
            f"claimed deviations{claimed} are careful, innovations are {1 / times:.2g} times "
            f"smaller than expected (NIS {nis.mean:.3g}, expected {nis.expected:.3g}); {TUNE}"
        )
    return f"errors as the claimed deviations say{claimed}, which innovations agree with"
