"""What is asked of an instant beside its statistics: is it calmer, and is what was known still?"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.arrays import Array

Marks = NDArray[np.bool_]


class Calmer(NamedTuple):
    """When a motion counts as calmer: after so long since an instant, with a factor on energies.

    A factor of 0 is never.
    """

    since_s: float
    after_s: float
    factor: float


NEVER_CALMER = Calmer(0.0, 0.0, 0.0)


class Known(NamedTuple):
    """Whether states are known: where their deviations are below a limit, NaN for one without.

    Parameters
    ----------
    limit, known, std : (n_x,) limits, which states were known, and their deviations before
    covariance : (n_x, n_x) of now
    """

    limit: Array
    known: NDArray[np.bool_]
    std: Array
    covariance: Array
