"""What headers mean, by the words in them: a table of words, not a branch for a logger.

A header is a kind's words, an axis, and a unit: ``ax``, ``Gyr_Y``, ``Beschl. Z [g]``,
``field.angular_velocity.x``, ``accelerometerAccelerationX(G)``. What is left is a label, which
tells sensors of one kind apart: ``left accel x``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from recordings.foreign.header_units import (
    KNOWN_UNITS,
    Unit,
    spelt_words,
    split_header,
    unit_of,
    words_of,
)

ACCELEROMETER, GYROSCOPE, MAGNETOMETER = "accelerometer", "gyroscope", "magnetometer"
LINEAR, GRAVITY = "linear acceleration", "gravity"
POSITION, ATTITUDE = "position", "attitude"

KIND_WORDS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        LINEAR: (
            "user acceleration", "user acc", "linear acceleration", "linear accelerometer",
            "lin acc", "linacc", "linear acc", "free acc", "freeacc", "free acceleration",
            "useraccel", "user accel", "linear accel", "lineare beschleunigung", "linaccel",
        ),
        GRAVITY: ("gravity", "grav", "gravitation", "schwerkraft"),
        ATTITUDE: (
            "quaternion", "quat", "orientation", "attitude", "rotation vector", "q",
            "orientierung",
        ),
        GYROSCOPE: (
            "rotation rate", "gyro rotation", "angular velocity", "angular rate",
            "angular speed", "ang vel", "angvel", "anglvel", "turn rate", "gyroscope", "gyro",
            "gyr", "gyros", "drehrate", "drehraten",
            "winkelgeschwindigkeit", "winkelgeschw", "gyroskop", "vitesse angulaire",
            "velocidad angular", "velocita angolare", "giroscopio", "omega",
            "rate", "rot", "w", "g", "gy",
        ),
        MAGNETOMETER: (
            "magnetometer", "magnetic field", "magnetic", "magnetfeld", "magnet", "mag",
            "campo magnetico", "champ magnetique", "compass", "m",
        ),
        ACCELEROMETER: (
            "accelerometer acceleration", "total acceleration", "acceleration", "accelerometer",
            "accel", "acc", "accelero", "accelerations", "beschleunigung", "beschl",
            "specific force", "aceleracion", "accelerazione", "accelerometre",
            "gforce", "accl", "xl", "ac", "a",
        ),
        POSITION: ("tip position", "position", "pos", "translation", "tip", "stylus", "p", "t"),
    }
)  # fmt: skip
"""Kind → words for it; of several that fit a header, the first row counts, and longer words."""

AXIS_OF = MappingProxyType({"x": "x", "y": "y", "z": "z"})
QUATERNION = MappingProxyType(
    {"w": "w", "x": "x", "y": "y", "z": "z", "q0": "w", "q1": "x", "q2": "y", "q3": "z"}
)
_FILLERS = spelt_words(
    "axis achse axe eje component value val raw data field calibrated reading sensor the "
    "of to imu msg measured pose with filtered smooth in channel ch"
)
_NOT_READINGS = spelt_words(
    "covariance cov bias std var variance offset drift temperature temp norm abs absolute "
    "magnitude true covariance0 accuracy status"
)
_TIME_WORDS = spelt_words(
    "time times timestamp timestamps stamp zeit zeitstempel uhrzeit t elapsed uptime "
    "temps tiempo tempo datetime date utc epoch epoc ticks tick clock recordtime recorded "
    "sampletimefine ts fecha hora heure"
)
_NO_TIME = spelt_words(
    "zone timezone step delta dt diff offset accuracy name count counter duration"
)
KIND_OF_SI: Mapping[str, str] = MappingProxyType(
    {"m_s2": ACCELEROMETER, "rad_s": GYROSCOPE, "ut": MAGNETOMETER}
)
"""What a reading with an axis is of, where its unit says it and its words do not."""
_SPELT_ALIKE: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        GYROSCOPE: {name: f"{name}_s" for name in ("rad", "deg")},
        MAGNETOMETER: {"g": "gauss", "mg": "mgauss"},
    }
)
"""Kind → a unit's name → the one that is meant of it: rates, and gauss for G."""
_TURNS: Mapping[str, str] = MappingProxyType(
    {"roll": "x", "pitch": "y", "yaw": "z", "alpha": "x", "beta": "y", "gamma": "z"}
)
"""Axis of a rate about it; the Greek ones of DeviceMotionEvent's ``rotationRate`` (W3C, Device
Orientation and Motion): alpha about x, other than that of its orientation."""
_OF_RATES = spelt_words("rate gyro gyroscope rot")
_SPEEDS = spelt_words("rate velocity vel speed")
INCLUDING = spelt_words("including incl")
"""``accelerationIncludingGravity``, beside which DeviceMotionEvent has one without."""
_INDEX = re.compile(r"[\[(]([0-3])[\])]\s*$")
_BEHIND = re.compile(r"[\[({]([^\[\](){}]*)[\])}]\s*$")
"""Words in brackets that are no unit: ``Acc x (left)``."""
_GLUED = re.compile(r"^(.+?)([xyz])(\d*)$|^([xyz])([a-z]+)$")


@dataclass(frozen=True)
class Meaning:
    """What a header means.

    Parameters
    ----------
    kind : of `KIND_WORDS`
    label : the words that are left: which of several sensors
    axis : ``x``, ``y``, ``z``, and ``w`` of a quaternion
    unit : as it is written; None where it is not
    """

    kind: str
    label: str
    axis: str
    unit: Unit | None


