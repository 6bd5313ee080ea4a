"""A person's own data: lists, numbers and pandas objects are taken, or refused in a sentence."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import pytest

from estimation.estimator import run
from estimation.recording import Measurement, Recording, Truth
from models.errors import InputError
from models.own_models import own_model
from models.own_sensors import OwnSensor
from models.state_space import StateSpaceModel
from pen_mhe.estimators import LEAST_SQUARES, create_estimator, settings_read
from recordings.read import read_recording
from recordings.simulate_pen import simulate_model

pytestmark = pytest.mark.usefixtures("interpreted")

TIMES, LEVEL = [0.0, 0.1, 0.3], [1.0, np.nan, 1.2]
BOTH = [[0.1, 2.0], [0.2, np.nan], [0.3, 2.2]]


def tank(**changes: Any) -> StateSpaceModel:
    parts: dict[str, Any] = {
        "states": {"level_m": (1.0, 0.5)},
        "transition": lambda x, w, dt, u: x + dt * u + 0.1 * dt**0.5 * w,
        "n_noises": 1,
        "sensors": {
            "float": OwnSensor(lambda x: x[0], {"h": "m"}, 0.1, 10.0),
            "scale": OwnSensor(lambda x: [x[0], 2 * x[0]], {"a": "m", "b": "m"}, [0.1, 0.2], 10.0),
        },
        "inputs": {"flow": "m/s"},
    }
    return own_model("tank", **{**parts, **changes})


def recording(**changes: Any) -> Recording:
    parts: dict[str, Any] = {
        "time_s": np.array(TIMES),
        "readings": {"float": np.array(LEVEL)[:, None], "scale": np.array(BOTH)},
        "inputs": {"flow": np.full(3, 0.5)},
    }
    return Recording("run", **{**parts, **changes})


FRAME = pd.DataFrame(
    {"time_s": TIMES, "float_h": LEVEL, "scale_a": [r[0] for r in BOTH],
     "scale_b": [r[1] for r in BOTH], "flow": 0.5}
)  # fmt: skip
TAKEN: dict[str, Callable[[], Recording]] = {
    "lists": lambda: recording(
        time_s=TIMES, readings={"float": LEVEL, "scale": BOTH}, inputs={"flow": [0.5, None, 0.5]}
    ),
    "None where there is none": lambda: recording(
        readings={"float": [1, None, 1.2], "scale": BOTH}
    ),
    "masked where there is none": lambda: recording(
        readings={"float": np.ma.masked_equal([1.0, 7.0, 1.2], 7.0), "scale": BOTH}
    ),
    "a number": lambda: recording(inputs={"flow": 0.5}),
    "pandas": lambda: recording(
        time_s=FRAME["time_s"],
        readings={"float": FRAME["float_h"], "scale": FRAME[["scale_a", "scale_b"]]},
        inputs={"flow": FRAME["flow"]},
    ),
    "a table": lambda: read_recording(FRAME, tank()),
    "times of their own": lambda: Recording.from_sensors(
        "run",
        {"float": ([0.0, 0.3], [1.0, 1.2]), "scale": (TIMES, pd.DataFrame(BOTH))},
        inputs={"flow": ([0.0], [0.5])},
    ),
}


@pytest.mark.parametrize("case", TAKEN)
def test_a_recording_is_taken(case: str) -> None:
    found = TAKEN[case]()
    for one, other in zip(found.stacked(tank()), recording().stacked(tank()), strict=True):
        np.testing.assert_array_equal(one, other)


REFUSED: dict[str, tuple[Callable[[], Any], str]] = {
    "dates": (
        lambda: recording(time_s=pd.date_range("2026-01-01", periods=3)),
        r"times: DatetimeIndex that holds no numbers, expected \(n,\) seconds",
    ),
    "texts": (
        lambda: recording(readings={"float": ["a", "b", "c"], "scale": BOTH}),
        r"readings of float: list that holds no numbers, expected \(3, n\)",
    ),
    "lists of different lengths": (
        lambda: recording(readings={"float": LEVEL, "scale": [[1], [1, 2], [3]]}),
        "readings of scale: list that holds no numbers",
    ),
    "masked times": (
        lambda: recording(time_s=np.ma.masked_equal([0.0, 7.0, 9.0], 7.0)),
        "time of row 1 is not finite",
    ),
    "a time": (lambda: recording(time_s=0.0), r"times have shape \(\), expected \(n,\) seconds"),
    "times in columns": (lambda: recording(time_s=np.zeros((3, 1))), r"times have shape \(3, 1\)"),
    "no mapping": (lambda: recording(readings=FRAME), "readings are a DataFrame, expected sensor"),
    "an input's length": (
        lambda: recording(inputs={"flow": [0.5]}),
        r"input flow has values of shape \(1,\), expected \(3,\) of numbers",
    ),
    "inputs": (lambda: recording(inputs=[0.5]), "inputs are a list, expected name →"),
    "one axis of two": (
        lambda: recording(readings={"float": LEVEL, "scale": LEVEL}).stacked(tank()),
        r"scale has 1 columns, expected 2 \(a, b\)",
    ),
    "no pair": (lambda: Recording.from_sensors("run", {"float": TIMES}), "float is of type list"),
    "a truth": (lambda: Truth(TIMES, ("level_m",), BOTH), r"values \(3, 2\) of 1 states, expected"),
    "a pen's table": (lambda: read_recording(FRAME, "reference"), "expected the path of a rec"),
    "signals in a list": (
        lambda: simulate_model(tank(), inputs={"flow": [1.0, 2.0]}),
        r"input flow has values of shape \(2,\), expected .* finite numbers, one for each",
    ),
    "a signal of texts": (
        lambda: simulate_model(tank(), inputs={"flow": "fast"}),
        "input flow: str that holds no numbers, expected a number",
    ),
    "no noises": (lambda: tank(n_noises=1.5), "n_noises is 1.5, expected a whole number from 0"),
    "states in a list": (lambda: tank(states=["level_m"]), r"states are \['level_m'\], expected n"),
    "a state of text": (lambda: tank(states={"level_m": "full"}), "level_m starts from full, exp"),
    "no sensor": (
        lambda: tank(sensors={"float": lambda x: x[0]}),
        "sensor float is <function .*>, expected an OwnSensor",
    ),
    "sensors in a list": (lambda: tank(sensors=[]), r"sensors are \[\], expected a mapping"),
    "bounds in a list": (lambda: tank(bounds=[(0, 1)]), r"bounds are \[\(0, 1\)\], expected a ma"),
    "axes in a list": (
        lambda: tank(sensors={"float": OwnSensor(lambda x: x[0], ["h"], 0.1)}),
        r"sensor float: its axes are \['h'\], expected axis → unit",
    ),
    "a rate of zero": (
        lambda: tank(sensors={"float": OwnSensor(lambda x: x[0], {"h": "m"}, 0.1, 0.0)}),
        "sensor float: its rate_hz is 0.0, expected a positive number or None",
    ),
    "a transition without u": (
        lambda: tank(transition=lambda x, w, dt: x),
        r"model tank: transition takes \(x, w, dt\), expected a function of \(x, w, dt, u\)",
    ),
    "no transition": (lambda: tank(transition=None), "transition is None, expected a function"),
    "a transition of texts": (
        lambda: tank(transition=lambda x, w, dt, u: "x"),
        r"model tank: transition is str, expected \(1, 1\) expressions",
    ),
    "a reading of too much": (
        lambda: tank(sensors={"float": OwnSensor(lambda x, u, p: x[0], {"h": "m"}, 0.1)}),
        r"sensor float: reads takes \(x, u, p\), expected a function of \(x, u\)",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_it_is_refused(case: str) -> None:
    build, sentence = REFUSED[case]
    with pytest.raises(InputError, match=sentence):
        build()


@pytest.mark.parametrize("name", LEAST_SQUARES)
def test_a_measurement_is_taken_or_refused(name: str) -> None:
    """Live: a list is a row, a number a reading of one axis."""
    model = tank()
    estimator = create_estimator(name, model, **settings_read(name, {"horizon": 2}))
    row: list[float] = [1.0, 0.1, 2.0, 0.5]
    _, listed = estimator.step(estimator.init(), Measurement(0, row))
    stacked = model.stack({"float": 1, "scale": (0.1, 2.0)}, {"flow": np.float32(0.5)})
    _, wanted = estimator.step(estimator.init(), Measurement(0.0, stacked))
    np.testing.assert_array_equal(listed.state.mean, wanted.state.mean)
    for y, sentence in (
        ([1.0, 0.1, 2.0], r"have shape \(3,\), expected \(4,\)"),
        (1.0, r"have shape \(\), expected \(4,\)"),
        ("no", "readings of a measurement: str that holds no numbers, expected"),
    ):
        with pytest.raises(InputError, match=sentence):
            estimator.step(estimator.init(), Measurement(0.0, y))
    with pytest.raises(InputError, match="time of a measurement is nan, expected a number"):
        estimator.step(estimator.init(), Measurement(np.nan, stacked))
    with pytest.raises(InputError, match="time of a measurement: str that holds no numbers"):
        Measurement("0.1", stacked)
    with pytest.raises(InputError, match=r"time of a measurement has shape \(1,\), expected one"):
        Measurement([0.1], stacked)
    with pytest.raises(InputError, match=r"sensor flaot is unknown, .*; did you mean float"):
        model.stack({"flaot": np.ones(1)})
    with pytest.raises(InputError, match=r"reading of scale has shape \(\), expected \(2,\)"):
        model.stack({"scale": 1.0})


@pytest.mark.parametrize("name", LEAST_SQUARES)
def test_a_loop_may_read_into_one_buffer(name: str) -> None:
    """What an estimator goes back to is what was measured, not what the buffer holds by then."""
    rows = [[1.0, 0.1, 2.0, 0.5], [1.1, 0.2, 2.1, 0.4], [0.9, 0.0, 1.9, 0.6], [1.0, 0.3, 2.2, 0.5]]
    times, buffer = (0.0, 0.1, 0.3, 0.2), np.empty(4)  # the last one is late

    def newest(given: Callable[[list[float]], Any]) -> Any:
        estimator = create_estimator(name, tank(), **settings_read(name, {"horizon": 5}))
        state = estimator.init()
        for time_s, row in zip(times, rows, strict=True):
            state, estimate = estimator.step(state, Measurement(time_s, given(row)))
        return estimate.state.mean

    def buffered(row: list[float]) -> Any:
        buffer[:] = row
        return buffer

    np.testing.assert_array_equal(newest(buffered), newest(list))


def test_every_estimator_takes_lists() -> None:
    given, wanted = TAKEN["lists"](), recording()
    for name in LEAST_SQUARES:
        estimator = create_estimator(name, tank(), **settings_read(name, {"horizon": 2}))
        np.testing.assert_array_equal(run(estimator, given).mean, run(estimator, wanted).mean)
