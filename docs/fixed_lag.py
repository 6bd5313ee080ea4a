"""What waiting for some samples more is worth: python docs/fixed_lag.py [figure.png] [--data DATA]

``mhe-rti``, each estimate with what had arrived by then: frames 45 ms late, from the newest instant
to forty samples of the IMU before it. Handwriting of the bundled pen `reference`, simulated, its
camera thinned: errors of the tip, and what is claimed of it. With ``--data``, the folder that holds
``dpoint_pen``, the ink distance of the recorded pen too, as a picture of its own, and that of the
EKF and its smoother with frames at their capture.
"""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import pen_mhe as pm
from estimation import smoothed
from recordings import CameraThinning, ink_match, read_written, thinned

SENSORS, TIP = ["accel", "gyro", "camera"], ("tip_x_m", "tip_y_m", "tip_z_m")
ON_PAPER = [*SENSORS, "contact"]
RATES_HZ, LAGS, SHOWN = (30, 15, 10, 6, 5, 3), range(41), (0, 5, 10, 14, 20, 30, 40)
SEEDS, SETTLED = range(5), 100
STAGES = 56
"""The longest lag in stages of the window: 40 samples, and the frames between them."""
INK_LAGS = range(0, 41, 2)


def causal_run(model, used):
    """Return a causal run that tells of every stage of its window, and the IMU's instants."""
    mhe = pm.create_estimator(
        "mhe-rti", model, horizon=STAGES, lag_samples=tuple(range(1, STAGES + 1))
    )
    return pm.run(mhe, used, causal=True), used.sensor("gyro")[0]


def simulated(rate_hz):
    """Return per lag, mm: RMS of the tip's errors, and of their claimed deviations."""
    model = pm.pen_model("reference", SENSORS)
    squares, claimed = np.zeros(len(LAGS)), np.zeros(len(LAGS))
    for seed in SEEDS:
        recording = pm.simulate(
            "reference", SENSORS, motion="handwriting", duration_s=6.0, seed=seed
        )
        used = thinned(model, recording, CameraThinning(rate_hz, 0))
        history, samples = causal_run(model, used)
        instants = samples[SETTLED : -LAGS[-1]]
        for lag in LAGS:
            told = history.at_lag_of(lag, samples).at(instants)
            errors = told.errors(recording.truth)
            for name in TIP:
                squares[lag] += np.mean(errors[:, told.index(name)] ** 2)
                claimed[lag] += np.mean(told.std_of(name) ** 2)
    return 1e3 * np.sqrt(squares / len(SEEDS)), 1e3 * np.sqrt(claimed / len(SEEDS))


def recorded(written, rate_hz):
    """Return per lag the mean ink distance, mm: the bundled pen, first phase of the thinning."""
    model = pm.pen_model("dpoint", ON_PAPER)
    used = thinned(model, written.recording.select(ON_PAPER), CameraThinning(rate_hz, 0))
    history, samples = causal_run(model, used)
    paths = (history.at_lag_of(lag, samples) for lag in INK_LAGS)
    return np.array([ink_match(path, written.ink).mean_distance_mm for path in paths])


def smoothed_ink(written, rate_hz):
    """Return the mean ink distance, mm, of the EKF with frames at their capture, and smoothed."""
    model = pm.pen_model("dpoint", ON_PAPER)
    used = thinned(model, written.recording.select(ON_PAPER), CameraThinning(rate_hz, 0))
    history = pm.run(pm.create_estimator("ekf", model), used, covariances=True)
    paths = (told.at(used.sensor("gyro")[0]) for told in (history, smoothed(model, used, history)))
    return [ink_match(path, written.ink).mean_distance_mm for path in paths]


def draw(axes, curves, name, limits):
    """Draw a line per camera rate; curves: rate → (lags, values), claims if there are any."""
    for rate_hz, (lags, values, claimed) in curves.items():
        [line] = axes.plot(lags, values, label=f"camera at {rate_hz} Hz")
        if claimed is not None:
            axes.plot(lags, claimed, "--", color=line.get_color(), linewidth=0.9)
    axes.set_xlabel("lag (samples of the IMU)")
    axes.set_ylabel(name)
    axes.set_xticks(range(0, LAGS[-1] + 1, 5))
    axes.set_yscale("log")
    axes.set_yticks(ticks := [0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 4], map(str, ticks))
    axes.minorticks_off()
    axes.set_ylim(*limits)
    axes.grid(alpha=0.3)


def main():
    """Print a row per camera rate and draw the curves."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("figure", nargs="?")
    parser.add_argument("--data", type=Path)
    options = parser.parse_args()
    n_panels = 1 if options.data is None else 2
    figure, panels = plt.subplots(
        1, n_panels, figsize=(6.2 * n_panels, 4.6), layout="constrained", squeeze=False
    )
    curves = {rate_hz: (LAGS, *simulated(rate_hz)) for rate_hz in RATES_HZ}
    for rate_hz, (_, rms, claimed) in curves.items():
        shown = " | ".join(f"{rms[lag]:.3f} ({claimed[lag]:.3f})" for lag in SHOWN)
        print(f"| {rate_hz} Hz | {shown} |")
    axes = panels[0, 0]
    draw(axes, curves, "tip: RMS error (mm)", (0.25, 4.7))
    axes.plot([], [], "--", color="grey", linewidth=0.9, label="claimed deviation")
    axes.set_title("simulated pen: error and claim", fontsize=10)
    axes.legend(fontsize=8)
    if options.data is not None:
        written = read_written(options.data / "dpoint_pen", pm.load_pen("dpoint"))
        inks = {rate_hz: (INK_LAGS, recorded(written, rate_hz), None) for rate_hz in RATES_HZ}
        for rate_hz, (_, distance, _) in inks.items():
            shown = " | ".join(f"{distance[INK_LAGS.index(lag)]:.3f}" for lag in SHOWN[::2])
            print(f"| {rate_hz} Hz | {shown} |")
        whole = zip(*(smoothed_ink(written, rate_hz) for rate_hz in RATES_HZ), strict=True)
        for name, distances in zip(("newest", "smoothed"), whole, strict=True):
            print(f"| {name} | {' | '.join(f'{mm:.3f}' for mm in distances)} |")
        draw(panels[0, 1], inks, "mean ink distance (mm)", (0.08, 0.6))
        panels[0, 1].set_title("D-POINT recording: distance to the ink", fontsize=10)
    if options.figure is not None:
        figure.savefig(options.figure, dpi=130)


if __name__ == "__main__":
    main()
