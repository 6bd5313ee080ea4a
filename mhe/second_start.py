"""When a window's minimum is doubtful, and where a second descent begins.

Twice the cost of a minimum is χ² distributed with as many degrees of freedom as readings are
present, if model and noises are right (exactly so on a linear model). A cost above the quantile
1 - `CHANCE` says that they are not, or that there is another minimum; the step then carries
`Status.IMPROBABLE`.

Where derivatives vanish no Gauss-Newton step leads away: on a bound (two reactions of Haseltine and
Rawlings: at P_A = 0 nothing reacts), at rest (two accelerometers feel ω² only). So where the cost
is improbable, a row is active or the descent failed, the estimators that iterate descend once more,
from a first state beside the prior's mean, one standard deviation inside all bounds, without noise:

    x_0 = clip(x̄ ⊞ σ/10, lower + σ, upper - σ)     σ at most half of the distance of two bounds

The lower of both minima is kept. While the window grows every sample may have a second start; in a
full window one that was of no use is followed by the next N samples later, but where the
first descent failed it is always tried. The unconstrained optimum's projection and the filter's
mean were tried as well: where the unconstrained minimum lies beyond a bound, they end on it again
(the lower minimum in 11 of 88 windows of the reactions, 87 from inside; of 20 first samples of two
accelerometers 7 from the mean, 20 from beside it).

``mhe-rti``, which makes one pass, has no second start. Its cost is the linearised window's, and
says nothing as long as the first passes move the linearisation far: it is judged in full windows.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from scipy.special import gammainccinv

from estimation.status import Status
from mhe.domain import limits
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel

CHANCE = 1e-6
"""How seldom a cost is exceeded where model and noises are right."""
ASIDE = 0.1
"""How far a second start is from the prior's mean, in its standard deviations."""
LOWER = 1e-6
"""A minimum is another one where its cost is lower by this, or this share of it."""

SECOND_START: Mapping[str, float] = MappingProxyType({"LOWER": LOWER, "ASIDE": ASIDE})
"""The constants as macros for C."""


def cost_limits(n_stages: int, n_r: int) -> Array:
    """Return (n_stages n_r + 1,): by the number of rows present, the cost that chance explains."""
    rows = np.arange(1, n_stages * n_r + 1)
    return np.concatenate([[np.inf], gammainccinv(rows / 2, CHANCE)])  # χ²/2 is Γ(rows / 2)


def is_better(again: Status, cost: float, first: Status, than: float, is_free: bool) -> bool:
    """Return whether a second start's end is the better one.

    Parameters
    ----------
    again, first : how both ended
    cost, than : of both
    is_free : whether there are no bounds and inequalities, which an unsolved window may violate
    """
    margin = LOWER * max(1.0, than)
    if again:
        return is_free and Status.NOT_FINITE not in again and cost < than - margin
    return cost <= than + margin if first else cost < than - margin


def started_beside(model: StateSpaceModel, prior: GaussianState) -> Array:
    """Return the first state (n_x,) of a second start."""
    lower, upper = limits(model)
    room = np.minimum(prior.std, (upper - lower) / 2)
    x = np.asarray(model.retract(prior.mean, ASIDE * prior.std)).ravel()
    return np.clip(x, lower + room, upper - room)
