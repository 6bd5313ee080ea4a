"""What a recording hands to an estimator, instant by instant."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.pen import pen_model
from models.pen_config import PenConfig
from models.state_space import StateSpaceModel

ACCEL = {"kind": "accelerometer", "bandwidth_hz": 50.0, "noise_density_m_s2_per_sqrt_hz": 0.01}
CENTRE = (0.1, 0.2, 0.0)


def model_with_area(rate_hz: float | None) -> StateSpaceModel:
    area = {"kind": "writing_area", "centre_m": CENTRE, "rate_hz": rate_hz}
    config = PenConfig.model_validate({"name": "pen", "sensors": {"accel": ACCEL, "area": area}})
    return pen_model(config)


def recording_at(times: Array) -> Recording:
    return Recording("r", times, {"accel": np.tile(np.arange(len(times))[:, None], 3)})


def emissions(times: Array, rate_hz: float | None) -> list[int]:
    """Rows in which the writing area speaks."""
    measurements = recording_at(times).measurements(model_with_area(rate_hz))
    rows = []
    for row, measurement in enumerate(measurements):
        np.testing.assert_array_equal(measurement.y[:3], [row] * 3)
        assert measurement.time_s == times[row]
        if not np.isnan(measurement.y[3:]).any():
            np.testing.assert_array_equal(measurement.y[3:], CENTRE)
            rows.append(row)
        else:
            assert np.isnan(measurement.y[3:]).all()
    return rows


@pytest.mark.parametrize(("rate_hz", "every"), [(100.0, 10), (250.0, 4), (1000.0, 1), (1.0, 1000)])
def test_writing_area_speaks_at_its_rate(rate_hz: float, every: int) -> None:
    times = 17.0 + np.arange(2001) * 1e-3
    assert emissions(times, rate_hz) == list(range(0, 2001, every))


def test_writing_area_without_a_rate_speaks_every_time() -> None:
    assert emissions(np.array([0.0, 0.3, 0.31, 7.0]), None) == [0, 1, 2, 3]


def test_writing_area_slower_than_the_stamps_keeps_its_average() -> None:
    times = np.arange(10400) / 104.0
    assert len(emissions(times, 30.0)) == pytest.approx(3000, abs=1)


def test_writing_area_speaks_once_after_a_gap() -> None:
    """Due at 0, 10, 20, … ms: the instants at 50 and 50.1 ms share one due time."""
    times = np.array([0.0, 0.05, 0.0501, 0.0502, 0.061, 0.0611, 0.5, 0.5001])
    due = np.arange(0.0, 0.6, 0.01)
    wanted = sorted({int(np.searchsorted(times, t - 1e-9)) for t in due if t <= times[-1]})
    assert wanted == [0, 1, 4, 6]
    assert emissions(times, 100.0) == wanted


def test_writing_area_never_speaks_three_times_within_a_period() -> None:
    rng = np.random.default_rng(5)
    times = np.cumsum(rng.choice([0.0003, 0.002, 0.09], size=600, p=[0.6, 0.3, 0.1]))
    spoken = times[emissions(times, 100.0)]
    assert len(spoken) > 50
    # Two may stand close, a late one and a punctual one; a third never.
    assert (spoken[2:] - spoken[:-2] >= 0.01 - 1e-9).all()


def test_readings_are_stacked_in_the_models_order_and_missing_is_nan() -> None:
    gyro = {"kind": "gyroscope", "bandwidth_hz": 50.0, "noise_density_rad_s_per_sqrt_hz": 0.01}
    config = PenConfig.model_validate({"name": "pen", "sensors": {"accel": ACCEL, "gyro": gyro}})
    recording = Recording.from_sensors(
        "r",
        {
            "accel": (np.array([0.0, 0.2]), np.array([[1.0, 2, 3], [4, 5, 6]])),
            "gyro": (np.array([0.1, 0.2]), np.array([[7.0, 8, 9], [10, np.nan, 12]])),
            "unused": (np.array([0.15]), np.array([[1.0]])),
        },
    )
    y = np.array(
        [
            m.y
            for m in recording.measurements(
                pen_model(config, ["gyro", "accel"], writing_area=False)
            )
        ]
    )
    nan = [np.nan] * 3
    np.testing.assert_array_equal(
        y, [[*nan, 1, 2, 3], [7, 8, 9, *nan], [*nan, *nan], [10, np.nan, 12, 4, 5, 6]]
    )


def test_wrong_width_is_refused() -> None:
    recording = Recording("r", np.arange(2.0), {"accel": np.zeros((2, 2))})
    with pytest.raises(InputError, match=r"accel has 2 columns, expected 3 \(x, y, z\)"):
        list(recording.measurements(model_with_area(100.0)))


def test_a_missing_sensor_is_refused() -> None:
    recording = Recording("r", np.arange(2.0), {"gyro": np.zeros((2, 3))})
    with pytest.raises(InputError, match=r"no sensor accel; expected one of gyro"):
        list(recording.measurements(model_with_area(100.0)))
