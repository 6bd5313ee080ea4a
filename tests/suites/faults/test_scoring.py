"""Scores of hand-made histories, by the definitions at the top of the table."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from estimation.status import Status
from estimation.watch.flags import Flag
from models.arrays import Array
from suites.faults.protocol import TILT, TIP
from suites.faults.said import Said
from suites.faults.scoring import RunErrors, broken, score
from suites.faults.table import Fault

TIME_S = np.round(np.arange(0, 8.001, 0.01), 9)
FAULT = Fault("by hand", "by hand", "lost", "imu", 3.0, 4.0, 8.0)
STAYS = replace(FAULT, end_s=math.inf)
STD_RAD = 1e-3


def at(begin_s: float, end_s: float, time_s: Array = TIME_S) -> Any:
    """Which instants are within a time, its end not included."""
    return (time_s > begin_s - 1e-6) & (time_s < end_s - 1e-6)


def made(
    *wrong: tuple[float, float, float],
    said: tuple[tuple[float, float, Status], ...] = (),
    flagged: tuple[tuple[float, float, Flag], ...] = (),
    time_s: Array = TIME_S,
    names: tuple[str, ...] = TILT,
) -> RunErrors:
    """RunErrors of half a deviation but for some times: begin, end, deviations of the first one."""
    stds = np.full((len(time_s), len(names)), 0.5)
    for begin_s, end_s, size in wrong:
        stds[at(begin_s, end_s, time_s), 0] = size
    status, flags = np.zeros(len(time_s), dtype=int), np.zeros((len(time_s), 2), dtype=np.uint8)
    for begin_s, end_s, word in said:
        status[at(begin_s, end_s, time_s)] |= word.value
    for begin_s, end_s, flag in flagged:
        flags[at(begin_s, end_s, time_s), 1] |= np.uint8(flag)
    told = Said(status, flags, ("accel", "gyro"))
    return RunErrors(names, time_s, STD_RAD * stds, stds, told, np.zeros(len(time_s)))


CLEAN = made()


def test_nothing_wrong() -> None:
    found = score(made(), CLEAN, FAULT)
    assert (found.silent_s, found.wrong_s, found.right_s, found.accurate_s) == (0, 0, 0, 0)
    assert not found.is_silent_wrong
    assert (found.said, found.told_s, found.false_flags, found.is_finite) == ("", 0, 0, True)


@pytest.mark.parametrize(
    ("wrong", "silent_s", "fails"),
    [
        ([(3.0, 3.2, 5.1)], 0.2, False),
        ([(3.0, 3.21, 5.1)], 0.21, True),
        ([(3.0, 4.0, 5.0)], 0.0, False),  # not beyond
        ([(3.0, 3.15, 6.0), (5.0, 5.15, 6.0)], 0.3, True),  # all together
    ],
)
def test_silent_and_wrong(
    wrong: list[tuple[float, float, float]], silent_s: float, fails: bool
) -> None:
    found = score(made(*wrong), CLEAN, FAULT)
    assert found.silent_s == pytest.approx(silent_s)
    assert found.wrong_s == pytest.approx(silent_s)
    assert found.is_silent_wrong == fails


def test_half_as_much_again_as_the_fault_free_runs_worst() -> None:
    clean = made((1.0, 1.01, 4.0))
    assert score(made((3.0, 3.5, 5.9)), clean, FAULT).wrong_s == 0
    assert score(made((3.0, 3.5, 6.1)), clean, FAULT).wrong_s == pytest.approx(0.5)


def test_each_quantity_has_its_own_limit() -> None:
    clean = made((1.0, 1.01, 40.0))  # of the first alone
    wrong = made()
    wrong.stds[at(3.0, 3.5), 1] = 5.5
    assert score(wrong, clean, FAULT).wrong_s == pytest.approx(0.5)


def test_a_word_breaks_the_silence_where_the_fault_free_run_does_not_say_it() -> None:
    wrong = made((3.0, 3.5, 9.0), said=((3.1, 3.6, Status.SATURATED),))
    found = score(wrong, CLEAN, FAULT)
    assert [found.silent_s, found.wrong_s] == pytest.approx([0.1, 0.5])
    assert found.said == "saturated 0.5 s"
    assert found.told_s == pytest.approx(0.5)
    clean = made(said=((1.0, 1.01, Status.SATURATED),))
    assert score(wrong, clean, FAULT).silent_s == pytest.approx(0.5)


def test_so_does_a_flag_of_any_sensor() -> None:
    wrong = made((3.0, 3.5, 9.0), flagged=((3.2, 4.2, Flag.STUCK),))
    found = score(wrong, CLEAN, FAULT)
    assert found.silent_s == pytest.approx(0.2)
    assert found.said == "gyro:stuck 1 s"
    assert found.flagged_s == pytest.approx(1.0)
    blamed = made(flagged=((1.0, 1.5, Flag.OUTLIER), (2.0, 2.5, Flag.OUTLIER)))
    found = score(wrong, blamed, FAULT)
    assert found.silent_s == pytest.approx(0.2)  # another flag is another word
    assert [found.false_flags, found.false_flagged_s] == pytest.approx([2, 1.0])
    assert score(wrong, made(flagged=((1.0, 1.5, Flag.STUCK),)), FAULT).silent_s == pytest.approx(
        0.5
    )


def test_right_again_is_a_window_of_which_one_in_twenty_may_be_off() -> None:
    # Instants 4.50 to 4.80 are 31: one of them may be off, two not.
    assert score(made((3.5, 4.5, 3.1)), CLEAN, FAULT).right_s == pytest.approx(0.49)
    assert score(made((3.5, 4.5, 2.9)), CLEAN, FAULT).right_s == 0
    again = made((3.5, 4.5, 4.0), (4.6, 4.62, 4.0))
    assert score(again, CLEAN, FAULT).right_s == pytest.approx(0.61)
    assert score(made((3.5, 9.0, 4.0)), CLEAN, FAULT).right_s == math.inf


def test_a_window_is_not_cut_short_by_the_end() -> None:
    assert score(made((3.5, 7.69, 4.0)), CLEAN, FAULT).right_s == pytest.approx(3.68)
    assert score(made((3.5, 7.75, 4.0)), CLEAN, FAULT).right_s == math.inf


def test_a_fault_that_stays_has_to_be_right_to_the_end() -> None:
    wrong = made((3.5, 4.5, 4.0))  # 100 of the 501 instants from 3 s on
    assert score(wrong, CLEAN, STAYS).right_s == pytest.approx(1.31, abs=0.015)
    late = made((7.0, 7.5, 4.0))
    assert score(late, CLEAN, FAULT).right_s == 0
    assert score(late, CLEAN, STAYS).right_s == pytest.approx(4.48, abs=0.015)


def test_of_few_instants_one_may_be_off_where_a_fault_stays() -> None:
    few = np.arange(0.0, 8.0)
    once = made((5.0, 5.5, 3.2), time_s=few)
    assert score(once, made(time_s=few), replace(STAYS, at_s=0.0)).right_s == 0
    twice = made((5.0, 6.5, 3.2), time_s=few)
    assert score(twice, made(time_s=few), replace(STAYS, at_s=0.0)).right_s == 6.0


def test_accurate_again_is_about_errors_and_not_about_claims() -> None:
    clean, wrong = made(names=(*TILT, *TIP)), made(names=(*TILT, *TIP))
    rms_deg = np.degrees(STD_RAD * 0.5 * np.sqrt(2))
    limit_deg = 1.5 * rms_deg + 0.3
    for size, expected in ((0.99, 0.0), (1.01, 1.0)):
        wrong.errors[:, :2] = STD_RAD * 0.5
        wrong.errors[at(3.0, 5.0), 0], wrong.errors[at(3.0, 5.0), 1] = (
            np.radians(size * limit_deg),
            0,
        )
        found = score(wrong, clean, FAULT)
        assert found.accurate_s == pytest.approx(expected, abs=0.3)
        assert found.peak_deg == pytest.approx(size * limit_deg)
    wrong.errors[:, :2] = STD_RAD * 0.5
    limit_mm = 1.5 * 1e3 * STD_RAD * 0.5 * np.sqrt(3) + 0.5
    wrong.errors[at(3.0, 9.0), 2:5] = 1e-3 * 1.01 * limit_mm / np.sqrt(3)
    found = score(wrong, clean, FAULT)
    assert (found.accurate_s, found.right_s) == (math.inf, 0)
    assert found.peak_mm == pytest.approx(1.01 * limit_mm)


def test_an_instant_stands_until_the_next() -> None:
    time_s = np.arange(9.0)  # 1 Hz
    wrong = made((5.0, 6.0, 9.0), time_s=time_s)
    found = score(wrong, made(time_s=time_s), replace(STAYS, at_s=0.0))
    assert found.silent_s == pytest.approx(1.0)
    assert found.right_s == 6.0
    hole = np.delete(TIME_S, at(3.0, 5.0))  # what is said before a hole is said of its begin
    before, behind = (made((t, t + 0.01, 9.0), time_s=hole) for t in (2.99, 5.0))
    assert score(before, CLEAN, FAULT).silent_s == pytest.approx(2.01)
    assert score(behind, CLEAN, FAULT).silent_s == pytest.approx(0.01)


def test_stamps_that_stand_twice_count_once() -> None:
    time_s = np.repeat(TIME_S, 2)
    wrong = made((3.0, 3.5, 9.0), time_s=time_s)
    assert score(wrong, CLEAN, FAULT).silent_s == pytest.approx(0.5)


def test_a_run_that_broke_off() -> None:
    found = broken("ValueError: so it was")
    assert found.is_silent_wrong
    assert not found.is_finite
    assert (found.right_s, found.accurate_s) == (math.inf, math.inf)


def history(values: dict[str, Array], std: float) -> Any:
    n = len(next(iter(values.values())))
    return SimpleNamespace(
        time_s=np.arange(n) / 100,
        column=values.__getitem__,
        std_of=lambda name: np.full(n, std),
        status=(Status.SOLVED,) * n,
        flagged=np.zeros((n, 0), dtype=np.uint8),
        sensor_names=(),
        step_time_s=np.zeros(n),
    )


def test_errors_go_the_short_way_round_and_numbers_that_are_none_are_infinite() -> None:
    estimate = {"spin_rad": np.array([3.1, -3.1, 0.0, np.nan]), "elevation_rad": np.zeros(4)}
    truth = {"spin_rad": np.array([-3.1, 3.1, 0.2, 0.0]), "elevation_rad": np.zeros(4)}
    found = RunErrors.of(history(estimate, 0.01), ("spin_rad", "elevation_rad"), truth)
    short = 2 * np.pi - 6.2
    np.testing.assert_allclose(found.errors[:3, 0], [-short, short, -0.2])
    np.testing.assert_allclose(found.stds[:3, 0], [100 * short, 100 * short, 20.0])
    assert (found.stds[3, 0], found.stds[3, 1]) == (math.inf, 0)
    assert not score(made((3.0, 3.1, math.inf)), CLEAN, FAULT).is_finite


def test_a_claim_of_no_deviation_is_wrong_by_any() -> None:
    values = {"elevation_rad": np.full(3, 1e-9)}
    found = RunErrors.of(history(values, 0.0), ("elevation_rad",), {"elevation_rad": np.zeros(3)})
    assert np.isinf(found.stds).all()
