"""Levels as states: the filter is the one of the model with these levels written in."""

from __future__ import annotations

import numpy as np
import pytest

import pen_mhe as pm
from models.motion import Motion, TipMatern
from models.pen_config import PenConfig
from pen_mhe.tuning.levels import LevelFilter
from pen_mhe.tuning.parameters import with_values
from tests.pen_mhe.tuning.pens import bounded_pen

pytestmark = pytest.mark.usefixtures("interpreted")

CASES = {
    "contact": (bounded_pen(), ["gyro", "camera", "contact"]),
    "no spin": (pm.load_pen("reference").model_copy(update={"degrees_of_freedom": 5}), None),
    "matern": (
        pm.load_pen("reference").model_copy(
            update={"motion": Motion(tip=TipMatern(std_m=0.1, correlation_time_s=0.3))}
        ),
        ["accel", "gyro"],
    ),
}


def recorded(pen: PenConfig, sensors: list[str]) -> pm.Recording:
    """Return a tenth of a second of a turn, with a touch every other instant."""
    felt = [name for name in sensors if pen.sensors[name].rate_hz]
    recording = pm.simulate(pen, felt, duration_s=0.1, seed=2)
    touch = np.zeros((len(recording.time_s[::2]), 1))
    parts = {name: recording.sensor(name) for name in felt}
    parts |= {name: (recording.time_s[::2], touch) for name in sensors if name not in felt}
    return pm.Recording.from_sensors("touching", parts)


@pytest.mark.parametrize("case", CASES)
def test_a_choice_is_the_model_with_its_numbers(case: str) -> None:
    pen, sensors = CASES[case]
    sensors = sensors or ["accel", "gyro", "camera"]
    filtered = LevelFilter(pen, sensors)
    chosen = {p: p.start(pen) * (1.2 + 0.1 * i) for i, p in enumerate(filtered.parameters)}
    other = with_values(pen, chosen)
    model = pm.pen_model(other, sensors, rest=False)  # it takes no part in tuning
    recording = recorded(pen, [s.name for s in model.measured_sensors])
    expected = pm.run(pm.create_estimator("ekf", model), recording, covariances=True)
    # The filter was made for the first pen; another one before leaves no trace.
    filtered.history(pen, *recording.stacked(model))
    found = filtered.history(other, *recording.stacked(model), covariances=True)
    n = model.n_x
    np.testing.assert_allclose(found.mean[:, :n], expected.mean, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.std[:, :n], expected.std, rtol=1e-9)
    np.testing.assert_allclose(found.innovation, expected.innovation, rtol=0, atol=1e-9)
    np.testing.assert_allclose(
        found.innovation_covariance, expected.innovation_covariance, rtol=1e-9, atol=1e-15
    )
    np.testing.assert_allclose(
        found.column("elevation_rad"), expected.column("elevation_rad"), atol=1e-9
    )
    np.testing.assert_allclose(
        found.std_of("elevation_rad"), expected.std_of("elevation_rad"), rtol=1e-9
    )
