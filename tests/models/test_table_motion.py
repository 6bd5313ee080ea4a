"""Strokes of the turntable: their path, their rates, their limits, their table."""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from models import table_motion
from models.errors import InputError
from models.table_motion import TableMotion, check_limits, sample_table_motion, table_motions
from models.turntable import TurntableConfig, paper_turntable

NAMES = tuple(table_motions())
LEGS = [[1.0, 0, 0], [2.0, 1, -1], [0.75, -1, 0], [1.5, 0, 1]]
MOTION = TableMotion.model_validate({"description": "any", "start_deg": [20, 20], "legs": LEGS})


def path(motion: TableMotion, time_s: np.ndarray, seed: int = 0) -> np.ndarray:
    return sample_table_motion(paper_turntable(), motion, time_s, np.random.default_rng(seed))


def leg_of(motion: TableMotion, time_s: np.ndarray) -> np.ndarray:
    """Number of the leg that an instant is on, counted one leg after the other."""
    ends = [sum(leg[0] for leg in motion.legs[: n + 1]) for n in range(len(motion.legs))]
    return np.array([next((n for n, end in enumerate(ends) if t < end), n_last(motion))
                     for t in time_s])  # fmt: skip


def n_last(motion: TableMotion) -> int:
    return len(motion.legs) - 1


@pytest.mark.parametrize("motion", [MOTION, *table_motions().values()], ids=["any", *NAMES])
def test_the_path_is_the_integral_of_its_rates(motion: TableMotion) -> None:
    step = 1 / 1024  # exact in binary: corners fall on instants
    time_s = np.arange(0, motion.duration_s + step / 2, step)
    found = path(motion, time_s)
    # Rates are those of the leg that begins: rectangles from the left are exact.
    expected = motion.start_rad + np.vstack([[0, 0], np.cumsum(found[:-1, 2:] * step, axis=0)])
    assert np.abs(found[:, :2] - expected).max() < 1e-11
    assert found[0, :2] == pytest.approx(motion.start_rad, abs=1e-15)


@pytest.mark.parametrize("seed", range(20))
def test_a_leg_has_one_rate_within_its_tolerance(seed: int) -> None:
    table = paper_turntable()
    time_s = np.arange(0, MOTION.duration_s, 0.01)
    rates, leg = path(MOTION, time_s, seed)[:, 2:], leg_of(MOTION, time_s)
    drawn = np.array([np.unique(rates[leg == n], axis=0) for n in range(len(LEGS))])
    assert drawn.shape == (len(LEGS), 1, 2)
    for column, axis in enumerate(table.axes):
        for (_, *runs), rate in zip(LEGS, drawn[:, 0, column], strict=True):
            sign = runs[column]
            assert np.sign(rate) == sign
            if sign:
                assert abs(abs(rate) - axis.rate_rad_s) <= axis.rate_tolerance_rad_s


def test_rates_use_their_whole_tolerance() -> None:
    """Each of its own, evenly drawn: the mean and the spread of an even law."""
    rates = np.array([path(MOTION, np.array([1.5]), seed)[0, 2:] for seed in range(400)])
    for column, axis in enumerate(paper_turntable().axes):
        within = (np.abs(rates[:, column]) - axis.rate_rad_s) / axis.rate_tolerance_rad_s
        assert abs(within.mean()) < 5 / math.sqrt(3 * 400)
        assert within.std() == pytest.approx(1 / math.sqrt(3), rel=0.1)
    assert abs(np.corrcoef(rates.T)[0, 1]) < 0.25


def test_corners_are_where_a_leg_follows_another() -> None:
    assert MOTION.duration_s == 5.25
    assert list(MOTION.corners_s) == [1.0, 3.0, 3.75]
    assert np.array_equal(MOTION.runs, [[0, 0], [1, -1], [-1, 0], [0, 1]])
    before, at = path(MOTION, np.array([np.nextafter(3.0, 0), 3.0]))
    assert (before[2], at[2]) == (pytest.approx(-at[2], rel=0.5), at[2])
    assert before[2] > 0 > at[2]
    assert at[3] == 0 > before[3]
    assert before[:2] == pytest.approx(at[:2], abs=1e-12)
    assert table_motions()["rest"].corners_s.size == 0


