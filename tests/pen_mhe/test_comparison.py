"""Several histories in one table and one drawing, of pens and of anything else."""

from __future__ import annotations

from collections.abc import Iterator

import matplotlib as mpl
import numpy as np
import pytest

mpl.use("Agg")
import matplotlib.pyplot as plt

from ekf_baseline.ekf import Ekf
from estimation.consistency import nis
from estimation.estimate import EstimateHistory
from estimation.estimator import run, run_measurements
from estimation.recording import Truth
from models.errors import InputError
from models.pen import pen_model
from pen_mhe.comparison import compare
from recordings.simulate_pen import simulate
from tests.benchmark.hand_made import history as history_of
from tests.linear_models import constant_acceleration_system

PEN = (
    *("tip_x_m", "tip_y_m", "tip_z_m", "azimuth_rad", "elevation_rad"),
    *("azimuth_rate_rad_s", "elevation_rate_rad_s", "accel_bias_x_m_s2"),
)
TIMES = np.linspace(0.0, 1.0, 11)
TRUTH = Truth(TIMES, PEN, np.zeros((11, 8)))


@pytest.fixture(autouse=True)
def _closed() -> Iterator[None]:
    yield
    plt.close("all")


def off(by: float, std: float = 0.1, failed: int = 0) -> EstimateHistory:
    return history_of(PEN, TIMES, np.full((11, 8), by), std, failed)


def test_a_row_has_errors_claims_and_cost() -> None:
    found = compare({"good": off(0.001), "bad": off(0.01, 0.2, failed=5)}, TRUTH)
    table = found.table
    assert list(table.index) == ["good", "bad"]
    assert list(table.columns) == [
        *("tip_mm_rms", "tip_mm_std", "azimuth_deg_rms", "azimuth_deg_std"),
        *("elevation_deg_rms", "elevation_deg_std", "rates_deg_s_rms", "rates_deg_s_std"),
        *("nis_per_row", "solved", "steps", "median_step_ms"),
    ]
    assert table.loc["good", "tip_mm_rms"] == pytest.approx(np.sqrt(3))
    assert table.loc["bad", "tip_mm_std"] == pytest.approx(200 * np.sqrt(3))
    assert table.loc["bad", "azimuth_deg_rms"] == pytest.approx(np.degrees(0.01))
    assert table.loc["bad", "rates_deg_s_rms"] == pytest.approx(np.degrees(0.01) * np.sqrt(2))
    assert table.loc["bad", "solved"] == pytest.approx(6 / 11)
    assert table.loc["good", "median_step_ms"] == pytest.approx(6000)
    assert np.isnan(table.loc["good", "nis_per_row"])
    assert {axes.get_ylabel() for axes in found.figure.axes} >= {"tip x (mm)", "elevation (deg)"}


def test_a_free_pens_row_has_its_angles_and_its_bodys_rates() -> None:
    """No component of its attitude is shown."""
    recording = simulate("reference", ["accel", "gyro"], duration_s=0.2)
    assert recording.truth is not None
    history = run(Ekf(pen_model("reference", ["accel", "gyro"])), recording)
    found = compare({"pen": history}, recording.truth)
    of_pens = ("tip_mm", "azimuth_deg", "elevation_deg", "spin_deg", "rates_deg_s")
    assert list(found.table.columns)[:10] == [f"{c}_{k}" for c in of_pens for k in ("rms", "std")]
    row = found.table.loc["pen"]
    true = dict(zip(recording.truth.names, recording.truth.values.T, strict=True))
    rates = [f"body_rate_{axis}_rad_s" for axis in "xyz"]
    for column, names in (("elevation_deg", ["elevation_rad"]), ("rates_deg_s", rates)):
        squared = sum((history.column(name) - true[name]) ** 2 for name in names)
        claimed = sum(history.std_of(name) ** 2 for name in names)
        assert row[f"{column}_rms"] == pytest.approx(np.degrees(np.sqrt(np.mean(squared))))
        assert row[f"{column}_std"] == pytest.approx(np.degrees(np.sqrt(np.mean(claimed))))
    labels = {axes.get_ylabel() for axes in found.figure.axes}
    assert labels >= {"tip x (mm)", "azimuth (deg)", "elevation (deg)", "spin (deg)"}
    assert not [label for label in labels if "mrp" in label or "attitude" in label]
    with pytest.raises(InputError, match="state mrp_x is unknown, expected one of tip_x_m"):
        compare({"pen": history}, states=["mrp_x"])


def test_without_truth_there_are_no_errors() -> None:
    columns = compare({"a": off(0.0)}).table.columns
    assert not [name for name in columns if name.endswith("_rms")]
    partly = compare({"a": off(0.0)}, Truth(TIMES, ("azimuth_rad",), np.zeros((11, 1)))).table
    assert [name for name in partly.columns if name.endswith("_rms")] == ["azimuth_deg_rms"]


def test_named_states_have_columns_of_their_own() -> None:
    table = compare({"a": off(0.5)}, TRUTH, states=["tip_x_m", "accel_bias_x_m_s2"]).table
    assert list(table.columns)[:4] == [
        *("tip_x_m_rms", "tip_x_m_std", "accel_bias_x_m_s2_rms", "accel_bias_x_m_s2_std")
    ]
    assert table.loc["a", "tip_x_m_rms"] == pytest.approx(0.5)


def test_a_model_of_ones_own() -> None:
    system = constant_acceleration_system(1)
    measurements = system.simulate(0.02 * np.arange(30), np.random.default_rng(3), missing=0.3)
    history = run_measurements(Ekf(system.model), measurements)
    names = system.model.state_names
    truth = Truth(history.time_s, names, history.mean - 0.25)
    found = compare({"mine": history, "a part": history[10:]}, truth)
    table = found.table
    for name in names:
        assert table[f"{name}_rms"].to_numpy() == pytest.approx([0.25, 0.25])
    squared, rows = nis(history, system.model.measured_rows)
    assert table.loc["mine", "nis_per_row"] == pytest.approx(np.nansum(squared) / rows.sum())
    assert list(table["steps"]) == [30, 20]


def test_a_notebook_and_a_prompt_show_it() -> None:
    found = compare({"<good>": off(0.001), "bad": off(0.01)}, TRUTH)
    html = found._repr_html_()
    assert "data:image/png;base64," in html
    assert "<good>" not in html
    assert "tip_mm_rms" in html
    assert "bad" in repr(found)
    assert "tip_mm_rms" in repr(found)


def test_what_cannot_be_compared_is_refused() -> None:
    with pytest.raises(InputError, match="no history to compare"):
        compare({})
    with pytest.raises(InputError, match="histories to compare are a list, expected name →"):
        compare([off(0.0)])  # type: ignore[arg-type]
    with pytest.raises(InputError, match="the history a has no steps"):
        compare({"a": off(0.0)[:0]})
    with pytest.raises(InputError, match="state spin_rad is unknown, expected one of tip_x_m"):
        compare({"a": off(0.0)}, states=["spin_rad"])
    late = Truth(TIMES + 0.5, PEN, np.zeros((11, 8)))
    with pytest.raises(InputError, match="no truth at 0 s"):
        _ = compare({"a": off(0.0)}, late).table
