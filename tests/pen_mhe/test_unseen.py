"""What no reading shows is said: row by row in the table, in words, and in the figure."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.estimator import run
from estimation.history import EstimateHistory
from models.pen import pen_model
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from pen_mhe.figures import NOT_SEEN, estimate_figure
from pen_mhe.unseen import COLUMN, UnseenInParts, output_table, unseen, unseen_words
from recordings.simulate_pen import simulate

pytestmark = pytest.mark.usefixtures("interpreted")
PLACE = {"tip_x_m", "tip_y_m", "tip_z_m"}


def estimated(*sensors: str) -> tuple[StateSpaceModel, EstimateHistory]:
    recording = simulate("reference", sensors, motion="turn", duration_s=0.6)
    model = pen_model("reference", sensors)
    return model, run(create_estimator("ekf", model), recording)


@pytest.mark.parametrize(
    ("sensors", "expected"),
    [
        (("accel", "gyro"), PLACE | {"azimuth_rad"}),
        (("gyro",), PLACE | {"azimuth_rad", "elevation_rad", "spin_rad"}),
        (("accel", "gyro", "camera"), set()),
        (("camera",), set()),
    ],
)
def test_what_sensors_do_not_show(sensors: tuple[str, ...], expected: set[str]) -> None:
    model, history = estimated(*sensors)
    assert unseen(model, history) == expected
    parts = UnseenInParts(model)
    for rows in (slice(0, 20), slice(20, None)):
        parts.add(history[rows])
    assert parts.result() == expected
    last = output_table(model, history)[COLUMN].iloc[-1]
    assert set(filter(None, last.split("+"))) == expected


def test_an_unseen_tip_is_not_drawn_and_an_unseen_angle_is_said() -> None:
    model, history = estimated("accel", "gyro")
    figure = estimate_figure(history, unseen=unseen(model, history))
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert "y (mm)" not in labels
    assert [axes.get_title(loc="left") for axes in figure.axes[:2]] == [NOT_SEEN, ""]
    assert "the tip is not observable" in figure.get_suptitle()
    whole = estimate_figure(history)
    assert "y (mm)" in [axes.get_ylabel() for axes in whole.axes]


def test_a_truth_is_within_its_panel() -> None:
    recording = simulate("reference", ["camera"], motion="turn", duration_s=0.6)
    model = pen_model("reference", ["camera"])
    history = run(create_estimator("ekf", model), recording)
    figure = estimate_figure(history, truth=recording.truth)
    for axes in figure.axes[1:4]:
        low, high = axes.get_ylim()
        for line in axes.get_lines():
            if line.get_label() == "truth":
                values = np.asarray(line.get_ydata())
                assert low <= values.min() <= values.max() <= high


def test_words() -> None:
    assert unseen_words(frozenset()) == ""
    assert unseen_words(frozenset({"azimuth_rad"})) == "azimuth"
    assert unseen_words(frozenset({"azimuth_rad", *PLACE})) == "tip and azimuth"
