"""Known levels are found again; the written file is worth what was said; halves are apart."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pen_mhe as pm
from models.pen_config import PenConfig
from pen_mhe.tuning.likelihood import log_likelihood
from pen_mhe.tuning.parts import ScoredPart
from pen_mhe.tuning.run import tune
from tests.pen_mhe.tuning.pens import bounded_pen

pytestmark = pytest.mark.slow
SENSORS = ["accel", "gyro", "camera"]
TUNED = (
    "motion.tip.speed_m_s",
    "motion.attitude.rate_rad_s",
    "sensors.accel.noise_density_ug_per_sqrt_hz",
    "sensors.gyro.noise_density_mdeg_s_per_sqrt_hz",
    "sensors.camera.position_std_mm",
    "sensors.camera.orientation_std_deg",
)
DEVIATIONS = 4.0
"""Of a number's own standard deviation: six numbers and a seed are within it in 99.96 %."""


def simulated(pen: PenConfig, sensors: list[str], duration_s: float, seed: int) -> pm.Recording:
    return pm.simulate_model(pm.pen_model(pen, sensors), duration_s=duration_s, seed=seed)


def off(pen: PenConfig, factors: dict[str, float]) -> PenConfig:
    """Return a pen whose numbers are wrong by factors; dotted keys in SI."""
    data = pen.model_dump()
    for key, factor in factors.items():
        *tables, field = key.split(".")
        place: Any = data
        for table in tables:
            place = place[table]
        place[field] *= factor
    return PenConfig.model_validate(data)


WRONG = {
    "motion.tip.speed_m_s": 1.7,
    "motion.attitude.rate_rad_s": 0.6,
    "sensors.accel.noise_density_m_s2_per_sqrt_hz": 2.0,
    "sensors.gyro.noise_density_rad_s_per_sqrt_hz": 0.5,
    "sensors.camera.position_std_m": 2.0,
    "sensors.camera.orientation_std_rad": 0.5,
}


def test_the_likelihood_finds_known_levels() -> None:
    """A loss of 2 nats is two standard deviations of a number, others held."""
    true = bounded_pen()
    recording = simulated(true, SENSORS, 30.0, seed=1)
    found = tune(recording, off(true, WRONG), sensors=SENSORS, parameters=TUNED, fit="all")
    for (parameter, value), number in zip(found.values.items(), found.numbers, strict=True):
        if "accel.noise" in parameter.key:  # the hand's own accelerations hide it
            assert number.low < parameter.value(true) < number.high
            continue
        assert number.is_determined
        one_std = math.log(number.high / number.low) / 4
        away = math.log(value / parameter.value(true)) / one_std
        assert abs(away) < DEVIATIONS, number.key
    assert found.scores["innovations"][1].value < found.scores["innovations"][0].value


def test_it_works_without_a_camera_and_says_what_is_not_determined() -> None:
    true = bounded_pen()
    sensors = ["accel", "gyro"]
    recording = simulated(true, sensors, 20.0, seed=2)
    wrong = off(true, {"sensors.gyro.noise_density_rad_s_per_sqrt_hz": 3.0})
    keys = ["sensors.gyro.noise_density", "sensors.gyro.bias_walk"]
    found = tune(recording, wrong, sensors=sensors, parameters=keys, fit="all")
    noise, walk = found.numbers
    assert noise.after == pytest.approx(noise.before / 3, rel=0.1)
    # 0.01 °/s per √s is 0.04 °/s after 20 s, under a hand that turns at 90 °/s.
    assert walk.low == 0
    assert any(f"{walk.key} is not determined" in sentence for sentence in found.sentences())
    assert set(found.scores) == {"innovations"}


def test_the_written_file_is_worth_what_was_said(tmp_path: Path) -> None:
    recording = simulated(bounded_pen(), SENSORS, 12.0, seed=3)
    found = tune(
        recording, "dpoint", sensors=SENSORS, parameters=["motion.attitude", "sensors.gyro.noise"]
    )
    found.write(tmp_path / "new.toml")
    model = pm.pen_model(pm.load_pen(tmp_path / "new.toml"), SENSORS)
    for part, said in (
        ("first-half", found.fitted[1].value),
        ("second-half", found.scores["innovations"][1].value),
    ):
        scored = ScoredPart.of(recording, part, pen=found.pen, model=model)
        used = scored.recording.select(SENSORS)
        history = pm.run(pm.create_estimator("ekf", model), used, covariances=True)
        counted = history.between(scored.counts_from_s)
        assert -log_likelihood(counted, model.measured_rows) == pytest.approx(said, abs=1e-4)
    assert [path.name for path in tmp_path.iterdir()] == ["new.toml"]


def test_the_fit_knows_nothing_of_the_other_half() -> None:
    recording = simulated(bounded_pen(), SENSORS, 12.0, seed=4)
    middle = (recording.time_s[0] + recording.time_s[-1]) / 2
    later = recording.time_s >= middle
    readings = {
        name: np.where(later[:, None], 0.9 * values, values)
        for name, values in recording.readings.items()
    }
    other = pm.Recording("hand", recording.time_s, readings, recording.truth)
    one, two = (
        tune(r, bounded_pen(), sensors=SENSORS, parameters=["motion.attitude"])
        for r in (recording, other)
    )
    assert one.values == two.values
    assert [score.value for score in one.fitted] == [score.value for score in two.fitted]
    assert one.scores["innovations"][1].value != two.scores["innovations"][1].value
