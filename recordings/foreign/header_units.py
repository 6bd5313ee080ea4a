"""Units as people write them in headers: ``Acceleration x (m/s^2)``, ``Drehrate X [°/s]``."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from models.units import STANDARD_GRAVITY_M_S2, UNITS


@dataclass(frozen=True)
class Unit:
    """A unit of a column.

    Parameters
    ----------
    name : as in `models.units.UNITS` where it stands there
    si : the SI unit of its quantity, a key of `models.units.UNITS`; empty for counts
    factor : from the unit to SI; NaN for counts
    """

    name: str
    si: str
    factor: float


_G, _DEG = STANDARD_GRAVITY_M_S2, math.pi / 180
COUNTS = Unit("counts", "", math.nan)

_MORE = (
    Unit("cm_s2", "m_s2", 1e-2),
    Unit("mm_s2", "m_s2", 1e-3),
    Unit("mdeg_s", "rad_s", 1e-3 * _DEG),
    Unit("mrad_s", "rad_s", 1e-3),
    Unit("rev_s", "rad_s", 2 * math.pi),
    Unit("rpm", "rad_s", 2 * math.pi / 60),
    Unit("ns", "s", 1e-9),
    Unit("100ns", "s", 1e-7),
    Unit("100us", "s", 1e-4),
    COUNTS,
)
KNOWN_UNITS: Mapping[str, Unit] = MappingProxyType(
    {
        unit.name: unit
        for si in ("m", "m_s2", "rad", "rad_s", "s", "ut")
        for unit in (Unit(name, si, factor) for name, factor in UNITS[si].items())
    }
    | {unit.name: unit for unit in _MORE}
)
"""Name → unit of what inertial sensors, cameras, magnetometers and clocks read."""

_SPELLINGS: Mapping[str, str] = MappingProxyType(
    {
        "m_s2": "m/s2 m/s/s ms-2 mps2 mpss m_s2 m_s_2 m_s_s m/ss ms2 meters/s2 metre/s2 m/sec2",
        "g": "g gs g's gforce g-force gn",
        "mg": "mg milli-g millig mgs milligs",
        "cm_s2": "cm/s2 cm_s2 gal cms-2",
        "mm_s2": "mm/s2 mm_s2 mms-2",
        "rad_s": "rad/s rad_s rads rads-1 radps rps radian/s radians/s rad/sec",
        "deg_s": "deg/s deg_s degs degs-1 dps degree/s degrees/s deg/sec grad/s d/s "
        "degree/second degrees/second",
        "mdeg_s": "mdps mdeg/s mdeg_s millideg/s",
        "mrad_s": "mrad/s mrad_s",
        "rpm": "rpm 1/min",
        "s": "s sec secs second seconds sek sekunden",
        "ms": "ms msec msecs millisecond milliseconds millis millisec",
        "us": "us usec usecs microsecond microseconds micros microsec",
        "ns": "ns nsec nsecs nanosecond nanoseconds nanos nanosec",
        "100ns": "100ns 100nsec hns ticks100ns",
        "m": "m meter meters metre metres",
        "cm": "cm",
        "mm": "mm",
        "rad": "rad radian radians",
        "deg": "deg degree degrees",
        "t": "tesla",
        "ut": "ut microtesla utesla",
        "mt": "mt millitesla",
        "nt": "nt nanotesla",
        "gauss": "gauss ga gs",
        "mgauss": "mgauss mgs milligauss mga",
        "counts": "lsb lsbs raw count counts digits",
    }
)
_BY_SPELLING: Mapping[str, str] = MappingProxyType(
    {word: name for name, words in reversed(list(_SPELLINGS.items())) for word in words.split()}
)
_ONLY_IN_BRACKETS: Mapping[str, str] = MappingProxyType({"T": "t"})
"""A word of its own is a name for times."""
_CHARACTERS = str.maketrans("²µμ−⁻¹", "2uu--1", ".·*^ ()")
_DEGREES = str.maketrans({"°": "deg", "º": "deg", "˚": "deg"})
_BRACKETS = re.compile(r"\[([^\[\]]*)\]|\(((?:[^()]|\([^()]*\))*)\)|\s[iI]n\s+(\S+)\s*$")
_ENDS_IN_BRACKETS = re.compile(r"[\])]\s*$")
_LONGEST_SUFFIX = 3
"""Words of a unit at a header's end: ``m s 2``."""
ELSEWHERE: Mapping[str, str] = MappingProxyType(
    {
        "线性加速度": "linear acceleration", "線形加速度": "linear acceleration",
        "重力加速度": "gravity", "加速度": "acceleration", "角速度": "angular velocity",
        "陀螺仪": "gyroscope", "磁场": "magnetic field", "地磁": "magnetic", "磁気": "magnetic",
        "时间": "time", "時間": "time", "時刻": "time", "가속도": "acceleration",
        "각속도": "angular velocity", "자이로": "gyroscope", "지자기": "magnetic", "시간": "time",
        "ω": "omega",
    }
)  # fmt: skip
"""Words without Latin letters, longer ones first → those that `recordings.foreign.column_names`
knows."""
_G_FORCE = re.compile(r"\bgF(?=[xyz]\b)")


def spelt_words(text: str) -> frozenset[str]:
    """Return the words of a text, as a table of words stands in a file."""
    return frozenset(text.split())


def unit_of(text: str) -> Unit | None:
    """Return the unit that a text spells; None where it spells none."""
    plain = text.strip().casefold().translate(_CHARACTERS).translate(_DEGREES)
    name = _BY_SPELLING.get(plain)
    return None if name is None else KNOWN_UNITS[name]


def split_header(header: str) -> tuple[str, Unit | None]:
    """Split ``Drehrate X [°/s]`` into ``("Drehrate X", deg_s)``; None where no unit is written.

    Without brackets a unit is what the last words spell: ``gyro_x_deg_s``, ``time_ms``. A word
    alone is a name: ``g``, ``ms``. Of an unknown unit in brackets no part is one: ``mag (kGa)``.
    """
    for found in _BRACKETS.finditer(header):
        written = next(part for part in found.groups() if part is not None).strip()
        unit = KNOWN_UNITS.get(_ONLY_IN_BRACKETS.get(written, "")) or unit_of(written)
        if unit is not None:
            return (header[: found.start()] + " " + header[found.end() :]).strip(), unit
    if _ENDS_IN_BRACKETS.search(header):
        return header, None
    words = words_of(header)
    for n in range(min(_LONGEST_SUFFIX, len(words) - 1), 0, -1):
        unit = unit_of("_".join(words[-n:])) or unit_of("".join(words[-n:]))
        if unit is not None:
            return " ".join(words[:-n]), unit
    return header, None


def words_of(header: str) -> list[str]:
    """Return the words of a header in small letters: ``motionRotationRateX`` → motion rotation …"""
    text = _G_FORCE.sub("gforce ", header)
    text = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", text)
    if not text.isascii():
        for word, ours in ELSEWHERE.items():
            text = text.replace(word, f" {ours} ")
    text = text.translate(_DEGREES).translate(str.maketrans("²µμ", "2uu")).casefold()
    text = text.translate(str.maketrans("äöüéèêàáíóúñçâ", "aoueeeaaiounca"))
    return re.findall(r"[a-z]+\d*|\d+", text)
