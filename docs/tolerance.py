"""What a looser tolerance of ``mhe`` saves and costs: python docs/tolerance.py

Simulated, 2 s of handwriting: CPU time, passes, and the furthest that any newest state came
from where iterating to 1e-11 ends, in standard deviations; all relative to the default.
"""

import time

import numpy as np

import pen_mhe as pm

SENSORS = (["accel", "gyro"], ["accel", "gyro", "camera"], ["accel_lower", "accel_upper"])
TOLERANCES, EXACT, REPEATS = (1e-8, 1e-6, 1e-5, 1e-4), 1e-11, 3


def timed(model, recording, tolerance):
    """Return the history and the least CPU time, s."""
    estimator, spent = pm.create_estimator("mhe", model, tolerance=tolerance), []
    for _ in range(REPEATS):
        began = time.thread_time()
        history = pm.run(estimator, recording)
        spent.append(time.thread_time() - began)
    return history, min(spent)


def main():
    """Print a row per choice of sensors and tolerance."""
    for sensors in SENSORS:
        model = pm.pen_model("reference", sensors)
        recording = pm.simulate("reference", sensors, duration_s=2.0, seed=3)
        exact, _ = timed(model, recording, EXACT)
        usual = None
        for tolerance in TOLERANCES:
            found, spent = timed(model, recording, tolerance)
            usual = usual or spent
            apart = np.abs((found.mean - exact.mean) / exact.std).max()
            print(
                f"{'+'.join(sensors):24s} {tolerance:7g}: {spent / usual:.2f} of the time, "
                f"{found.iterations.mean():.1f} passes, {apart:.0e} deviations away"
            )


if __name__ == "__main__":
    main()
