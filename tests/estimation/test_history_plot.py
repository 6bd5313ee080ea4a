"""What a drawing of histories shows: labels, units, truth, bands, angles without jumps."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

mpl.use("Agg")
import matplotlib.pyplot as plt

from estimation.collect import collected
from estimation.estimate import Estimate, EstimateHistory
from estimation.history_plot import MOST_PANELS, MOST_POINTS, labelled, plot_histories
from estimation.recording import Truth
from estimation.status import Status
from models.arrays import Array
from models.errors import InputError
from models.gaussian import GaussianState
from models.pen import pen_model
from models.turntable import paper_turntable, turntable_model
from tests.benchmark.hand_made import history as history_of

TIMES = np.linspace(0.0, 2.0, 41)
NAMES = ("tip_x_m", "azimuth_rad", "azimuth_rate_rad_s", "accel_bias_x_m_s2")
TABLE = turntable_model(paper_turntable())


@pytest.fixture(autouse=True)
def _closed() -> Iterator[None]:
    yield
    plt.close("all")


def pen_history(factor: float = 1.0, std: float = 0.002) -> EstimateHistory:
    mean = factor * np.column_stack([0.02 * TIMES, TIMES / 10, TIMES**0 / 10, TIMES])
    return history_of(NAMES, TIMES, mean, std)


def panels(figure: Figure) -> dict[str, Axes]:
    return {axes.get_ylabel(): axes for axes in figure.axes if axes.get_visible()}


def line(axes: Axes, label: str) -> Array:
    [found] = [drawn for drawn in axes.lines if drawn.get_label() == label]
    return np.asarray(found.get_ydata())


def band(axes: Axes) -> Array:
    [found] = [c for c in axes.collections if isinstance(c, PolyCollection)]
    return np.asarray(found.get_paths()[0].vertices)


def test_positions_and_angles_are_drawn_in_mm_and_degrees() -> None:
    figure = pen_history().plot()
    assert list(panels(figure)) == ["tip x (mm)", "azimuth (deg)"]
    x, azimuth = panels(figure).values()
    np.testing.assert_allclose(line(x, "hand-made"), 20 * TIMES)
    np.testing.assert_allclose(line(azimuth, "hand-made"), np.degrees(TIMES / 10))
    at_end = band(azimuth)[band(azimuth)[:, 0] == 2.0, 1]
    assert at_end.min() == pytest.approx(np.degrees(0.2 - 0.004))
    assert at_end.max() == pytest.approx(np.degrees(0.2 + 0.004))
    [legend] = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["hand-made", "± 2 σ"]
    assert azimuth.get_xlabel() == "time (s)"


def test_named_states_are_drawn_in_their_order_and_units() -> None:
    figure = pen_history(100.0).plot([NAMES[3], NAMES[2], NAMES[0]])
    assert list(panels(figure)) == ["accel bias x (m/s²)", "azimuth rate (deg/s)", "tip x (m)"]
    with pytest.raises(InputError, match=r"state tip_y_m is unknown, expected one of tip_x_m, az"):
        pen_history().plot(["tip_y_m"])


def test_a_model_without_positions_and_angles_draws_its_first_states() -> None:
    names = tuple(f"speed_{k}_m_s" for k in range(12))
    figure = history_of(names, TIMES, np.tile(TIMES[:, None], 12)).plot()
    assert sorted(panels(figure)) == [f"speed {k} (m/s)" for k in range(MOST_PANELS)]


def test_truth_and_others_have_lines_of_their_own() -> None:
    truth = Truth(TIMES, ("azimuth_rad",), TIMES[:, None] / 9)
    figure = pen_history().plot(truth=truth, others=[pen_history(2.0)])
    x, azimuth = panels(figure).values()
    np.testing.assert_allclose(line(azimuth, "hand-made 2"), np.degrees(TIMES / 5))
    np.testing.assert_allclose(line(azimuth, "truth"), np.degrees(TIMES / 9))
    assert "truth" not in [drawn.get_label() for drawn in x.lines]
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert sorted(texts) == sorted(["hand-made 1", "hand-made 2", "truth", "± 2 σ"])
    named = pen_history().plot(others={"double": pen_history(2.0)})
    labels = {drawn.get_label() for drawn in named.axes[0].lines}
    assert labels == {"hand-made", "double"}


def test_labels_are_told_apart() -> None:
    one = pen_history()
    assert list(labelled(one, [one, one])) == ["hand-made 1", "hand-made 2", "hand-made 3"]
    assert list(labelled(one, {"b": one, "a": one})) == ["hand-made", "b", "a"]


@pytest.mark.parametrize("has_truth", [True, False])
def test_an_angle_has_no_jumps_and_stays_near_the_truth(has_truth: bool) -> None:
    """The estimate wraps at half a turn, the truth a sample later, another starts a turn away."""
    angle = np.pi - 0.5 + TIMES / 2
    wrapped = np.angle(np.exp(1j * angle))
    values = np.column_stack([wrapped, *[np.zeros_like(TIMES)] * 3])
    hand = dataclasses.replace(
        history_of(TABLE.state_names, TIMES, values, 0.01), difference=TABLE.difference
    )
    turn = np.array([2 * np.pi, 0, 0, 0])
    away = dataclasses.replace(hand, mean=hand.mean + turn, estimator="away")
    true = np.angle(np.exp(1j * (angle - 0.02)))[:, None]
    truth = Truth(TIMES, TABLE.state_names[:1], true) if has_truth else None
    figure = hand.plot(TABLE.state_names[:1], truth=truth, others=[away])
    for label in ("hand-made", "away"):
        drawn = line(figure.axes[0], label)
        np.testing.assert_allclose(drawn, np.degrees(angle), atol=1e-9)


def test_a_free_pens_angles_are_drawn_in_degrees_without_jumps() -> None:
    """Its azimuth, an output, wraps as an angle of the state does; σ is not drawn."""
    model = pen_model("reference", ["accel", "gyro"])
    angle = np.pi - 0.5 + TIMES / 2
    mean = np.zeros((len(TIMES), model.n_x))
    mean[:, 3:6] = Rotation.from_euler(
        "ZYZ", np.column_stack([angle, 0.6 * TIMES**0, -0.2 * TIMES**0])
    ).as_mrp()
    estimates = [
        Estimate(
            float(t),
            GaussianState(x, model.prior.covariance),
            Status.SOLVED,
            np.zeros(model.n_r),
            np.eye(model.n_r),
        )
        for t, x in zip(TIMES, mean, strict=True)
    ]
    figure = collected("by hand", model, estimates, [0.0] * len(TIMES)).plot()
    tip = [f"tip {axis} (mm)" for axis in "xyz"]
    assert sorted(panels(figure)) == sorted(
        [*tip, "azimuth (deg)", "elevation (deg)", "spin (deg)"]
    )
    of = {name: line(axes, "by hand") for name, axes in panels(figure).items()}
    np.testing.assert_allclose(of["azimuth (deg)"], np.degrees(angle), atol=1e-9)
    np.testing.assert_allclose(of["elevation (deg)"], np.degrees(np.pi / 2 - 0.6), atol=1e-9)
    np.testing.assert_allclose(of["spin (deg)"], np.degrees(-0.2), atol=1e-9)


def test_an_angle_that_does_not_wrap_keeps_its_turns() -> None:
    values = np.column_stack([8 * TIMES, *[np.zeros_like(TIMES)] * 3])
    hand = history_of(TABLE.state_names, TIMES, values)
    truth = Truth(TIMES, TABLE.state_names[:1], np.zeros((41, 1)))
    figure = hand.plot(TABLE.state_names[:1], truth=truth)
    np.testing.assert_allclose(line(figure.axes[0], "hand-made"), np.degrees(8 * TIMES))


def test_a_wide_prior_does_not_hide_the_rest() -> None:
    wide = pen_history()
    std, mean = wide.std.copy(), wide.mean.copy()
    std[:4], mean[:4] = 2.0, -1.0
    figure = dataclasses.replace(wide, std=std, mean=mean).plot(["tip_x_m"])
    low, high = figure.axes[0].get_ylim()
    assert -10 < low < 4
    assert 40 < high < 60


def test_nothing_cannot_be_drawn() -> None:
    with pytest.raises(InputError, match="no history to draw"):
        plot_histories({})
    assert list(panels(pen_history()[:0].plot())) == ["tip x (m)", "azimuth (deg)"]


def test_a_long_run_is_drawn_by_its_peaks() -> None:
    n = 3 * MOST_POINTS + 7
    value = np.random.default_rng(1).uniform(-0.01, 0.01, n)
    value[[17, n - 1]] = 0.05, -0.04
    times = np.arange(n) / 100
    hand = history_of(NAMES[:1], times, value[:, None], 0.001)
    axes = hand.plot().axes[0]
    drawn = line(axes, "hand-made")
    assert len(drawn) <= MOST_POINTS
    assert (drawn.max(), drawn.min()) == (50, -40)
    at = np.asarray(axes.lines[0].get_xdata())
    assert (np.diff(at) >= 0).all()
    rows = np.searchsorted(times, at)
    np.testing.assert_array_equal(drawn, 1e3 * value[rows])