def farthest(table: TurntableConfig, motion: TableMotion) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest tilt at the end of any leg, over all extreme rates of all legs."""
    reached = [[np.array(motion.start_rad)] * 2]
    for ends in product((-1, 1), repeat=len(motion.legs)):
        at = np.array(motion.start_rad)
        for (duration, *runs), end in zip(motion.legs, ends, strict=True):
            rates = [axis.rate_rad_s + end * axis.rate_tolerance_rad_s for axis in table.axes]
            at = at + duration * np.array(runs) * rates
            reached.append([at, at])
    return np.min(reached, axis=(0, 1)), np.max(reached, axis=(0, 1))


@pytest.mark.parametrize("name", NAMES)
def test_every_stroke_stays_on_the_table_at_any_rate(name: str) -> None:
    motion, table = table_motions()[name], paper_turntable()
    low, high = farthest(table, motion)
    for column, axis in enumerate(table.axes):
        assert axis.range_rad[0] <= low[column]
        assert high[column] <= axis.range_rad[1]
    assert high[0] < math.radians(70)  # where θ can still be seen
    check_limits(table, motion)
    assert 5.0 <= motion.duration_s <= 10.0


@pytest.mark.parametrize("name", NAMES)
def test_a_stroke_begins_and_ends_at_rest(name: str) -> None:
    motion = table_motions()[name]
    if name == "rest":
        assert not motion.runs.any()
        return
    for leg in (motion.legs[0], motion.legs[-1]):
        assert leg == (1.0, 0, 0)
    assert motion.runs[1:-1].any(axis=1).all()


def test_there_are_eight_principles_and_two_compounds() -> None:
    kinds = [name.partition(": ")[0] for name in NAMES]
    assert {kind: kinds.count(kind) for kind in kinds} == {"principle": 8, "compound": 2, "rest": 1}


@pytest.mark.parametrize(
    ("start_deg", "legs", "says"),
    [
        (
            [1, 20],
            [[1.0, -1, 0]],
            "tilt_phi may reach -5.1 to 1.0 deg, expected it within 0 to 355",
        ),
        ([354, 20], [[1.0, 1, 0]], "tilt_phi may reach 354.0 to 360.1 deg"),
        ([20, 50], [[3.0, 0, 1]], "tilt_theta may reach 50.0 to 62.3 deg, expected it within -10"),
        ([20, 0], [[3.0, 0, -1]], "tilt_theta may reach -12.3 to 0.0 deg"),
        ([20, 61], [[3.0, 0, 0]], "tilt_theta may reach 61.0 to 61.0 deg"),
        # Back at its start, but not on the way.
        ([20, 55], [[2.0, 0, 1], [2.0, 0, -1]], "tilt_theta may reach 53.0 to 63.2 deg"),
        # Only where it goes down slowly and up fast.
        ([20, 55], [[2.0, 0, -1], [3.0, 0, 1]], "tilt_theta may reach 46.8 to 61.1 deg"),
    ],
)
def test_a_stroke_that_may_leave_the_table_is_refused(
    start_deg: list[float], legs: list[list[float]], says: str
) -> None:
    motion = TableMotion.model_validate(
        {"description": "too far", "start_deg": start_deg, "legs": legs}
    )
    low, high = np.degrees(farthest(paper_turntable(), motion))
    assert (low < [0, -10]).any() or (high > [355, 60]).any()
    for refused in (
        lambda: check_limits(paper_turntable(), motion),
        lambda: path(motion, np.zeros(1)),
    ):
        with pytest.raises(InputError) as found:
            refused()
        assert str(found.value).startswith(f"stroke too far: {says}")


@pytest.mark.parametrize(
    ("row", "says"),
    [
        ("legs = [[1.0, 2, 0]]", "key legs.0.1: Input should be -1, 0 or 1"),
        ("legs = [[-1.0, 1, 0]]", "key legs.0.0: Input should be greater than 0"),
        ("legs = [[1.0, 1]]", "key legs.0.2: Field required"),
        ("legs = []", "key legs: Tuple should have at least 1 item"),
        ("", "key legs: Field required"),
        ("legs = [[1.0, 1, 0]]\nspeed = 2", "key (all keys): unknown key speed; expected one of"),
        ("legs = [[1.0, 1, 0]]\nstart_rad = [0, 0]", "(all keys): start_rad gives start_rad a"),
    ],
)
def test_a_malformed_row_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, row: str, says: str
) -> None:
    (tmp_path / "turntables").mkdir()
    (tmp_path / "turntables" / "strokes.toml").write_text(
        f'["a: b"]\ndescription = "x"\nstart_deg = [0, 0]\n{row}\n'
    )
    monkeypatch.setattr(table_motion, "resources", SimpleNamespace(files=lambda _: tmp_path))
    with pytest.raises(InputError) as found:
        table_motions.__wrapped__()
    assert str(found.value).startswith("models/turntables/strokes.toml: stroke a: b: ")
    assert says in str(found.value)


def test_a_row_that_is_no_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "turntables").mkdir()
    (tmp_path / "turntables" / "strokes.toml").write_text("hook = 3\n")
    monkeypatch.setattr(table_motion, "resources", SimpleNamespace(files=lambda _: tmp_path))
    with pytest.raises(InputError, match=r"stroke hook: key \(all keys\): Input should be a valid"):
        table_motions.__wrapped__()
