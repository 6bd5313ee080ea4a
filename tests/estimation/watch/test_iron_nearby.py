"""Iron near a magnetometer: the watch says so, and nobody believes it."""

from __future__ import annotations

import numpy as np
import pytest

import pen_mhe as pm
from estimation.watch.adopting import SPOKEN_S
from estimation.watch.flags import Flag
from estimation.watch.returning import AGAIN_S, RETURN_S
from tests.compass import SENSORS, azimuth_error, compass_pen, near_iron, written

IRON_UT, START_S, FOR_S = 30.0, 4.0, 3.0
SEED = 3
SIDES = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]


def check(estimator: str, side: list[float], ramp_s: float, duration_s: float = 12.0) -> None:
    clean = written(SEED, duration_s)
    disturbed = near_iron(
        clean, IRON_UT * np.array(side), start_s=START_S, for_s=FOR_S, ramp_s=ramp_s
    )
    bare = pm.create_estimator(estimator, pm.pen_model(compass_pen(), SENSORS))
    history = pm.run(pm.watched(bare), disturbed)
    times, flagged = history.time_s, history.flagged != 0
    mag = history.sensor_names.index("mag")
    inside = (times >= START_S) & (times < START_S + FOR_S)
    assert flagged[inside, mag].mean() > 0.9
    assert times[flagged[:, mag]][0] < START_S + 0.2 + ramp_s / 4
    assert not flagged[:, [i for i in range(flagged.shape[1]) if i != mag]].any()
    # Used again when a second with it fits, tried every half; spoken of for one second more.
    left_out = (history.flagged[:, mag] & Flag.LEFT_OUT) != 0
    assert times[left_out][-1] < START_S + FOR_S + RETURN_S + AGAIN_S + 0.1
    assert times[flagged[:, mag]][-1] < START_S + FOR_S + RETURN_S + AGAIN_S + SPOKEN_S + 0.1
    assert (history.flagged[inside, mag] & (Flag.OUTLIER | Flag.LEFT_OUT)).any()
    late = times >= 1.0
    without = azimuth_error(pm.run(bare, clean), clean)[late]
    error = azimuth_error(history, disturbed)[late]
    fooled = azimuth_error(pm.run(bare, disturbed), disturbed)[late]
    rms, of_clean, of_bare = (np.degrees(np.sqrt(np.mean(e**2))) for e in (error, without, fooled))
    assert rms < of_clean + 0.5
    assert of_bare > 5 * rms


def test_it_is_left_out_and_taken_back() -> None:
    check("ekf", SIDES[1], 0.3)


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["ekf", "mhe-rti"])
@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("ramp_s", [0.0, 0.3, 1.0])
def test_from_every_side_and_at_every_speed(
    estimator: str, side: list[float], ramp_s: float
) -> None:
    check(estimator, side, ramp_s)
