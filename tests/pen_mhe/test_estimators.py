"""Each estimator takes what it reads, and refuses the rest by name."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import FrozenInstanceError, replace
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

from ekf_baseline.ekf import Ekf, EkfConfig
from estimation.estimator import run_measurements
from mhe.config import MheConfig, MheIpoptConfig, MheRtiConfig, WindowConfig
from mhe.realtime import Mhe, MheRti
from mhe.reference.ipopt import MheIpopt
from models.errors import InputError
from pen_mhe.estimators import (
    DEFAULT_ESTIMATOR,
    ESTIMATORS,
    LEAST_SQUARES,
    EstimatorRow,
    create_estimator,
    settings_of,
    settings_read,
)
from tests.mhe import pendulum

pytestmark = pytest.mark.usefixtures("interpreted")

MODEL, MEASUREMENTS = pendulum.model(), pendulum.simulate(15, 1)
WINDOW = ("horizon", "arrival_cost", "huber", "sparse_noise", "deadline_s", "lag_samples")
READ: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "ekf": ("gate_probability", "late_samples", "huber"),
        "ukf": ("alpha", "beta", "kappa", "late_samples"),
        "mhe-ipopt": (*WINDOW, "tolerance", "max_iterations", "hessian", "ipopt"),
        "mhe-rti": (*WINDOW, "reuse_threshold"),
        "mhe": (*WINDOW, "tolerance", "max_iterations"),
        "mhe-sparse": (*WINDOW, "tolerance", "max_iterations"),
    }
)
OTHER: Mapping[str, Any] = MappingProxyType(
    {
        "gate_probability": 0.3,
        "alpha": 0.5,
        "beta": 1.0,
        "kappa": 1.0,
        "late_samples": 0,
        "horizon": 2,
        "arrival_cost": "constant",
        "huber": {"level": 0.5},
        "sparse_noise": 0.2,
        "deadline_s": 1e-9,
        "lag_samples": 2,
        "tolerance": 1.0,
        "max_iterations": 1,
        "hessian": "exact",
        "ipopt": {"max_iter": 1},
        "reuse_threshold": 20.0,
    }
)
"""Setting → a value that is not its default and does something here."""
BASE: Mapping[str, Any] = MappingProxyType({"horizon": 4, "reuse_threshold": 0.0})


def outcome(estimator: str, **settings: Any) -> list[np.ndarray]:
    """Return what an estimator says of the measurements and a late one: estimates, passes, …"""
    built = create_estimator(estimator, MODEL, **{**settings_read(estimator, BASE), **settings})
    history = run_measurements(built, [*MEASUREMENTS, MEASUREMENTS[-3]], covariances=True)
    statuses = np.array([status.value for status in history.status])
    lags = np.array(list(history.lagged))
    return [history.mean, history.covariance, history.iterations, statuses, lags]


def is_same(one: list[np.ndarray], other: list[np.ndarray]) -> bool:
    return all(np.array_equal(a, b, equal_nan=True) for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_every_setting_does_something(estimator: str) -> None:
    plain = outcome(estimator)
    assert is_same(plain, outcome(estimator))
    for name in settings_of(estimator):
        assert not is_same(plain, outcome(estimator, **{name: OTHER[name]})), name


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_what_is_read_is_what_the_config_has(estimator: str) -> None:
    assert settings_of(estimator) == READ[estimator]
    for name in OTHER:
        if name in READ[estimator]:
            create_estimator(estimator, MODEL, **{name: OTHER[name]})
        else:
            with pytest.raises(InputError, match=f"setting {name} is not read by {estimator}, exp"):
                create_estimator(estimator, MODEL, **{name: OTHER[name]})


SENTENCES: Mapping[str, tuple[str, dict[str, Any], str]] = MappingProxyType(
    {
        "others read it": (
            "ekf",
            {"horizon": 7},
            "setting horizon is not read by ekf, expected one of gate_probability, late_samples, "
            "huber; "
            "mhe-ipopt, mhe-rti, mhe and mhe-sparse read it",
        ),
        "another reads it": (
            "mhe",
            {"reuse_threshold": 0.0},
            "setting reuse_threshold is not read by mhe, expected one of horizon, arrival_cost, "
            "huber, sparse_noise, deadline_s, lag_samples, tolerance, max_iterations; "
            "mhe-rti reads it",
        ),
        "misspelt": (
            "mhe-rti",
            {"horizn": 7},
            "setting horizn is not read by mhe-rti, expected one of horizon, arrival_cost, huber, "
            "sparse_noise, deadline_s, lag_samples, reuse_threshold; did you mean horizon?",
        ),
        "several": (
            "ekf",
            {"sparse_noise": 2.0, "horizon": 7},
            "settings sparse_noise and horizon are not read by ekf, expected one of "
            "gate_probability, late_samples, huber; "
            "mhe-ipopt, mhe-rti, mhe and mhe-sparse read them",
        ),
        "nobody's": (
            "ekf",
            {"colour": "red"},
            "setting colour is not read by ekf, expected one of gate_probability, late_samples, "
            "huber",
        ),
        "unknown estimator": (
            "eks",
            {},
            "estimator eks is unknown, expected one of ekf, ukf, mhe-ipopt, mhe-rti, mhe, "
            "mhe-sparse; did you mean ekf?",
        ),
    }
)


TEXTS = [
    ("mhe", "deadline_s"),
    ("mhe", "tolerance"),
    ("mhe", "sparse_noise"),
    ("mhe-rti", "reuse_threshold"),
    ("ekf", "late_samples"),
    ("ekf", "gate_probability"),
    ("ukf", "alpha"),
    ("ukf", "beta"),
    ("ukf", "kappa"),
]


@pytest.mark.parametrize("value", ["0.5", True])
@pytest.mark.parametrize(("estimator", "setting"), TEXTS)
def test_what_is_no_number_is_refused(estimator: str, setting: str, value: object) -> None:
    with pytest.raises(InputError, match=re.escape(repr(value))):
        create_estimator(estimator, MODEL, **{setting: value})


def test_what_is_no_model_is_refused() -> None:
    with pytest.raises(InputError, match="ekf is given a str, expected a model, as of pen_model"):
        create_estimator("ekf", "reference")  # type: ignore[arg-type]


@pytest.mark.parametrize("case", SENTENCES)
def test_the_sentence(case: str) -> None:
    estimator, settings, sentence = SENTENCES[case]
    with pytest.raises(InputError) as refusal:
        create_estimator(estimator, MODEL, **settings)
    assert str(refusal.value) == sentence


@pytest.mark.parametrize(
    ("build", "config", "sentence"),
    [
        (Ekf, MheConfig(), "ekf is given MheConfig, whose horizon, arrival_cost,.* read; .*EkfCon"),
        (Mhe, MheRtiConfig(), "mhe is given MheRtiConfig, whose reuse_threshold it does not read"),
        (Mhe, MheIpoptConfig(), "whose hessian and ipopt it does not read; expected MheConfig"),
        (MheRti, MheConfig(), "whose tolerance and max_iterations it does not read"),
        (
            MheRti,
            EkfConfig(),
            "whose gate_probability and late_samples it does not read; expected MheRtiConfig",
        ),
        (MheIpopt, MheConfig(), "mhe-ipopt is given MheConfig; expected MheIpoptConfig of"),
        (Mhe, WindowConfig(), "mhe is given WindowConfig; expected MheConfig of"),
        (Mhe, {"horizon": 3}, "mhe is given dict; expected MheConfig of"),
    ],
)
def test_another_ones_config_is_refused(build: Any, config: Any, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        build(MODEL, config)


@pytest.mark.parametrize("config", dict.fromkeys(row.config for row in ESTIMATORS.values()))
def test_configs_are_frozen_and_by_keyword_only(config: Any) -> None:
    with pytest.raises(TypeError, match="positional argument"):
        config(5)
    with pytest.raises(FrozenInstanceError):
        config().horizon = 3


def test_settings_for_several_go_to_those_who_read_them() -> None:
    settings = {"horizon": 3, "gate_probability": 0.9, "tolerance": 1e-3}
    assert settings_read("ekf", settings) == {"gate_probability": 0.9}
    assert settings_read("mhe-rti", settings) == {"horizon": 3}
    with pytest.raises(InputError, match="setting horizn is read by no estimator, expected one of"):
        settings_read("ekf", {"horizn": 3})


def test_what_derives_from_the_table() -> None:
    assert LEAST_SQUARES == ("ekf", "ukf", "mhe-ipopt", "mhe-rti", "mhe")
    assert DEFAULT_ESTIMATOR == "mhe"
    sparse: Any = create_estimator("mhe-sparse", MODEL)
    assert sparse.config == replace(MheConfig(), sparse_noise=1.0)
    other: Any = create_estimator("mhe-sparse", MODEL, sparse_noise=0.5)
    assert other.config.sparse_noise == 0.5


def test_a_row_is_an_estimator(monkeypatch: pytest.MonkeyPatch) -> None:
    def gated(model: Any, config: EkfConfig) -> Ekf:
        return Ekf(model, config)

    row = EstimatorRow(make=gated, config=EkfConfig, defaults={"gate_probability": 0.9})
    monkeypatch.setattr("pen_mhe.estimators.ESTIMATORS", {**ESTIMATORS, "gated": row})
    built: Any = create_estimator("gated", MODEL)
    assert built.config == EkfConfig(gate_probability=0.9)
    with pytest.raises(InputError, match="setting horizon is not read by gated"):
        create_estimator("gated", MODEL, horizon=3)
    with pytest.raises(InputError, match="; ekf and gated read it"):
        create_estimator("mhe", MODEL, gate_probability=0.5)
