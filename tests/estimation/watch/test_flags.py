"""Flags of sensors: their words, and what becomes of them in estimates, histories and tables."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence

import numpy as np
import pytest

from ekf_baseline.ekf import Ekf
from estimation.collect import BATCH_STEPS
from estimation.estimate import Estimate
from estimation.estimator import run_measurements
from estimation.history import EstimateHistory
from estimation.recording import Measurement
from estimation.watch.flags import Flag, Flags, label, labels
from models.state_space import StateSpaceModel
from tests.linear_models import constant_acceleration_system

pytestmark = pytest.mark.usefixtures("interpreted")

SYSTEM = constant_acceleration_system(2)
NAMES = tuple(sensor.name for sensor in SYSTEM.model.sensors)
N = 12


def from_label(text: str, sensor_names: Sequence[str]) -> list[int]:
    flags = [0] * len(sensor_names)
    for part in filter(None, text.split("+")):
        name, word = part.split(":")
        flags[sensor_names.index(name)] |= Flag[word.upper()]
    return flags


def mask_of(step: int) -> Flags:
    """Every combination of flags in turn."""
    return np.array([(step + 5 * i) % 16 for i in range(len(NAMES))], dtype=np.uint8)


class Flagging:
    """A filter whose steps flag sensors by their number."""

    def __init__(self) -> None:
        self._filter = Ekf(SYSTEM.model)

    @property
    def name(self) -> str:
        return "flagging"

    @property
    def model(self) -> StateSpaceModel:
        return SYSTEM.model

    def init(self, prior: object = None) -> tuple[int, object]:
        return 0, self._filter.init()

    def step(
        self, state: tuple[int, object], measurement: Measurement
    ) -> tuple[tuple[int, object], Estimate]:
        k, of_filter = state
        of_filter, estimate = self._filter.step(of_filter, measurement)  # type: ignore[arg-type]
        return (k + 1, of_filter), dataclasses.replace(estimate, flagged=mask_of(k))


def flagged_history(n: int = N) -> EstimateHistory:
    measurements = SYSTEM.simulate(0.02 * np.arange(n), np.random.default_rng(8))
    return run_measurements(Flagging(), measurements, covariances=True)


def test_a_flag_is_a_bit_that_c_knows() -> None:
    assert {flag.name: flag.value for flag in Flag} == {
        "STUCK": 1,
        "OUTLIER": 2,
        "INCONSISTENT": 4,
        "LEFT_OUT": 8,
    }


def test_a_label_says_what_of_whom_and_leads_back() -> None:
    names = ("accel", "gyro", "camera")
    assert label((Flag.STUCK, 0, Flag.OUTLIER), names) == "accel:stuck+camera:outlier"
    assert label((0, 0, 0), names) == ""
    assert label((0, 9, 0), names) == "gyro:stuck+gyro:left_out"
    for flags in itertools.product(range(16), repeat=2):
        assert from_label(label(flags, names[:2]), names[:2]) == list(flags)
    with pytest.raises(ValueError, match="zip"):
        label((0, 0), names)


def test_many_steps_have_the_labels_of_each() -> None:
    flagged = np.array([mask_of(k) for k in range(40)])
    assert labels(flagged, NAMES) == [label(flags, NAMES) for flags in flagged]
    assert labels(flagged[:0], NAMES) == []


def test_a_history_has_the_flags_of_its_steps() -> None:
    history = flagged_history()
    assert history.sensor_names == NAMES
    assert history.flagged.dtype == np.uint8
    np.testing.assert_array_equal(history.flagged, [mask_of(k) for k in range(N)])


def test_flags_go_with_their_rows() -> None:
    history = flagged_history(BATCH_STEPS + 3)
    n = len(history)
    np.testing.assert_array_equal(history.flagged, [mask_of(k) for k in range(n)])
    chosen = np.array([7, 2, n - 1])
    np.testing.assert_array_equal(history[chosen].flagged, history.flagged[chosen])
    np.testing.assert_array_equal(
        history.at(history.time_s[chosen]).flagged, history.flagged[chosen]
    )
    between = history.between(history.time_s[3], history.time_s[8])
    np.testing.assert_array_equal(between.flagged, history.flagged[3:9])
    joined = EstimateHistory.joined([history[:5], history[5:]], n)
    np.testing.assert_array_equal(joined.flagged, history.flagged)
    assert joined.sensor_names == NAMES
    assert joined.flagged.dtype == np.uint8


def test_a_table_has_a_column_of_flags_behind_the_status() -> None:
    history = flagged_history()
    table = history.to_pandas()
    assert list(table.columns)[-4:] == ["status", "flagged", "iterations", "step_time_s"]
    assert list(table["flagged"]) == [label(mask_of(k), NAMES) for k in range(N)]
    assert list(history[:0].to_pandas()["flagged"]) == []


def test_where_nobody_watched_nothing_is_flagged() -> None:
    measurements = SYSTEM.simulate(0.02 * np.arange(N), np.random.default_rng(8))
    history = run_measurements(Ekf(SYSTEM.model), measurements)
    assert history.sensor_names == ()
    assert history.flagged.shape == (N, 0)
    assert history[2:5].flagged.shape == (3, 0)
    assert "flagged" not in history.to_pandas()
    ekf = Ekf(SYSTEM.model)
    _, estimate = ekf.step(ekf.init(), measurements[0])
    assert not estimate.flagged.any()
    assert not estimate.flagged.flags.writeable, "one array for all that nobody watched"
