"""What noise levels are judged by, a row of `OBJECTIVES` each: smaller is better.

No one of them is right for all: the likelihood trusts a camera more than it deserves, because
errors that stay for many frames look like motion, and so do withheld frames; flatness does not see
how a hand moves; gaps do not see how the pen turns, which the gyroscope does.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from pen_mhe.tuning.flatness import by_flatness
from pen_mhe.tuning.frames import by_frames
from pen_mhe.tuning.gaps import by_gaps
from pen_mhe.tuning.likelihood import by_innovations
from pen_mhe.tuning.parameters import Parameter
from pen_mhe.tuning.parts import ScoredPart
from pen_mhe.tuning.score import Judge


@dataclass(frozen=True)
class Objective:
    """A row of `OBJECTIVES`.

    Parameters
    ----------
    judge : of a part of a recording; raises `InputError` where its data are absent
    unit : of its value
    loss_text : how much worse is as good, in words
    proposes : whether it is good for a parameter, of sensors with a camera or without
    withholds_touch : whether contact may not be among the sensors
    """

    judge: Callable[[ScoredPart], Judge]
    unit: str
    loss_text: str
    proposes: Callable[[Parameter], bool]
    withholds_touch: bool = False


OBJECTIVES: Mapping[str, Objective] = MappingProxyType(
    {
        "innovations": Objective(
            by_innovations,
            "nats",
            "2 nats",
            lambda parameter: not parameter.sees_pose,
        ),
        "flatness": Objective(
            by_flatness,
            "mm",
            "1 % of the spread",
            lambda parameter: parameter.sees_pose or parameter.role == "walk",
            withholds_touch=True,
        ),
        "without-camera": Objective(
            by_gaps,
            "nats per frame",
            "2 nats a gap",
            lambda parameter: parameter.table == ("motion", "tip"),
        ),
        "frames": Objective(
            by_frames,
            "nats per frame",
            "2 nats a choice of frames",
            lambda parameter: not parameter.sees_pose,
        ),
    }
)
"""Name → what it is; `proposes` names the parameters that it is good for."""
