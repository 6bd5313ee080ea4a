"""In which order causes are tried."""

from __future__ import annotations

from functools import cache

from estimation.watch.hypotheses import Causes, Hypothesis
from tests.estimation.watch.test_watched import model

ACCEL, GYRO, CAMERA = 0, 1, 2
NONE = frozenset[int]()


@cache
def causes() -> Causes:
    assert [sensor.name for sensor in model().sensors[:3]] == ["accel", "gyro", "camera"]
    return Causes(model(), 4)


def tiers(level: int, *, is_livelier: bool) -> list[Hypothesis]:
    return [
        each
        for tier in causes().tiers(
            NONE, level, may_free=[ACCEL, GYRO], may_restart=False, is_livelier=is_livelier
        )
        for each in tier
        if not each.is_sudden
    ]


def test_a_livelier_motion_comes_first_where_all_sensors_say_so_and_its_top_last() -> None:
    found = tiers(0, is_livelier=True)
    assert [each.level for each in found[:2]] == [1, 2]
    assert found[-1] == Hypothesis(level=3)
    assert Hypothesis(frozenset({ACCEL})) in found


def test_else_a_sensor_is_blamed_before() -> None:
    found = tiers(0, is_livelier=False)
    blamed = found.index(Hypothesis(frozenset({GYRO})))
    assert blamed < found.index(Hypothesis(level=1)) < found.index(Hypothesis(level=2))
    assert Hypothesis(level=3) not in found


def test_of_a_motion_that_is_livelier_the_top_is_tried_at_once() -> None:
    assert tiers(2, is_livelier=True)[0] == Hypothesis(level=3)
    assert tiers(2, is_livelier=False)[-1] == Hypothesis(level=3)
    assert all(each.level == 3 for each in tiers(3, is_livelier=True))


def test_inertial_sensors_that_are_all_out_come_back_together() -> None:
    def found(others: frozenset[int], *, has_freed: bool) -> list[Hypothesis]:
        return causes().returning(others, ACCEL, 0, has_freed=has_freed, may_restart=True)

    together = [Hypothesis(NONE, NONE, True, level) for level in range(4)]
    assert found(frozenset({GYRO}), has_freed=True)[-4:] == together
    assert found(frozenset({GYRO, CAMERA}), has_freed=True)[-1].left_out == {CAMERA}
    assert not set(together[1:]) & set(found(NONE, has_freed=True))
    assert len(found(frozenset({GYRO}), has_freed=False)) == 1
