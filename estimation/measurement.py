"""What an estimator is given of one instant: a value of its own."""

from __future__ import annotations

from dataclasses import dataclass

from models.arrays import Array, numbers
from models.errors import InputError


@dataclass(frozen=True, eq=False)
class Measurement:
    """All that is known of one instant: time (s) and stacked readings y (n_row,), NaN = missing.

    Behind its n_y readings stand the inputs of a model that has some: see `stack` of
    `models.state_space.StateSpaceModel`. An input that is missing is as it was before.

    Its time is that of capture. Measurements are given in the order in which they arrive, so one
    may be older than those before it. When it arrived (s) is kept with the estimate, where it is
    known; no estimator reads it. Readings are copied.

    Raises
    ------
    InputError
        If its time is no number, or its readings are none.
    """

    time_s: float
    y: Array
    arrival_s: float | None = None

    def __post_init__(self) -> None:
        y = numbers(self.y, "readings of a measurement", "(n_row,) numbers")
        # Its own: a loop that reads into one buffer would change what an estimator still uses.
        object.__setattr__(self, "y", y.copy())
        if type(self.time_s) is not float:
            time_s = numbers(self.time_s, "time of a measurement", "seconds")
            if time_s.ndim:
                raise InputError(
                    f"time of a measurement has shape {time_s.shape}, expected one number"
                )
            object.__setattr__(self, "time_s", float(time_s))
