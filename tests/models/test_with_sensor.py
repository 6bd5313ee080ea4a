"""A sensor of one's own on a pen: read, simulated, judged, estimated with and exported."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import pen_mhe as pm
from models.errors import InputError
from models.pen_quantities import PenQuantities
from recordings.formats.tables import recording_to_table
from tests.models.pens import call, random_state

SENSORS = ("accel", "gyro", "range", "optical")
LOOKS_FROM = [0.0, 0.01, 0.05]


def distance(pen: PenQuantities) -> ca.SX:
    """Return how far a point of the barrel is from the table, along the pen, m."""
    return pen.point(LOOKS_FROM)[2] / pen.axis[2]


RANGE = pm.OwnSensor(distance, axes={"d": "m"}, noise_std=5e-4, rate_hz=50.0)  # type: ignore[arg-type]
OPTICAL = pm.OwnSensor(
    lambda pen: pen.tip_velocity[:2],  # type: ignore[attr-defined]
    axes={"x": "m/s", "y": "m/s"},
    noise_covariance=[[4e-6, 1e-6], [1e-6, 4e-6]],
    rate_hz=100.0,
)


def both() -> pm.PenConfig:
    pen = pm.with_sensor("reference", "range", RANGE, delay_ms=5.0)
    return pm.with_sensor(pen, "optical", OPTICAL, huber=5.0, bias_std=0.001)


def test_it_reads_what_its_function_says() -> None:
    """Every quantity, by SciPy and by hand."""
    rng = np.random.default_rng(2)
    x = random_state(rng, 6)
    p, attitude, v, omega, a, alpha = x[:3], Rotation.from_mrp(x[3:6]), *x[6:].reshape(4, 3)
    R, place = attitude.as_matrix(), rng.normal(0, 0.1, 3)
    turning = np.cross(omega, place)
    lever = np.cross(alpha, place) + np.cross(omega, turning)
    axis = R[:, 2]
    expected = {
        "tip": p,
        "tip_velocity": v,
        "tip_acceleration": a,
        "axis": axis,
        "azimuth": [np.arctan2(axis[1], axis[0])],
        "elevation": [np.arcsin(axis[2])],
        "body_rate": omega,
        "point": p + R @ place,
        "velocity": v + R @ turning,
        "specific_force": R.T @ (a + np.array([0, 0, 9.81])) + lever,
        "body_to_world": R.T.ravel(),  # CasADi stacks columns
    }

    def reads(pen: Any) -> ca.SX:
        found = [getattr(pen, name) for name in expected]
        return ca.vertcat(*(ca.vec(f(place.tolist()) if callable(f) else f) for f in found))

    read = np.concatenate([np.ravel(value) for value in expected.values()])
    axes = {f"a{i}": "" for i in range(len(read))}
    pen = pm.with_sensor("reference", "it", pm.OwnSensor(reads, axes, 1.0))
    model = pm.pen_model(pen, ["it"])
    np.testing.assert_allclose(call(model.sensor("it").h, x), read, rtol=0, atol=1e-12)


def test_it_is_a_sensor_like_any_other(tmp_path: Path) -> None:
    pen = both()
    model = pm.pen_model(pen, SENSORS)
    assert model.sensor("optical").huber == 5.0
    assert model.sensor("range").delay_s == pytest.approx(0.005)
    assert model.state_names[-2:] == ("optical_bias_x_m_s", "optical_bias_y_m_s")
    recording = pm.simulate(pen, SENSORS, motion="handwriting", duration_s=1.5, seed=1)
    table = recording_to_table(recording, pen)
    assert {"range_d_m", "optical_x_m_s", "range_arrival_s"} <= set(table.columns)
    table.to_csv(tmp_path / "it.csv", index=False)
    back = pm.read_recording(tmp_path / "it.csv", pen)
    for name in SENSORS:
        np.testing.assert_allclose(back.readings[name], recording.readings[name], rtol=1e-14)
    history = pm.run(pm.create_estimator("ekf", model), recording)
    assert history.solved_fraction == 1
    assert history.std_of("tip_z_m")[-1] < 2e-3  # of 0.1 m
    assert recording.truth is not None
    height = recording.truth.states(["tip_z_m"], history.time_s)[:, 0]
    assert np.abs(history.column("tip_z_m") - height)[20:].max() < 2e-3


@pytest.mark.slow
def test_observe_judges_it() -> None:
    for sensors, is_seen in ((SENSORS, True), (SENSORS[:2], False)):
        found = pm.observe(both(), sensors, motions=["handwriting"], duration_s=0.3)
        assert found.by_motion["handwriting"].sees("tip_z_m") == is_seen


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["mhe-rti", "mhe", "mhe-sparse", "mhe-ipopt"])
def test_every_mhe_takes_it(estimator: str) -> None:
    pen = both()
    model = pm.pen_model(pen, SENSORS)
    recording = pm.simulate(pen, SENSORS, motion="handwriting", duration_s=0.6, seed=1)
    reference = pm.run(pm.create_estimator("mhe", model), recording)
    history = pm.run(pm.create_estimator(estimator, model), recording)
    assert (history.to_pandas()["status"][20:] == "solved").all()  # IPOPT may stop at the start
    tip = history.column("tip_z_m") - reference.column("tip_z_m")
    assert np.abs(tip[20:]).max() < reference.std_of("tip_z_m")[-1]


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["ekf", "mhe-rti"])
def test_it_is_exported(tmp_path: Path, estimator: str) -> None:
    pm.export_c(estimator, pm.pen_model(both(), SENSORS), tmp_path)
    header = (tmp_path / "pen.h").read_text("utf-8")
    assert "range, m" in header
    assert "optical, m/s, m/s" in header


def test_a_unit_of_its_own_stands_in_the_columns(tmp_path: Path) -> None:
    warmth = pm.OwnSensor(lambda pen: pen.elevation, {"warm": "K"}, 0.1, 50.0)  # type: ignore[attr-defined]
    share = pm.OwnSensor(lambda pen: pen.axis[2], {"share": ""}, 0.1, 50.0)  # type: ignore[attr-defined]
    pen = pm.with_sensor(pm.with_sensor("reference", "thermo", warmth), "light", share)
    recording = pm.simulate(pen, ["thermo", "light"], duration_s=0.2)
    table = recording_to_table(recording, pen)
    assert {"thermo_warm_K", "light_share"} <= set(table.columns)
    table.to_parquet(tmp_path / "it.parquet")
    back = pm.read_recording(tmp_path / "it.parquet", pen)
    np.testing.assert_array_equal(back.readings["thermo"], recording.readings["thermo"])
    np.testing.assert_array_equal(back.readings["light"], recording.readings["light"])


def reads(axes: Any, function: Any = lambda pen: pen.tip, **keys: Any) -> pm.OwnSensor:
    return pm.OwnSensor(function, axes, **{"noise_std": 1.0, **keys})


XYZ = dict.fromkeys("xyz", "m")
BAD: dict[str, tuple[tuple[Any, ...], dict[str, Any], str]] = {
    "a name that is taken": (("accel", reads(XYZ)), {}, "sensor accel is there already"),
    "no name": (("", reads(XYZ)), {}, "expected a letter"),
    "no sensor": (("it", lambda pen: pen.tip), {}, "expected an OwnSensor"),
    "an axis with a blank": (("it", reads({"a b": "m"})), {}, "it: axis: name"),
    "another number of axes": (("it", reads({"x": "m"})), {}, "its reading has shape"),
    "two arguments": (("it", reads(XYZ, lambda x, u: x)), {}, r"expected a function of \(pen\)"),
    "no noise": (("it", reads(XYZ, noise_std=None)), {}, "expected either noise_std or"),
    "noise by an input": (("it", reads(XYZ, noise_std="u")), {}, "of numbers"),
    "noise that is no number": (("it", reads(XYZ, noise_std=-1.0)), {}, "noise_std"),
    "an unknown key": (("it", reads(XYZ)), {"dealy_ms": 3}, "unknown key dealy_ms"),
    "a delay below zero": (("it", reads(XYZ)), {"delay_ms": -3}, "greater than or equal to 0"),
    "foreign symbols": (("it", reads(XYZ, lambda pen: ca.SX.sym("s", 3))), {}, "not the pen's"),
    "a constant": (("it", reads(XYZ, lambda pen: ca.SX([1, 2, 3]))), {}, "does not depend on"),
    "a bias in two units": (
        ("it", reads({"a": "m", "b": "rad"}, lambda pen: pen.tip[:2])),
        {"bias_std": 0.1},
        "several units",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_what_does_not_fit_is_said_in_one_sentence(case: str) -> None:
    given, keys, said = BAD[case]
    with pytest.raises(InputError, match=said) as error:
        pm.with_sensor("reference", *given, **keys)
    assert "\n" not in str(error.value)
