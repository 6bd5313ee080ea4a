"""What the front door does in one call, on a pen by name, by path or as it is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import pen_mhe as pm
from pen_mhe.errors import ERROR_COLUMNS, root_mean_square
from recordings.formats.tables import recording_to_table, write_table

pytestmark = pytest.mark.usefixtures("interpreted")
SENSORS = ("accel", "gyro", "camera")
QUICK = {"estimator": "mhe-rti", "horizon": 3}


@pytest.fixture(scope="module")
def recording() -> pm.Recording:
    return pm.simulate("reference", SENSORS, duration_s=0.2, seed=3)


def same(one: pm.Recording, other: pm.Recording) -> bool:
    return all(
        np.array_equal(values, other.readings[name], equal_nan=True)
        for name, values in one.readings.items()
    )


def test_a_pen_may_be_given_by_name_by_path_or_as_it_is(recording: pm.Recording) -> None:
    for pen in (pm.load_pen("reference"), pm.bundled_pens()["reference"]):
        assert same(recording, pm.simulate(pen, SENSORS, duration_s=0.2, seed=3))
    with pytest.raises(pm.InputError, match="pen file referenz does not exist"):
        pm.simulate("referenz")


def test_estimate_is_the_loop_and_its_judgement(recording: pm.Recording) -> None:
    result = pm.estimate(recording, "reference", sensors=SENSORS, **QUICK)
    model = pm.pen_model(pm.load_pen("reference"), SENSORS)
    by_hand = pm.run(pm.create_estimator("mhe-rti", model, horizon=3), recording)
    np.testing.assert_array_equal(result.history.mean, by_hand.mean)
    assert recording.truth is not None
    for column, error in pm.rms_errors(model, by_hand, recording.truth).items():
        assert result.true_rms[column] == error
    first, second, *_ = said = repr(result).splitlines()
    samples, steps = len(result.output), len(recording.time_s)
    assert first == f"mhe-rti on turn (simulated): {samples} samples, {steps} steps"
    assert second == "solved 100.00% of the steps"
    assert any(line.startswith("RMS error against the truth: tip_mm ") for line in said)
    assert any(line.startswith("NEES: mean ") for line in said)


def test_estimate_reads_a_file(recording: pm.Recording, tmp_path: Path) -> None:
    path = tmp_path / "pen.csv"
    write_table(recording_to_table(recording, pm.load_pen("reference")), path)
    again = pm.read_recording(str(path), "reference")
    assert isinstance(again, pm.Recording)
    assert set(again.readings) == set(SENSORS)
    of_file, of_it = (pm.estimate(given, sensors=SENSORS, **QUICK) for given in (path, again))
    np.testing.assert_array_equal(of_file.history.mean, of_it.history.mean)


def test_what_is_of_another_type_is_refused(recording: pm.Recording) -> None:
    with pytest.raises(pm.InputError, match="pen is of type StateSpaceModel, expected a pen, the"):
        pm.estimate(recording, pm.pen_model("reference", ["accel"]))  # type: ignore[arg-type]
    with pytest.raises(pm.InputError, match="recording is of type NoneType, expected a recording"):
        pm.estimate(None)  # type: ignore[arg-type]
    with pytest.raises(pm.InputError, match="run is given str and Recording, expected an estim"):
        pm.run("ekf", recording)  # type: ignore[arg-type]


def test_units_are_for_files(recording: pm.Recording) -> None:
    with pytest.raises(pm.InputError, match="units are given for a recording, expected none"):
        pm.estimate(recording, units={"accel": "g"})


def test_errors_count_from_an_instant_on(recording: pm.Recording) -> None:
    model = pm.pen_model(pm.load_pen("reference"), SENSORS)
    history = pm.run(pm.Ekf(model), recording)
    assert recording.truth is not None
    late = pm.rms_errors(model, history, recording.truth, after_s=0.1)
    errors = pm.state_errors(model, history, recording.truth)[history.time_s >= 0.1]
    assert late == root_mean_square(history.names, errors, ERROR_COLUMNS)
    assert late != pm.rms_errors(model, history, recording.truth)


def test_a_verdict_prints_itself() -> None:
    found = pm.observe(sensors=["accel"], motions=["still"], duration_s=0.2)
    title, head, *rows = repr(found).splitlines()
    assert title == "reference pen, 6 degrees of freedom: accel, area"
    assert head.split() == ["state", "known", "before", "(std)", "still"]
    shown = [
        {"mrp_x": "azimuth_rad", "mrp_y": "elevation_rad", "mrp_z": "spin_rad"}.get(name, name)
        for name in found.model.state_names
    ]
    assert [row.split()[0] for row in rows[: found.model.n_x]] == shown
    assert any("no reading shows turning about the vertical alone" in row for row in rows)
    assert len({row.find("not observable") for row in rows} - {-1}) == 1


def test_the_table_of_the_paper_is_the_usual_one() -> None:
    assert pm.turntable_model().state_names[:2] == ("tilt_phi_rad", "tilt_theta_rad")
    assert [sensor.name for sensor in pm.turntable_model(sensors=["gyro"]).sensors] == ["gyro"]


def test_c_in_a_folder(tmp_path: Path) -> None:
    export = pm.export_c("ekf", pm.turntable_model(), tmp_path / "c", real="float", prefix="table")
    written = (tmp_path / "c" / "table.h").read_text("utf-8").splitlines()
    assert set(export.header.splitlines()) < set(written)  # and a number that says of which export
    assert "typedef float table_real;" in export.header
    assert "Written by `pen_mhe.export_c`" in (tmp_path / "c" / "README.md").read_text("utf-8")
    with pytest.raises(pm.InputError, match="estimator mhe cannot be exported as C"):
        pm.export_c("mhe", pm.turntable_model(), tmp_path)
