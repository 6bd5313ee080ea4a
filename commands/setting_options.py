"""The settings of the estimators as options, declared once: from their config classes.

A setting that has no row in `OPTIONS` is an option all the same, named as the setting is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from types import MappingProxyType
from typing import Annotated, Any, get_type_hints

import typer

from commands.option_groups import OptionGroup, option
from commands.options import ipopt_options, thresholds
from estimation.settings import check_settings, setting_names
from mhe.arrival_cost import ARRIVAL_COSTS
from mhe.config import HESSIANS
from pen_mhe.estimators import configs

PANEL = "Settings of the estimator"
READABLE = (int, float, str)
"""What a terminal gives as it is; any other type needs a row."""


@dataclass(frozen=True, kw_only=True)
class SettingOption:
    """How a setting is written on a terminal.

    Parameters
    ----------
    help : what it does
    flag : its option; None makes one of the setting's name
    kind : what typer reads; None takes the type of the config's field
    read : makes the setting of what was read
    """

    help: str
    flag: str | None = None
    kind: Any = None
    read: Callable[[Any], Any] = lambda value: value


def _choice(name: str, among: Iterable[str]) -> Any:
    return StrEnum(name, {each: each for each in among})


OPTIONS: Mapping[str, SettingOption] = MappingProxyType(
    {
        "gate_probability": SettingOption(
            help="Readings beyond this quantile of their distance are dropped."
        ),
        "late_samples": SettingOption(
            help="Measurements back that a late one is taken at least; 0 takes none.", kind=int
        ),
        "alpha": SettingOption(help="How far the points lie: alpha √n deviations."),
        "beta": SettingOption(help="Beyond a covariance; 2 is right for a Gaussian."),
        "kappa": SettingOption(help="A second way to say how far the points lie."),
        "horizon": SettingOption(help="Intervals in the window."),
        "arrival_cost": SettingOption(
            help="What is known of the window's first state.",
            kind=_choice("ArrivalCostName", ARRIVAL_COSTS),
            read=str,
        ),
        "huber": SettingOption(
            help="Huber's loss on sensors, in deviations: accel=2,camera=3.",
            kind=str,
            read=thresholds,
        ),
        "sparse_noise": SettingOption(help="Huber's loss on the process noise, in deviations."),
        "deadline_s": SettingOption(
            help="Seconds per step, then the best so far is returned.", flag="--deadline"
        ),
        "lag_samples": SettingOption(
            help="Rows speak of so many samples before the newest that they know.",
            kind=int,
        ),
        "tolerance": SettingOption(help="Where iterating ends, in deviations."),
        "max_iterations": SettingOption(help="Of the solver, per step."),
        "reuse_threshold": SettingOption(
            help="Threshold in σ below which factors stay; 0 has none.", flag="--reuse"
        ),
        "hessian": SettingOption(
            help="Of the window's cost.", kind=_choice("HessianName", HESSIANS), read=str
        ),
        "ipopt": SettingOption(
            help="IPOPT's own options, e.g. max_iter=500, by commas.",
            kind=str,
            read=ipopt_options,
        ),
    }
)
"""Setting → its option."""


def flag_of(setting: str) -> str:
    """Return the option of a setting."""
    row = OPTIONS.get(setting)
    return row.flag if row and row.flag else f"--{setting.replace('_', '-')}"


def settings_group() -> OptionGroup:
    """Return the options of all settings of all estimators; collected are those given."""
    first: dict[str, type[Any]] = {}
    for config in configs().values():
        for name in setting_names(config):
            first.setdefault(name, config)
    rows = {name: OPTIONS.get(name, SettingOption(help="")) for name in first}
    options = [option(name, _kind(name, first[name], row), None) for name, row in rows.items()]
    return OptionGroup(
        tuple(options),
        lambda values: {
            name: rows[name].read(value) for name, value in values.items() if value is not None
        },
    )


def check_options(estimator: str, given: Iterable[str]) -> None:
    """Raise `InputError` where options were given that an estimator does not read."""
    check_settings(estimator, configs(), given, kind="option", spelled=flag_of)


def _kind(name: str, config: type[Any], row: SettingOption) -> Any:
    """Return what typer is shown of a setting."""
    [field] = [each for each in fields(config) if each.name == name]
    kind = row.kind or _readable(get_type_hints(config)[name])
    has_default = isinstance(field.default, READABLE)
    readers = [estimator for estimator, own in configs().items() if name in setting_names(own)]
    shown = typer.Option(
        flag_of(name),
        help=f"{row.help} Read by {', '.join(readers)}.".strip(),
        show_default=str(field.default) if has_default else False,
        rich_help_panel=PANEL,
    )
    return Annotated[kind | None, shown]


def _readable(hint: Any) -> Any:
    """Return the one of `READABLE` that a field may be, else text."""
    among = getattr(hint, "__args__", (hint,))
    return next((kind for kind in READABLE if kind in among), str)
