"""The problems as bodies that windows are cut from, with the file's N and less."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from suites.classics.problems import PROBLEMS, figures_of
from suites.classics.recordings import model_of, prior_of, recorded, settings
from suites.windows import Recorded, WindowBody


def window_bodies() -> Mapping[str, WindowBody]:
    """Return a body per problem, by name."""
    return {f"classic {case}": _body(case) for case in PROBLEMS}


def _body(case: str) -> WindowBody:
    given, horizon = figures_of(case), int(settings(case)["horizon"])
    dt, last = given["dt_s"], given["samples"] - horizon - 1
    kinds = ("plain", "missing", "bad start")  # none has a faster motion
    lengths: dict[str, tuple[int, ...]] = dict.fromkeys(kinds, (horizon,))
    lengths["bad start"] = (horizon, horizon // 2, horizon, 1)  # where a window grows
    return WindowBody(
        model_of(case), dt, partial(_recorded, case), kinds, lengths, (dt, (last - 1) * dt)
    )


def _recorded(case: str, kind: str, duration_s: float, rng: np.random.Generator) -> Recorded:
    seed = int(rng.integers(2**31))
    recording = recorded(case, seed)
    return recording, prior_of(case, recording, seed)
