"""What every configuration shares: frozen, strict, units in the key names."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, model_validator

from models.names import expected_one_of
from models.plain_names import check_text
from models.shown_text import short, value_text
from models.units import accepted_names, split_unit


def _checked_title(text: str) -> str:
    check_text(text, "a name for people")
    return text


Title = Annotated[str, AfterValidator(_checked_title)]
"""A name for people: one printable line, in any script."""


class UnitConfig(BaseModel):
    """A frozen configuration whose keys carry their unit.

    A field named in SI (``range_m_s2``) is accepted in every unit of
    `models.units.UNITS` (``range_g``) and stored in SI. Unknown keys are
    refused, with the accepted spellings where only the unit is unknown.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _to_si(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        spellings = _spellings(cls)
        converted: dict[str, Any] = {}
        for key, value in data.items():
            if key not in spellings:
                raise ValueError(_unknown_key(key, cls))
            field, factor = spellings[key]
            if field in converted:
                raise ValueError(f"{key} gives {field} a second time")
            converted[field] = value if factor == 1.0 else _scaled(value, factor)
        return converted

    @classmethod
    def field_of(cls, key: str) -> str:
        """Return the field that a key sets, whatever its unit; the key itself if none."""
        return _spellings(cls).get(key, (key, 1.0))[0]


@cache
def _spellings(config: type[UnitConfig]) -> Mapping[str, tuple[str, float]]:
    """Return accepted key → its field, and its factor to SI."""
    return MappingProxyType(
        {
            spelling: (field, factor)
            for field in config.model_fields
            for spelling, factor in accepted_names(field).items()
        }
    )


def _scaled(value: Any, factor: float) -> Any:
    if isinstance(value, int | float) and not isinstance(value, bool):
        return value * factor
    if isinstance(value, list | tuple):
        return [_scaled(item, factor) for item in value]
    if value is None:
        return None
    raise ValueError(f"expected a number, got {value_text(value)}")


def _unknown_key(key: str, config: type[BaseModel]) -> str:
    by_stem = sorted(config.model_fields, key=lambda name: len(split_unit(name)[0]), reverse=True)
    for field in by_stem:
        stem, unit = split_unit(field)
        if unit and key.startswith(stem + "_"):
            return f"unknown key {short(key)}; expected {' or '.join(accepted_names(field))}"
    return f"unknown key {short(key)}; {expected_one_of(key, sorted(config.model_fields))}"