def meaning(header: str, context: str = "") -> Meaning | None:
    """Return what a header means as a reading; None where it is none.

    Parameters
    ----------
    context : name of its file, sheet or topic, for headers like ``x`` in ``Gyroscope.csv``
    """
    stem, unit = split_header(header)
    if index := _INDEX.search(header if unit is None else stem):
        before, written = split_header(index.string[: index.start()])
        stem, unit = f"{before} {'xyzw'[int(index[1])]}", unit or written
    elif unit is None and (behind := _BEHIND.search(stem)):
        before_it = meaning(stem[: behind.start()], context)
        if before_it is not None:
            more = [before_it.label, *words_of(behind[1])]
            return replace(before_it, label=" ".join(more).strip())
    words = words_of(stem)
    if not AXIS_OF.keys() & set(words):
        words = [word for part in words for word in _unglued(part)]
    if _NOT_READINGS & set(words) or ("angle" in words and not _SPEEDS & set(words)):
        return None
    if _OF_RATES & set(words) or (unit is not None and unit.si == "rad_s"):
        words = [_TURNS.get(word, word) for word in words]
    if INCLUDING & set(words):
        words = [word for word in words if word != "gravity"]
    axes = [word for word in words if word in QUATERNION]
    words = [word for word in words if word not in _FILLERS]
    if len(axes) != 1:
        axes = [word for word in axes if word != "w"]  # a rate here: ``w x``
    if len(axes) != 1:
        return None
    words.remove(axes[0])
    found = _kind(words)
    if found is None and unit is not None and unit.si in KIND_OF_SI:
        found = KIND_OF_SI[unit.si], words
    if found is None and not words:
        kind_there = kind_named(context)
        found = None if kind_there is None else (kind_there, [])
    if found is None:
        return None
    kind, label = found
    axis, unit = QUATERNION[axes[0]], unit_of_kind(kind, unit)
    if unit is not None:
        kind = KIND_OF_SI.get(unit.si, kind)
    if kind == ATTITUDE or axis in AXIS_OF:
        return Meaning(kind, " ".join(label), axis, unit)
    return None


def unit_of_kind(kind: str, unit: Unit | None) -> Unit | None:
    """Return the unit that is meant of a kind: mG is no acceleration of a magnetometer."""
    meant = "" if unit is None else _SPELT_ALIKE.get(kind, {}).get(unit.name, "")
    return KNOWN_UNITS.get(meant, unit)


def kind_of_words(text: str) -> str | None:
    """Return the kind that a text names: ``TYPE_ACCELEROMETER``, ``gyro``; None where none."""
    found = _kind([word for word in words_of(text) if word not in ("type", "android", "sensor")])
    return None if found is None else found[0]


def kind_named(text: str) -> str | None:
    """Return the one kind that a name tells by words, not letters; None for none, or for two."""
    found = _kind([word for word in words_of(text) if len(word.rstrip("0123456789")) > 1])
    if found is None:
        return None
    other = _kind(found[1])
    return found[0] if other is None or other[0] == found[0] else None


def time_words(header: str) -> tuple[str, Unit | None] | None:
    """Return the words of a header of times and their unit; None for any other header."""
    stem, unit = split_header(header)
    words = words_of(stem)
    if _NO_TIME & set(words_of(header)) or (unit is not None and unit.si != "s"):
        return None
    # ``millis`` and ``TimeUS`` are units in themselves.
    units = [one for one in map(unit_of, words) if one and one.si == "s"]
    if unit is None and units and len(words[-1]) > 1:
        unit = units[-1]
    if unit is None and not _TIME_WORDS & set(words) and "sample time fine" not in stem:
        return None
    return " ".join(words), unit


def _unglued(word: str) -> list[str]:
    """Split ``ax`` and ``accx1`` into word, axis and number where the rest is a kind's word."""
    glued = len(word) == 2 and word[0] in _ALL_WORDS and word[1] in AXIS_OF  # ``gy``
    if word in QUATERNION or (word in _ALL_WORDS and not glued):
        return [word]
    if re.fullmatch("q[wxyz]", word):
        return ["q", word[1]]
    found = _GLUED.match(word)
    if found is None:
        return [word]
    before, axis, number, first, after = found.groups()
    if first is not None:
        return [after, first] if after in _ALL_WORDS else [word]
    return [before, axis, *([number] if number else [])] if before in _ALL_WORDS else [word]


def _kind(words: list[str]) -> tuple[str, list[str]] | None:
    """Return the kind and the words that are left."""
    plain = f" {' '.join(re.sub(r'[0-9]+$', '', word) for word in words)} "
    for kind, phrases in KIND_WORDS.items():
        for phrase in phrases:
            at = plain.find(f" {phrase} ")
            if at >= 0:
                start = plain[:at].count(" ")
                n = phrase.count(" ") + 1
                digits = [re.sub(r"^[a-z]+", "", word) for word in words[start : start + n]]
                label = words[:start] + [d for d in digits if d] + words[start + n :]
                return kind, [word for word in label if _kind_words_of(word) != kind]
    return None


def _kind_words_of(word: str) -> str | None:
    return next((kind for kind, phrases in KIND_WORDS.items() if word in phrases), None)


_ALL_WORDS = frozenset(
    word for phrases in KIND_WORDS.values() for phrase in phrases for word in phrase.split()
)
