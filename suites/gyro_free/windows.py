"""The pen without a gyroscope as a body that windows are cut from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from estimation.recording import Recording
from models.state_space import StateSpaceModel
from suites.gyro_free.cases import CASES, TEST_CASE, TWO_ACCELS
from suites.gyro_free.gesture import gesture
from suites.gyro_free.pen import LOWER, UPPER, TwoAccelerometers, start, two_accelerometers
from suites.gyro_free.readings import readings
from suites.windows import Recorded, WindowBody

FASTEST = {"fast": 4.0}
"""Kind of window → rate of its gestures, rad/s; the test case's for others."""


def window_bodies() -> Mapping[str, WindowBody]:
    """Return the test case's pen by name.

    Its start is known to 0.1 deg, so no window starts wrong: windows of a free pen with two
    accelerometers do.
    """
    case = CASES[TEST_CASE]
    _, model = two_accelerometers(
        TwoAccelerometers(
            case.half_distance_m, case.errors.single_noise_std, case.errors.single_bias_std
        )
    )
    kinds = ("plain", "missing", "fast")
    body = WindowBody(model, case.gesture.step_s, partial(_recorded, model), kinds)
    return {f"gyro-free {TWO_ACCELS}": body}


def _recorded(
    model: StateSpaceModel, kind: str, duration_s: float, rng: np.random.Generator
) -> Recorded:
    case, seed = CASES[TEST_CASE], int(rng.integers(2**31))
    rate = FASTEST.get(kind, case.gesture.rate_rad_s)
    longest = max(duration_s, case.gesture.duration_s)
    motion = gesture(replace(case.gesture, rate_rad_s=rate, duration_s=longest), seed)
    f1, f2 = readings(motion, case.half_distance_m, case.reading_errors, seed)
    recording = Recording(TEST_CASE, motion.time_s, {LOWER: f1, UPPER: f2})
    return recording, start(model, motion.C[0])
