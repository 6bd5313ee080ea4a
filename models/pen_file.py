"""Pens as TOML files, and the presets that the sensors of any file may name.

A file may say with which version of pen-mhe it was written: ``pen_mhe_version = "0.2"`` at its
top. One of a later series (0.3 for 0.2, 2 for 1) is refused in a sentence before its keys are
read; without the key a file is taken as one of the version that runs.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from models.border import reading
from models.bundled import bundled_pens as bundled_pens  # people look for it here
from models.config import UnitConfig
from models.errors import InputError
from models.motion import CHAINS, keys_of_file
from models.names import did_you_mean, expected_one_of
from models.parsed import toml_data
from models.pen_config import PenConfig
from models.plain_names import with_plain_names
from models.regular_files import read_text
from models.sensor_kinds.table import SENSOR_KINDS
from models.shown_text import short, value_text
from models.version import VERSION_KEY, check_version

ConfigT = TypeVar("ConfigT", bound=UnitConfig)

AnyPen = PenConfig | str | Path
"""A pen, the name of a bundled one, or the path of a pen file."""


def pen_name(pen: AnyPen) -> str:
    """Return what a pen is called: as it says itself, or by its file."""
    return pen.name if isinstance(pen, PenConfig) else Path(pen).name


@cache
def _preset_table() -> dict[str, dict[str, Any]]:
    return tomllib.loads((resources.files("models") / "presets.toml").read_text("utf-8"))


def presets() -> dict[str, dict[str, Any]]:
    """Return the sensor presets by name: keys of a sensor in a pen file, and ``source``."""
    return {name: dict(values) for name, values in _preset_table().items()}


def parse_pen(data: dict[str, Any], where: str = "pen") -> PenConfig:
    """Validate a pen given as nested dictionaries, as in a pen file."""
    return parse_config(data, PenConfig, where)


def load_config(path: str | Path, config: type[ConfigT], what: str) -> ConfigT:
    """Read and validate a TOML file of something with sensors; see `load_pen`.

    Parameters
    ----------
    config : what to make of it; its sensors may name presets
    what : kind of the file, for messages: ``pen file``

    Raises
    ------
    InputError
        If the file is missing, is not TOML, or a key or value in it is wrong.
    """
    where, expected = f"{what} {path}", "a readable TOML file"
    with reading(where, expected):
        text = read_text(Path(path), where, expected, "toml_bytes")
        return parse_config(toml_data(text, where), config, where)


def parse_config(data: dict[str, Any], config: type[ConfigT], where: str) -> ConfigT:
    """Validate something with sensors given as nested dictionaries, presets resolved.

    Raises
    ------
    InputError
        If a key or value is wrong; the message names it.
    """
    if VERSION_KEY in data:
        check_version(data[VERSION_KEY], f"{where}: key {VERSION_KEY}")
        data = {key: value for key, value in data.items() if key != VERSION_KEY}
    sensors = data.get("sensors", {})
    if not isinstance(sensors, dict):
        raise InputError(f"{where}: key sensors: expected a table of sensors")
    with reading(where, "numbers and names as in a bundled pen"):
        sensors = with_plain_names(sensors, f"{where}: key sensors", "sensor")
        resolved = {name: _with_preset(name, sensor, where) for name, sensor in sensors.items()}
        try:
            return config.model_validate({**data, "sensors": resolved})
        except ValidationError as error:
            raise InputError(_one_sentence(error, where, data)) from None


def _with_preset(name: str, sensor: Any, where: str) -> Any:
    if not isinstance(sensor, dict) or "preset" not in sensor:
        return sensor
    preset_name = sensor["preset"]
    if not isinstance(preset_name, str) or preset_name not in _preset_table():
        raise InputError(
            f"{where}: key sensors.{name}.preset: unknown preset {short(preset_name)}; "
            f"{expected_one_of(preset_name, _preset_table())}"
        )
    preset = dict(_preset_table()[preset_name])
    preset.pop("source")
    own = {key: value for key, value in sensor.items() if key != "preset"}
    kind = SENSOR_KINDS[preset["kind"]]
    # An override may come in another unit than the preset's key.
    overridden = {field for key in own for field in [kind.field_of(key)]}
    kept = {key: value for key, value in preset.items() if kind.field_of(key) not in overridden}
    return {**kept, **own}


def first_error(error: ValidationError) -> str:
    """Return the message of the first error."""
    found = error.errors(include_url=False, include_context=False)[0]
    return found["msg"].removeprefix("Value error, ")


def _one_sentence(error: ValidationError, where: str, data: Mapping[str, Any]) -> str:
    first = error.errors(include_url=False, include_context=False)[0]
    # A discriminated union adds the kind to the location: it is not a key.
    loc = first["loc"]
    tagged = loc[:1] in (("sensors",), ("motion",))
    keys = [str(part) for i, part in enumerate(loc) if not tagged or i != 2]
    if loc[:1] == ("motion",):
        keys = keys_of_file(keys, data)
    message = "is missing" if first["type"] == "missing" else first_error(error)
    if first["type"].startswith("union_tag"):
        is_chain = loc[0] == "motion"
        tag, known = ("chain", CHAINS[str(loc[1])]) if is_chain else ("kind", tuple(SENSOR_KINDS))
        if first["type"] == "union_tag_not_found":
            keys.append(tag)
            message = f"is missing, expected one of {', '.join(known)}"
        else:
            message += did_you_mean(first["input"][tag], known)
    more = error.error_count() - 1
    rest = f" (and {more} more)" if more else ""
    return f"{where}: key {short('.'.join(keys)) or '(top level)'}: {message}{rest}"


def load_pen(pen: str | Path) -> PenConfig:
    """Read and validate a pen file, or a bundled pen by its name.

    Raises
    ------
    InputError
        If it is neither, the file is missing, is not TOML, or a key or value in it is wrong;
        the message names the file, the key and what was expected.
    """
    if not isinstance(pen, str | Path):
        raise InputError(
            f"pen is of type {type(pen).__name__}, expected a pen, the name of a bundled one or "
            "the path of a file"
        )
    path = Path(pen)
    with reading(f"pen file {value_text(str(pen))}", "a file, or a bundled pen"):
        if str(pen) in bundled_pens() and not path.is_file():
            path = bundled_pens()[str(pen)]
        elif not path.exists():
            raise InputError(
                f"pen file {pen} does not exist; expected a file, "
                f"or a bundled pen: {', '.join(bundled_pens())}{did_you_mean(pen, bundled_pens())}"
            )
        return load_config(path, PenConfig, "pen file")


def pen_paths(pen: str | Path) -> tuple[Path, ...]:
    """Return files that a command on this pen never writes: its own and the bundled ones."""
    return (Path(pen), *bundled_pens().values())


def as_pen(pen: AnyPen) -> PenConfig:
    """Return a pen as it is, or load it."""
    return pen if isinstance(pen, PenConfig) else load_pen(pen)
