"""The simulated turntable: constant rates within its ranges, the equations' readings."""

from __future__ import annotations

import numpy as np
import pytest

from models.errors import InputError
from models.table_motion import TableMotion, table_motions
from models.turntable import paper_turntable
from recordings.simulate_turntable import simulate_stroke, simulate_table
from tests.models.test_turntable import equation_10, equation_11, with_sensor


def test_the_table_runs_at_its_rates_within_its_ranges() -> None:
    starts = []
    for seed in range(10):
        recording = simulate_table(paper_turntable(), 5.0, seed)
        truth = recording.truth
        assert truth is not None
        times, forces = recording.sensor("accel")
        assert times == pytest.approx(np.arange(501) / 100, abs=1e-9)
        tilts = np.degrees(truth.values[:, :2])
        assert np.diff(tilts, axis=0) == pytest.approx(np.tile([0.051, 0.036], (500, 1)))
        assert (tilts >= [0, -10]).all()
        assert (tilts <= [355, 60]).all()
        assert truth.values[:, 2:] == pytest.approx(np.radians(np.tile([5.1, 3.6], (501, 1))))
        # Readings are the equations' with the sensors' noise: its mean vanishes, its size not.
        force_noise = forces - np.array([equation_10(x) for x in truth.values])
        rate_noise = recording.sensor("gyro")[1] - np.array([equation_11(x) for x in truth.values])
        for noise, std in ((force_noise, 0.0435), (rate_noise, 0.00773)):
            assert np.abs(noise.mean(axis=0)).max() < 5 * std / np.sqrt(501)
            assert noise.std() == pytest.approx(std, rel=0.15)
        starts.append(tilts[0])
    assert np.ptp(starts, axis=0).min() > 5


def test_a_seed_is_a_recording() -> None:
    """The same one whatever else is simulated: another sensor changes no other's noise."""
    fewer = paper_turntable()
    fewer = fewer.model_copy(update={"sensors": {"accel": fewer.sensors["accel"]}})
    first, again, other = (
        simulate_table(table, 0.1, seed).sensor("accel")[1]
        for table, seed in ((paper_turntable(), 5), (fewer, 5), (paper_turntable(), 6))
    )
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_biases_are_part_of_the_truth_and_of_the_readings() -> None:
    table = with_sensor("gyro", bias_std_rad_s=2.0)
    recording = simulate_table(table, 1.0, 3)
    truth = recording.truth
    assert truth is not None
    rates = np.array([equation_11(x[:4]) for x in truth.values])
    offset = (recording.sensor("gyro")[1] - rates).mean(axis=0)
    assert offset == pytest.approx(truth.values[0, 4:], abs=5 * 0.00773 / np.sqrt(101))
    assert np.abs(offset).max() > 0.1


def test_the_whole_range_of_an_axis() -> None:
    theta = simulate_table(paper_turntable(), 70 / 3.6, 0).truth
    assert theta is not None
    assert np.degrees(theta.values[[0, -1], 1]) == pytest.approx([-10, 60], abs=0.05)


def test_a_run_too_long_for_the_table() -> None:
    with pytest.raises(InputError, match=r"20 s leaves the range of an axis, .* at most 19\.4 s"):
        simulate_table(paper_turntable(), 20.0, 0)


@pytest.mark.parametrize("name", ["compound: horizontal-turn-left-fall", "rest"])
def test_a_stroke_is_recorded_along_its_path(name: str) -> None:
    motion = table_motions()[name]
    recording = simulate_stroke(paper_turntable(), motion, 3)
    truth = recording.truth
    assert truth is not None
    n = round(100 * motion.duration_s) + 1
    assert truth.time_s == pytest.approx(np.arange(n) / 100, abs=1e-9)
    assert truth.values[0, :2] == pytest.approx(motion.start_rad)
    # The tilts are the integral of the rates; an interval with a corner has some of both.
    steps = np.diff(truth.values[:, :2], axis=0)
    assert steps == pytest.approx(0.01 * truth.values[:-1, 2:], abs=1e-9)
    leg = np.searchsorted(motion.corners_s, truth.time_s + 1e-9)
    assert np.array_equal(np.sign(truth.values[:, 2:]), motion.runs[leg])
    force_noise = recording.sensor("accel")[1] - np.array([equation_10(x) for x in truth.values])
    rate_noise = recording.sensor("gyro")[1] - np.array([equation_11(x) for x in truth.values])
    for noise, std in ((force_noise, 0.0435), (rate_noise, 0.00773)):
        assert np.abs(noise.mean(axis=0)).max() < 5 * std / np.sqrt(n)
        assert noise.std() == pytest.approx(std, rel=0.15)


def test_a_seed_is_a_stroke() -> None:
    """Its rates and its noise; another sensor changes neither."""
    motion = table_motions()["principle: rise"]
    fewer = paper_turntable()
    fewer = fewer.model_copy(update={"sensors": {"accel": fewer.sensors["accel"]}})
    first, again, other = (
        simulate_stroke(table, motion, seed)
        for table, seed in ((paper_turntable(), 5), (fewer, 5), (paper_turntable(), 6))
    )
    assert first.truth is not None
    assert again.truth is not None
    assert other.truth is not None
    assert np.array_equal(first.truth.values, again.truth.values)
    assert np.array_equal(first.sensor("accel")[1], again.sensor("accel")[1])
    assert not np.array_equal(first.truth.values, other.truth.values)


def test_a_stroke_off_the_table_is_refused() -> None:
    motion = TableMotion.model_validate(
        {"description": "too far", "start_deg": [20, 50], "legs": [[4.0, 0, 1]]}
    )
    with pytest.raises(InputError, match=r"stroke too far: tilt_theta may reach .* within -10 to"):
        simulate_stroke(paper_turntable(), motion, 0)
