"""The estimators that can be exported as C: their loops and the states that they start from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from codegen.watching import WatchInC, watched_loop
from ekf_baseline.ekf import EkfConfig, filter_loop
from ekf_baseline.state import first_filter, kept_for
from estimation.loop import Loop
from estimation.settings import config_of, setting_names
from mhe.compiled.loop import window_loop
from mhe.config import MheRtiConfig
from mhe.window_memory import first_window, window_memory
from models.arrays import Array
from models.errors import InputError
from models.names import expected_one_of
from models.sensor_model import losses
from models.state_space import StateSpaceModel


@dataclass(frozen=True, eq=False)
class Exportable:
    """An estimator as C needs it: its loop, and its flat state before the first measurement.

    Parameters
    ----------
    watch : what a watch of its sensors remembers; None for an export without one
    """

    model: StateSpaceModel
    estimator: str
    loop: Loop
    start: Array
    watch: WatchInC | None = None


def _ekf(model: StateSpaceModel, config: EkfConfig) -> tuple[Loop, Array]:
    start = first_filter(model, kept_for(model, config.late_samples), None)
    return filter_loop(model, config), start.memory


def _mhe_rti(model: StateSpaceModel, config: MheRtiConfig) -> tuple[Loop, Array]:
    memory = window_memory(model, config.horizon + 1)
    loop = window_loop(model, config, memory, whole=False)
    return loop, first_window(model, config, memory, None).memory


EXPORTABLE: Mapping[str, tuple[type, Callable[[StateSpaceModel, Any], tuple[Loop, Array]]]] = (
    MappingProxyType({"ekf": (EkfConfig, _ekf), "mhe-rti": (MheRtiConfig, _mhe_rti)})
)
"""Estimator name → type of its settings, and what makes its loop and first state of them."""

DEFAULT_EXPORT = "mhe-rti"


def is_timed(exported: Exportable) -> bool:
    """Return whether it has a deadline, and needs a clock."""
    return bool(np.isfinite(exported.loop.fields.get("deadline", np.inf)))


def exportable(
    estimator: str, model: StateSpaceModel, *, watch: bool = False, **settings: Any
) -> Exportable:
    """Return an estimator's loop for a model.

    Parameters
    ----------
    estimator : one of `EXPORTABLE`
    watch : whether it watches its sensors, see `codegen.watching`
    settings : of its config class, the rest takes the losses and gates of the model's sensors
        (`models.sensor_model.losses`), and the defaults

    Raises
    ------
    InputError
        If there is no C export of the estimator, it does not read a setting, or no
        sensor has readings of its own.
    """
    if not model.measured_sensors:
        raise InputError(
            f"sensors {', '.join(s.name for s in model.sensors)} have no readings of their own, "
            "expected at least one that has"
        )
    if estimator not in EXPORTABLE:
        raise InputError(
            f"estimator {estimator} cannot be exported as C, "
            f"{expected_one_of(estimator, EXPORTABLE)}"
        )
    configs = {name: kind for name, (kind, _) in EXPORTABLE.items()}
    make = EXPORTABLE[estimator][1]
    own = setting_names(configs[estimator])
    said = {name: by for name, by in losses(model.sensors).items() if name in own}
    loop, start = make(model, config_of(estimator, configs, {**said, **settings}))
    if not watch:
        return Exportable(model, estimator, loop, start)
    loop, watched = watched_loop(model, loop)
    return Exportable(model, estimator, loop, start, watched)
