"""How far an answer can be trusted, in one line."""

from __future__ import annotations

import pytest

from estimation.consistency import Consistency
from estimation.status import Status
from pen_mhe.trust import trust_of
from recordings.finding import Finding, Severity

SOLVED = {Status.SOLVED: 100}


def nis(ratio: float) -> Consistency:
    return Consistency(6.0 * ratio, 6.0, 5.8, 6.2, 0.95, 100)


@pytest.mark.parametrize(
    ("ratio", "words"),
    [
        (1.2, "errors as the claimed deviations say (elevation: 2°)"),
        (9.0, "errors may be 3 times the claimed deviations (elevation: 2°)"),
        (float("inf"), "errors may be inf times"),
        (0.04, "innovations are 5 times smaller than expected"),
    ],
)
def test_innovations_say_how_far(ratio: float, words: str) -> None:
    trust = trust_of((), SOLVED, nis(ratio), tilt_std_rad=0.035)
    assert trust.is_meant
    assert words in trust.sentence
    assert ("pen-mhe tune" in trust.sentence) == (not 1 / 3 < ratio < 3)
    assert "\n" not in trust.sentence


def test_the_truth_says_more_than_innovations() -> None:
    """An estimate that is wrong of what no reading shows has small innovations."""
    far = Consistency(96.0, 6.0, 5.8, 6.2, 0.1, 100)
    trust = trust_of((), SOLVED, nis(0.04), nees=far)
    assert trust.sentence.startswith("trust: errors are 4 times the claimed deviations")
    assert (
        "innovations are 5 times smaller" in trust_of((), SOLVED, nis(0.04), nees=nis(1)).sentence
    )


def test_a_finding_says_that_it_cannot_be_meant() -> None:
    remark = Finding("it hums", "accel", 0.9, "hush it", check="noise")
    wrong = Finding("it lies", "gyro", 0.9, "mend it", Severity.NOT_MEANT, check="handedness")
    assert trust_of([remark], SOLVED, nis(1)).is_meant
    assert trust_of([remark], SOLVED, nis(1)).sentence.endswith("with the remarks on noise")
    found = trust_of([remark, wrong], SOLVED, nis(1))
    assert not found.is_meant
    assert "handedness: gyro" in found.sentence


def test_steps_that_are_not_solved() -> None:
    most = {Status.SOLVED: 90, Status.LOST: 10}
    assert trust_of((), most, nis(1)).is_meant
    assert "not where steps are not solved (10.0%)" in trust_of((), most, nis(1)).sentence
    few = {Status.SOLVED: 1, Status.LOST: 99}
    assert not trust_of((), few, nis(1)).is_meant
    assert "1.00% of the steps have one" in trust_of((), few, nis(1)).sentence
    assert trust_of((), {Status.ITERATION_LIMIT: 100}, nis(1)).is_meant


def test_nothing_to_judge_by() -> None:
    assert "nothing judges" in trust_of((), SOLVED, None).sentence
