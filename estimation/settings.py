"""Which settings an estimator reads: the fields of its config class, and no others."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields
from typing import Any, TypeVar

from models.errors import InputError

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
    why = f", whose {_listed(unread, 'and')} it does not read" if unread else ""
    raise InputError(
        f"estimator {estimator} is given {given.__name__}{why}; expected {expected.__name__} "
        f"of {_listed(own, 'and')}"
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
    spelled: Callable[[str], str] = "setting {}".format,
) -> None:
    """Raise `InputError` for the first setting that an estimator does not read.

    Parameters
    ----------
    configs : see `config_of`
    spelled : how a person writes a setting, e.g. as the option of a command
    """
    own = setting_names(configs[estimator])
    for name in names:
        if name in own:
            continue
        expected = [spelled(each).removeprefix("setting ") for each in own]
        sentence = (
            f"{spelled(name)} is not read by {estimator}, "
            f"expected {'one of ' if len(own) > 1 else ''}{', '.join(expected)}"
        )
        readers = [other for other, kind in configs.items() if name in setting_names(kind)]
        near = difflib.get_close_matches(name, own, n=1)
        if readers:
            verb = "read" if len(readers) > 1 else "reads"
            sentence += f"; {_listed(readers, 'and')} {verb} it"
        elif near:
            sentence += f"; did you mean {near[0]}?"
        raise InputError(sentence)


def _listed(names: Iterable[str], word: str) -> str:
    """Return ``a, b and c``."""
    *first, last = names
    return f"{', '.join(first)} {word} {last}" if first else last
