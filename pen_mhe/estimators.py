"""The table of estimators that benchmark, command line and contract tests share.

An estimator exists for all of them once it has a row here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from ekf_baseline.ekf import Ekf, EkfConfig
from ekf_baseline.ukf import Ukf, UkfConfig
from estimation.estimator import Estimator
from estimation.settings import config_of, setting_names
from mhe.config import MheConfig, MheIpoptConfig, MheRtiConfig
from mhe.realtime import Mhe, MheRti
from mhe.reference.ipopt import MheIpopt
from models.errors import InputError
from models.names import unknown
from models.sensor_model import losses
from models.state_space import StateSpaceModel

SPARSE_NOISE = 1.0
"""Threshold of Huber's loss of ``mhe-sparse``: noise within its standard deviation is Gaussian."""


@dataclass(frozen=True, kw_only=True)
class EstimatorRow:
    """What everything that asks of estimators knows of one; a new question is a column.

    Parameters
    ----------
    make : what builds it of a model and its config
    config : the class of its settings; what has no field there is refused
    defaults : settings that it has unless others are given, where not the config's own
    is_least_squares : whether it then weighs everything by least squares: on a linear model
        all such are one
    in_benchmark : whether the benchmark compares it by default
    is_filter : whether a smoother may go back over its estimates, `estimation.smoother`
    """

    make: Callable[[StateSpaceModel, Any], Estimator[Any]]
    config: type[Any]
    defaults: Mapping[str, Any] = field(default_factory=dict)
    is_least_squares: bool = True
    in_benchmark: bool = True
    is_filter: bool = False


ESTIMATORS: Mapping[str, EstimatorRow] = MappingProxyType(
    {
        "ekf": EstimatorRow(make=Ekf, config=EkfConfig, is_filter=True),
        "ukf": EstimatorRow(make=Ukf, config=UkfConfig, in_benchmark=False),
        "mhe-ipopt": EstimatorRow(make=MheIpopt, config=MheIpoptConfig, in_benchmark=False),
        "mhe-rti": EstimatorRow(make=MheRti, config=MheRtiConfig),
        "mhe": EstimatorRow(make=Mhe, config=MheConfig),
        "mhe-sparse": EstimatorRow(
            make=Mhe,
            config=MheConfig,
            defaults={"sparse_noise": SPARSE_NOISE},
            is_least_squares=False,
            in_benchmark=False,
        ),
    }
)
"""Estimator name → its row."""

LEAST_SQUARES = tuple(name for name, row in ESTIMATORS.items() if row.is_least_squares)
"""The estimators that weigh everything by least squares: on a linear model all are one."""

DEFAULT_ESTIMATOR = Mhe.name


def check_estimator(name: str) -> None:
    """Raise `InputError` unless an estimator has this name."""
    if name not in ESTIMATORS:
        raise unknown("estimator", name, ESTIMATORS)


def check_filter(name: str) -> None:
    """Raise `InputError` unless an estimator is a filter, whose estimates can be smoothed."""
    check_estimator(name)
    if not ESTIMATORS[name].is_filter:
        filters = ", ".join(each for each, row in ESTIMATORS.items() if row.is_filter)
        raise InputError(
            f"smoothing goes back over a filter's estimates and {name} is none, expected "
            f"{filters}; others have lag_samples"
        )


def configs() -> Mapping[str, type[Any]]:
    """Return estimator name → config class."""
    return {name: row.config for name, row in ESTIMATORS.items()}


def settings_of(name: str) -> tuple[str, ...]:
    """Return the settings that an estimator reads; raises `InputError` for an unknown one."""
    check_estimator(name)
    return setting_names(ESTIMATORS[name].config)


def settings_read(name: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return what an estimator reads of settings that several are given.

    Raises
    ------
    InputError
        If no estimator has the name, or a setting is read by none at all.
    """
    own = settings_of(name)
    known = {each for config in configs().values() for each in setting_names(config)}
    for each in settings:
        if each not in known:
            raise InputError(
                f"setting {each} is read by no estimator, expected one of "
                f"{', '.join(sorted(known))}"
            )
    return {each: value for each, value in settings.items() if each in own}


def with_losses(
    name: str, model: StateSpaceModel, settings: Mapping[str, Any], **defaults: Any
) -> dict[str, Any]:
    """Return settings of an estimator with what the model's sensors say of their outliers.

    Parameters
    ----------
    settings : given ones win: ``huber={}`` is least squares, whatever the sensors say
    defaults : what the estimator has unless others are given; the sensors' come behind them
    """
    said = settings_read(name, losses(model.sensors))
    return {**said, **defaults, **settings}


def create_estimator(name: str, model: StateSpaceModel, **settings: Any) -> Estimator[Any]:
    """Build an estimator by name.

    Parameters
    ----------
    settings : of `settings_of`, by keyword; the rest takes the losses and gates of the model's
        sensors (`models.sensor_model.losses`), and its defaults

    Raises
    ------
    InputError
        If no estimator has the name, it is given no model, it does not read a setting, or a value
        is not allowed.
    """
    check_estimator(name)
    if not isinstance(model, StateSpaceModel):
        raise InputError(
            f"estimator {name} is given a {type(model).__name__}, expected a model, as of "
            "pen_model or own_model"
        )
    row = ESTIMATORS[name]
    chosen = with_losses(name, model, settings, **row.defaults)
    return row.make(model, config_of(name, configs(), chosen))
