"""Which settings an estimator reads: the fields of its config class, and no others."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from typing import Any, TypeVar

from models.errors import InputError
from models.names import nearest

ConfigT = TypeVar("ConfigT")


def setting_names(config: type[Any]) -> tuple[str, ...]:
    """Return the settings that a config class has, in its order."""
    return tuple(field.name for field in fields(config))


def checked_config(estimator: str, config: ConfigT | None, expected: type[ConfigT]) -> ConfigT:
    """Return an estimator's settings; None takes the defaults.

    Raises
    ------
    InputError
        If they are another estimator's; the message names what this one does not read.
    """
    if config is None:
        return expected()
    if isinstance(config, expected):
        return config
    given, own = type(config), setting_names(expected)
    unread = [name for name in getattr(given, "__dataclass_fields__", ()) if name not in own]
    why = f", whose {_listed(unread)} it does not read" if unread else ""
    raise InputError(
        f"estimator {estimator} is given {given.__name__}{why}; expected {expected.__name__} "
        f"of {_listed(own)}"
    )


def config_of(estimator: str, configs: Mapping[str, type[Any]], settings: Mapping[str, Any]) -> Any:
    """Build an estimator's config of settings by name.

    Parameters
    ----------
    configs : estimator → config class, of all that there are

    Raises
    ------
    InputError
        If the estimator does not read one of the settings, or a value is not allowed.
    """
    check_settings(estimator, configs, settings)
    return configs[estimator](**settings)


def check_settings(
    estimator: str,
    configs: Mapping[str, type[Any]],
    names: Iterable[str],
    *,
    kind: str = "setting",
    spelled: Callable[[str], str] = str,
) -> None:
    """Raise `InputError` where an estimator does not read a setting.

    Parameters
    ----------
    configs : see `config_of`
    kind, spelled : what a setting is to whoever wrote it, and how it is written there
    """
    own = setting_names(configs[estimator])
    unread = [name for name in names if name not in own]
    if not unread:
        return
    many = len(unread) > 1
    readers = [
        other for other, config in configs.items() if set(unread) <= set(setting_names(config))
    ]
    near = None if readers else nearest(unread[0], own)
    raise InputError(
        f"{kind}{'s' if many else ''} {_listed(map(spelled, unread))} {'are' if many else 'is'} "
        f"not read by {estimator}, "
        f"expected {'one of ' if len(own) > 1 else ''}{', '.join(map(spelled, own)) or 'none'}"
        + (f"; {_listed(readers)} {_verb(readers)} {'them' if many else 'it'}" if readers else "")
        + (f"; did you mean {spelled(near)}?" if near else "")
    )


def _verb(readers: Sequence[str]) -> str:
    return "read" if len(readers) > 1 else "reads"


def _listed(names: Iterable[str]) -> str:
    """Return ``a, b and c``."""
    *first, last = tuple(names) or ("nothing",)
    return f"{', '.join(first)} and {last}" if first else last
