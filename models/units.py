"""Units as a table: a key or a column header ends in its unit.

Inside the project everything is SI and radians, a magnetic field in µT, which keeps its numbers
near one. At the border a quantity may come in any unit of its row here; its name says which
(``range_g``).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType

STANDARD_GRAVITY_M_S2 = 9.80665
_DEG = math.pi / 180
_G = STANDARD_GRAVITY_M_S2

TIME_DIGITS = 9
"""Time stamps are compared to a nanosecond."""

UNITS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
        "m_s": {"m_s": 1.0, "mm_s": 1e-3},
        "m_s2": {"m_s2": 1.0, "g": _G, "mg": 1e-3 * _G},
        "rad": {"rad": 1.0, "deg": _DEG},
        "rad_s": {"rad_s": 1.0, "deg_s": _DEG},
        "rad_s2": {"rad_s2": 1.0, "deg_s2": _DEG},
        "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6},
        "hz": {"hz": 1.0, "khz": 1e3},
        "ut": {"ut": 1.0, "t": 1e6, "mt": 1e3, "nt": 1e-3, "gauss": 1e2, "mgauss": 0.1},
        "m_s2_per_sqrt_hz": {"m_s2_per_sqrt_hz": 1.0, "ug_per_sqrt_hz": 1e-6 * _G},
        "rad_s_per_sqrt_hz": {
            "rad_s_per_sqrt_hz": 1.0,
            "deg_s_per_sqrt_hz": _DEG,
            "mdeg_s_per_sqrt_hz": 1e-3 * _DEG,
        },
        "m_s2_per_sqrt_s": {"m_s2_per_sqrt_s": 1.0, "mg_per_sqrt_s": 1e-3 * _G},
        "rad_s_per_sqrt_s": {"rad_s_per_sqrt_s": 1.0, "deg_s_per_sqrt_s": _DEG},
        "ut_per_sqrt_s": {"ut_per_sqrt_s": 1.0, "mgauss_per_sqrt_s": 0.1},
        "m_s3_per_sqrt_hz": {"m_s3_per_sqrt_hz": 1.0},
        "rad_s3_per_sqrt_hz": {"rad_s3_per_sqrt_hz": 1.0, "deg_s3_per_sqrt_hz": _DEG},
    }
)
"""SI unit → the units accepted in its place, each with the factor to SI."""

_READABLE: Mapping[str, str] = MappingProxyType({"ut": "µT"})


@lru_cache(maxsize=1024)
def split_unit(name: str) -> tuple[str, str]:
    """Split ``range_m_s2`` into ``("range", "m_s2")``; the longest SI unit wins.

    A name that ends in no known SI unit comes back whole, with ``""``.
    """
    for unit in sorted(UNITS, key=len, reverse=True):
        if name.endswith("_" + unit):
            return name[: -len(unit) - 1], unit
    return name, ""


def readable_unit(unit: str) -> str:
    """Write a unit of `UNITS` as people do: ``m_s2`` → ``m/s²``, ``ut`` → ``µT``."""
    stem, _, per = unit.partition("_")
    stem = _READABLE.get(stem, stem)
    return f"{stem}/{per.replace('2', '²')}" if per in ("s", "s2") else stem if not per else unit


def plain_unit(unit: str) -> str:
    """Return the unit of `UNITS` that people write so (``m/s`` → ``m_s``), else the unit itself."""
    return next((si for si in UNITS if unit in (si, readable_unit(si))), unit)


def accepted_units(unit: str) -> Mapping[str, float]:
    """Return the units that may stand in a unit's place, with factors; any other is alone."""
    return UNITS.get(unit, {unit: 1.0})


def with_unit(quantity: str, unit: str) -> str:
    """Return the name of a quantity with its unit: ``accel_x_m_s2``."""
    return f"{quantity}_{unit}" if unit else quantity


def unit_ending(name: str) -> str:
    """Return the SI unit that a name ends in, as people write it; nothing where there is none."""
    return readable_unit(split_unit(name)[1])


def shown(name: str, unit: str | None = None) -> tuple[str, str, float]:
    """Return how to show a quantity: its words, its unit, and the factor from SI to that unit.

    ``azimuth_rate_rad_s`` → ``("azimuth rate", "deg/s", 180 / π)``: angles are in degrees.

    Parameters
    ----------
    name : of the quantity
    unit : as people write it; none is ``""`` or ``"1"``. None is the SI unit that the name ends in
    """
    stem, suffix = split_unit(name)
    readable = readable_unit(suffix)
    if unit is not None and unit != readable:
        stem, readable = name, "" if unit == "1" else unit
    is_angle = readable.replace("/", "_").partition("_")[0] == "rad"
    return (
        stem.replace("_", " "),
        readable.replace("rad", "deg", 1) if is_angle else readable,
        1 / _DEG if is_angle else 1.0,
    )


def accepted_names(si_name: str) -> Mapping[str, float]:
    """Return every accepted spelling of an SI name, with its factor to SI.

    ``range_m_s2`` → ``{"range_m_s2": 1, "range_g": 9.80665, "range_mg": …}``.
    """
    stem, unit = split_unit(si_name)
    if not unit:
        return {si_name: 1.0}
    return {f"{stem}_{alternative}": factor for alternative, factor in UNITS[unit].items()}
