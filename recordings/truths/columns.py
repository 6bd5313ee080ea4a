"""What headers mean as somebody's truth of a pen: places, quaternions, angles, pen down."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from models.free_kinematics import QUATERNION
from models.plain_names import plain_name
from models.units import accepted_names
from recordings.foreign.column_names import ATTITUDE, POSITION, meaning
from recordings.foreign.header_units import spelt_words, split_header, words_of
from recordings.formats.columns import TRUTH_PREFIX
from recordings.truths.track import ANGLES

PLACE, TURN, ANGLE, DOWN = "place", "turn", "angle", "down"
TIP = ("tip_x_m", "tip_y_m", "tip_z_m")
_ANGLE_WORDS: Mapping[str, int] = MappingProxyType(
    {"azimuth": 0, "azimut": 0, "elevation": 1, "altitude": 1, "spin": 2, "twist": 2}
)
"""Word → which of `recordings.truths.track.ANGLES`; a tablet's are azimuth and altitude."""
_DOWN_WORDS = spelt_words("down pendown pressed touch touching contact pressure press tipdown")
_PLACE_WORDS = spelt_words("pen tip stylus tablet pointer position pos marker body rigid optitrack")
_NO_VALUE = spelt_words("std error rate speed velocity status count frame residual accuracy")


@dataclass(frozen=True)
class TruthColumn:
    """What a header means.

    Parameters
    ----------
    kind : `PLACE`, `TURN`, `ANGLE` or `DOWN`
    label : which of several: ``rigid 1``
    axis : of a place 0 to 2, of a quaternion (x, y, z, w) 0 to 3, of an angle as in `ANGLES`
    factor : to SI; None where the header says no unit
    is_own : whether it is called as this project calls it, and so the tip's and the pen's own
    sign : -1 where it reads the other way round
    """

    kind: str
    label: str
    axis: int
    factor: float | None
    is_own: bool = False
    sign: float = 1.0


def _own_columns() -> Mapping[str, TruthColumn]:
    found = {}
    for kind, names in ((PLACE, TIP), (ANGLE, ANGLES)):
        for axis, name in enumerate(names):
            for spelling, factor in accepted_names(name).items():
                found[spelling] = TruthColumn(kind, "", axis, factor, True)
    for name in QUATERNION:
        found[name] = TruthColumn(TURN, "", "xyzw".index(name[-1]), 1.0, True)
    return MappingProxyType(found)


_OWN = _own_columns()


def truth_column(header: str, context: str) -> TruthColumn | None:
    """Return what a header means; None where it is nothing of a pen's true motion.

    Parameters
    ----------
    context : name of its file, sheet or topic
    """
    own = _OWN.get(plain_name(header).casefold().removeprefix(TRUTH_PREFIX))
    if own is not None:
        return own
    stem, unit = split_header(re.sub(r"\s\(\d+\)$", "", header))
    words = words_of(stem)
    if _NO_VALUE & set(words):
        return None
    angles = [_ANGLE_WORDS[word] for word in words if word in _ANGLE_WORDS]
    if len(angles) == 1 and (unit is None or unit.si == "rad"):
        return TruthColumn(ANGLE, "", angles[0], None if unit is None else unit.factor)
    if _DOWN_WORDS & set(words):
        return TruthColumn(DOWN, "", 0, 1.0)
    told = meaning(header, context)
    if told is not None and told.kind == ATTITUDE:
        return TruthColumn(TURN, told.label, "xyzw".index(told.axis), 1.0)
    if unit is not None and unit.si != "m":
        return None
    factor = None if unit is None else unit.factor
    if told is not None and told.kind == POSITION and told.axis in "xyz":
        return TruthColumn(PLACE, told.label, "xyz".index(told.axis), factor)
    axes = [word for word in words if word in ("x", "y", "z")]
    rest = [word for word in words if word not in _PLACE_WORDS and word not in axes]
    if len(axes) == 1 and (":" in stem or all(word.isdigit() for word in rest)):  # Vicon's pen:top
        return TruthColumn(PLACE, " ".join(rest), "xyz".index(axes[0]), factor)
    return None


def complete_groups(
    columns: Mapping[str, TruthColumn],
) -> dict[str, list[dict[int, str]]]:
    """Return kind → its groups, each axis → header: those of one label that have all they need.

    A place needs x and y, a quaternion all four, angles any.
    """
    needed = {PLACE: {0, 1}, TURN: {0, 1, 2, 3}, ANGLE: set[int](), DOWN: set[int]()}
    found: dict[str, list[dict[int, str]]] = {}
    labels = dict.fromkeys((one.kind, one.label) for one in columns.values())
    for kind, label in sorted(labels, key=lambda one: bool(one[1])):
        group: dict[int, str] = {}
        for header, one in columns.items():
            if (one.kind, one.label) == (kind, label):
                group.setdefault(one.axis, header)
        if needed[kind] <= set(group):
            found.setdefault(kind, []).append(group)
    return found


def as_motive(headers: Sequence[str]) -> dict[str, TruthColumn]:
    """Return the columns of one rigid body as OptiTrack's Motive exports it; nothing for others.

    Below rows with names and "Rotation", "Position", which may be part of ours, its header is
    ``Frame, Time (Seconds), X, Y, Z, W, X, Y, Z``, a repeated name being told apart by the reader.
    """
    stems = [re.sub(r"^(Rotation|Position) |\s\(\d+\)$", "", header) for header in headers]
    start = next((i for i in range(len(stems)) if stems[i : i + 7] == list("XYZWXYZ")), None)
    if start is None:
        return {}
    turn = {headers[start + i]: TruthColumn(TURN, "", i, 1.0) for i in range(4)}
    place = {headers[start + 4 + i]: TruthColumn(PLACE, "", i, None) for i in range(3)}
    return turn | place
