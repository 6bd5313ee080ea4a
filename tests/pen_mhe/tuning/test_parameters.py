"""What of a pen can be tuned, by its fields; and the search that does it."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pen_mhe as pm
from pen_mhe.tuning.objectives import OBJECTIVES
from pen_mhe.tuning.parameters import chosen_parameters, parameters_of, with_values
from pen_mhe.tuning.search import WIDEST, Search
from tests.pen_mhe.tuning.pens import bounded_pen

KEYS = {
    "motion.tip.speed_m_s": "chain",
    "motion.tip.correlation_time_s": "chain",
    "motion.attitude.rate_rad_s": "chain",
    "motion.attitude.correlation_time_s": "chain",
    "sensors.accel.noise_density_m_s2_per_sqrt_hz": "noise",
    "sensors.accel.bias_walk_m_s2_per_sqrt_s": "walk",
    "sensors.gyro.noise_density_rad_s_per_sqrt_hz": "noise",
    "sensors.gyro.bias_walk_rad_s_per_sqrt_s": "walk",
    "sensors.camera.position_std_m": "noise",
    "sensors.camera.orientation_std_rad": "noise",
}
SENSORS = ["accel", "gyro", "camera"]


def test_parameters_are_found_by_their_fields() -> None:
    found = parameters_of(bounded_pen(), SENSORS)
    assert {p.key: p.role for p in found} == KEYS
    assert [p.key for p in found if p.sees_pose] == [k for k in KEYS if "camera" in k]


def test_each_objective_proposes_what_it_is_good_for() -> None:
    found = parameters_of(bounded_pen(), SENSORS)
    proposed = {name: [p for p in found if row.proposes(p)] for name, row in OBJECTIVES.items()}
    assert not any(p.sees_pose for p in proposed["innovations"])
    assert {p.table for p in proposed["without-camera"]} == {("motion", "tip")}
    assert {p.table for p in proposed["flatness"]} >= {("sensors", "camera")}


def test_a_bias_that_is_no_state_has_no_walk_and_a_walk_of_zero_starts_small() -> None:
    pen = bounded_pen()
    accel = pen.sensors["accel"].model_copy(
        update={"bias_std_m_s2": 0.0, "bias_walk_m_s2_per_sqrt_s": 0.0}
    )
    gyro = pen.sensors["gyro"].model_copy(update={"bias_walk_rad_s_per_sqrt_s": 0.0})
    pen = pen.model_copy(update={"sensors": {"accel": accel, "gyro": gyro}})
    walks = [p for p in parameters_of(pen, ["accel", "gyro"]) if p.role == "walk"]
    assert [p.table for p in walks] == [("sensors", "gyro")]
    assert walks[0].value(pen) == 0
    assert walks[0].start(pen) == pytest.approx(0.01 * math.radians(2.0))


def test_parameters_are_named_in_any_unit_or_by_their_beginning() -> None:
    found = parameters_of(bounded_pen(), SENSORS)
    texts = ["sensors.camera.orientation_std_deg", "motion.tip", "sensors.gyro.bias_walk"]
    assert [p.key for p in chosen_parameters(found, texts)] == [
        "motion.tip.speed_m_s",
        "motion.tip.correlation_time_s",
        "sensors.gyro.bias_walk_rad_s_per_sqrt_s",
        "sensors.camera.orientation_std_rad",
    ]
    with pytest.raises(pm.InputError, match=r"parameter sensors.cam is unknown; expected"):
        chosen_parameters(found, ["sensors.cam"])


def test_other_values_leave_the_rest() -> None:
    pen = bounded_pen()
    values = {p: 2 * p.value(pen) for p in parameters_of(pen, SENSORS)}
    changed = with_values(pen, values)
    assert {p: p.value(changed) for p in values} == values
    assert with_values(changed, {p: p.value(pen) for p in values}) == pen


def quadratic(x: np.ndarray) -> float:
    """Its optimum is at (2, 0.5); the third number has no effect."""
    return float(5 + 3 * np.log(x[0] / 2) ** 2 + 10 * np.log(2 * x[1]) ** 2)


def test_the_search_finds_the_optimum_and_says_how_flat_it_is() -> None:
    search = Search(lambda x: (quadratic(x), 0.03), np.array([20.0, 1.0, 1.0]))
    search.run()
    np.testing.assert_allclose(search.best[:2], [2.0, 0.5], rtol=2e-3)
    assert search.evaluations < 200
    (low, high), (narrow, wide), nothing = search.ranges()
    assert (low, high) == pytest.approx((2 * math.exp(-0.1), 2 * math.exp(0.1)), rel=0.01)
    assert wide / narrow == pytest.approx(math.exp(2 * math.sqrt(0.003)), rel=0.02)
    assert nothing == (0.0, math.inf)


def test_a_filter_that_breaks_down_is_walked_around() -> None:
    search = Search(
        lambda x: (math.inf if x[0] > 3 else quadratic(np.array([x[0], 0.5])), 0.03),
        np.array([2.9]),
    )
    search.run()
    assert search.best[0] == pytest.approx(2.0, rel=2e-3)
    assert search.best[0] > 2.9 / WIDEST
