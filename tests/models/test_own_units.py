"""Units of one's own, or none, in tables, drawings and summaries of a history."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.estimator import run
from estimation.history import EstimateHistory
from models.errors import InputError
from models.own_models import own_model
from models.own_sensors import OwnSensor
from models.state_space import StateSpaceModel
from models.units import shown
from pen_mhe.comparison import compare
from pen_mhe.estimators import create_estimator
from recordings.simulate_pen import simulate_model

STATES = {
    "temp": (300.0, 5.0),  # K
    "share_m": (0.5, 0.1),  # none, whatever its name ends in
    "c_a": (1.0, 0.2),  # none
    "heading": (0.1, 0.1),  # rad
    "level_m": (0.3, 0.1),  # m, as it says itself
}
UNITS = {"temp": "K", "share_m": "", "heading": "rad"}


@pytest.fixture(scope="module")
def model() -> StateSpaceModel:
    return own_model(
        "cell", STATES, lambda x, w, dt: x + 0.01 * dt**0.5 * w, 5,
        {"all": OwnSensor(lambda x: x, dict.fromkeys("abcde", ""), 0.1, 10.0)}, units=UNITS,
    )  # fmt: skip


@pytest.fixture(scope="module")
def history(model: StateSpaceModel) -> EstimateHistory:
    return run(create_estimator("ekf", model), simulate_model(model, duration_s=1.0, seed=0))


def test_a_history_knows_its_units(history: EstimateHistory) -> None:
    assert [history.unit_of(name) for name in STATES] == ["K", "", "", "rad", "m"]
    assert history[:2].unit_of("temp") == "K"
    with pytest.raises(InputError, match="state tmp is unknown"):
        history.unit_of("tmp")


def test_a_drawing_is_labelled_with_them(history: EstimateHistory) -> None:
    labels = {axes.get_ylabel() for axes in history.plot(list(STATES)).axes if axes.get_visible()}
    assert labels == {"temp (K)", "share m", "c a", "heading (deg)", "level (mm)"}
    drawn = [axes.get_ylabel() for axes in history.plot().axes]
    assert drawn == ["heading (deg)", "level (mm)"]


def test_a_table_for_a_notebook_has_them(history: EstimateHistory) -> None:
    rows = history._repr_html_().split("<tr>")[2:]
    cells = [row.split("</td><td>")[1].split("</td>")[0] for row in rows]
    assert cells == ["K", "", "", "deg", "m"]


def test_columns_are_the_names(history: EstimateHistory) -> None:
    table = history.to_pandas()
    assert list(table.columns[1:6]) == list(STATES)
    np.testing.assert_array_equal(table["heading"], history.mean[:, 3])


def test_a_comparison_says_where_it_shows_degrees(history: EstimateHistory) -> None:
    table = compare({"run": history}).table
    assert list(table.columns[:5]) == [
        "temp_std", "share_m_std", "c_a_std", "heading_deg_std", "level_m_std"
    ]  # fmt: skip
    degrees = np.degrees(np.sqrt(np.mean(history.std[:, 3] ** 2)))
    assert table["heading_deg_std"].item() == pytest.approx(degrees, rel=1e-12)


def test_a_model_prints_them(model: StateSpaceModel) -> None:
    lines = repr(model).splitlines()[1:6]
    assert [line.split("± ")[1] for line in lines] == ["5 K", "0.1", "0.2", "0.1 rad", "0.1 m"]


def test_units_are_shown_as_given() -> None:
    assert shown("azimuth_rate_rad_s") == shown("azimuth_rate_rad_s", "rad/s")
    assert shown("rate", "rad/s") == ("rate", "deg/s", shown("azimuth_rad")[2])
    assert shown("attitude_w", "1") == ("attitude w", "", 1.0)
    assert shown("share_m", "mol") == ("share m", "mol", 1.0)
