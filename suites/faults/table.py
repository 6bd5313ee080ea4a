"""The faults of ``faults.toml`` and ``beyond.toml``, one `Fault` for each cell of a table."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

from models.names import unknown
from models.parsed import toml_data

FILE, BEYOND = (Path(__file__).with_name(f"{name}.toml") for name in ("faults", "beyond"))
"""What claims are about, and what nothing was made for."""
INSTANT_S = 1e-9
"""By which stamps may differ that are one."""
SIZES: Mapping[str, tuple[str, float]] = MappingProxyType(
    {
        "m_s2": ("m/s²", 1.0),
        "rad_s": ("rad/s", 1.0),
        "deg_s": ("deg/s", math.pi / 180),
        "ms": ("ms", 1e-3),
        "": ("", 1.0),
    }
)
"""End of a target's key → unit for people, factor to SI."""


@dataclass(frozen=True)
class Fault:
    """What happens to some readings or stamps, and when.

    Parameters
    ----------
    key : for tables: ``dropout, imu, 0.5 s``; unique
    name : of its row in the file
    does : what does it, of `suites.faults.inject.INJECTIONS`
    of : a target of `suites.faults.protocol.TARGETS`
    at_s, end_s : from when until when, s; it stays where the end is infinite
    duration_s : of the recording
    size : in SI, or a factor or share; NaN where it has none
    axis : that is hit, where only one is
    turn_rad : by which poses are turned away
    share : of the poses that are hit
    spikes, apart_s : how many, and how far apart; of a vibration its period
    needs : further targets without which it is no fault
    """

    key: str
    name: str
    does: str
    of: str
    at_s: float
    end_s: float
    duration_s: float
    size: float = math.nan
    axis: int = 0
    turn_rad: float = 0.0
    share: float = 1.0
    spikes: int = 0
    apart_s: float = 0.0
    needs: tuple[str, ...] = ()

    @property
    def stays(self) -> bool:
        """Whether it has no end."""
        return math.isinf(self.end_s)

    @property
    def is_at_instants(self) -> bool:
        """Whether it hits single readings, and not all within a time."""
        return self.spikes > 0 or self.end_s == self.at_s

    @property
    def over_s(self) -> float:
        """From when on estimates should be right again: its end, or its begin where it stays."""
        return self.at_s if self.stays else self.end_s


@cache
def faults(file: Path = FILE) -> Mapping[str, Fault]:
    """Return every fault of a table by its key, in the order of the file."""
    data = toml_data(file.read_text("utf-8"), str(file))
    common = {key: value for key, value in data.items() if key != "fault"}
    found = [_fault({**common, **part}) for row in data["fault"] for part in _parts(row)]
    by_key = {fault.key: fault for fault in found}
    assert len(by_key) == len(found), "two faults have one key"
    return MappingProxyType(by_key)


def fault_named(key: str) -> Fault:
    """Return a fault by its key; raises `InputError` for an unknown one."""
    if key not in faults():
        raise unknown("fault", key, faults())
    return faults()[key]


def _parts(row: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield what each fault of a row has: one target, one size, one length."""
    own = {key: value for key, value in row.items() if key not in ("of", "for_s", "each")}
    lengths = row.get("for_s", [math.inf])
    if "each" in row:
        shared = {"for_s": lengths[0], **({"of": row["of"][0]} if "of" in row else {})}
        yield from ({**own, **shared, **part} for part in row["each"])
        return
    for part in _targets(row["of"]):
        several = lengths[part["of"]] if isinstance(lengths, Mapping) else lengths
        for length in several if isinstance(several, list) else [several]:
            yield {**own, **part, "for_s": length}


def _targets(of: list[str] | Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    if not isinstance(of, Mapping):
        yield from ({"of": target} for target in of)
        return
    for key, sizes in of.items():
        target, _, end = key.partition("_")
        unit, factor = SIZES[end]
        for size in sizes if isinstance(sizes, list) else [sizes]:
            said = f"{size:g} {unit}".strip()
            yield {"of": target, "size": size * factor, "say": said}


def _fault(part: Mapping[str, Any]) -> Fault:
    target, length = part["of"], float(part["for_s"])
    if spikes := part.get("spikes", 0):
        length = (spikes - 1) * part["apart_s"]
    said = [part["short"], target, part.get("say", "")]
    if math.isinf(length) and part["at_s"] > 0:
        said.append("to the end")
    elif 0 < length < math.inf and not spikes:
        said.append(f"{length:g} s")
    more = {key: part[key] for key in ("size", "axis", "share", "spikes", "apart_s") if key in part}
    return Fault(
        ", ".join(filter(None, said)),
        part["name"],
        part["does"],
        target,
        part["at_s"],
        part["at_s"] + length,
        part["duration_s"],
        turn_rad=math.radians(part.get("turn_deg", 0.0)),
        needs=tuple(part.get("needs", ())),
        **more,
    )
