"""What waiting for some samples more is worth: python docs/fixed_lag.py [figure.png]

Handwriting of the bundled pen `reference`, simulated, its camera thinned: errors of the tip and
what ``mhe-rti`` claims of it, from the newest instant back to twenty samples before it.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import pen_mhe as pm
from recordings import CameraThinning, thinned

SENSORS, TIP = ["accel", "gyro", "camera"], ("tip_x_m", "tip_y_m", "tip_z_m")
RATES_HZ, LAGS, SEEDS, SETTLED = (30, 10, 5), range(21), range(5), 100


def curve(rate_hz):
    """Return per lag, mm: RMS of the tip's errors, and of their claimed deviations."""
    model = pm.pen_model("reference", SENSORS)
    mhe = pm.create_estimator("mhe-rti", model, horizon=26, lag_samples=tuple(LAGS))
    squares, claimed = np.zeros(len(LAGS)), np.zeros(len(LAGS))
    for seed in SEEDS:
        recording = pm.simulate(
            "reference", SENSORS, motion="handwriting", duration_s=6.0, seed=seed
        )
        used = thinned(model, recording, CameraThinning(rate_hz, 0))
        history = pm.run(mhe, used)
        instants = history.time_s[SETTLED : -LAGS[-1]]
        for lag in LAGS:
            told = history.at_lag(lag).at(instants)
            errors = told.errors(recording.truth)
            for name in TIP:
                squares[lag] += np.mean(errors[:, told.index(name)] ** 2)
                claimed[lag] += np.mean(told.std_of(name) ** 2)
    return 1e3 * np.sqrt(squares / len(SEEDS)), 1e3 * np.sqrt(claimed / len(SEEDS))


def main():
    """Print a row per camera rate and draw the curves."""
    figure, axes = plt.subplots(figsize=(7, 4.2), layout="constrained")
    for rate_hz in RATES_HZ:
        rms, claimed = curve(rate_hz)
        [line] = axes.plot(LAGS, rms, "o-", markersize=3, label=f"camera at {rate_hz} Hz")
        axes.plot(LAGS, claimed, "--", color=line.get_color(), linewidth=0.9)
        shown = ", ".join(
            f"{lag}: {rms[lag]:.3f} ({claimed[lag]:.3f})" for lag in (0, 5, 10, 14, 20)
        )
        print(f"{rate_hz:3d} Hz, tip RMS (claimed) / mm at lag {shown}")
    axes.plot([], [], "--", color="grey", linewidth=0.9, label="claimed deviation")
    axes.set_xlabel("lag / samples")
    axes.set_ylabel("tip: RMS error / mm")
    axes.set_xticks(range(0, 21, 2))
    axes.set_ylim(bottom=0)
    axes.grid(alpha=0.3)
    axes.legend()
    if len(sys.argv) > 1:
        figure.savefig(sys.argv[1], dpi=130)


if __name__ == "__main__":
    main()
