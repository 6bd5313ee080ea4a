"""What an estimator said at each instant: bits of its status, and of its flags of sensors."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimation.history import EstimateHistory
from estimation.status import Status
from estimation.watch.flags import Flag, Flags
from models.arrays import Array


@dataclass(frozen=True, eq=False)
class Said:
    """What was said.

    Parameters
    ----------
    status : (n,) bits of `estimation.status.Status`
    flagged : (n, n_sensors) bits of `estimation.watch.flags.Flag`; no column without a watch
    sensor_names : (n_sensors,)
    """

    status: NDArray[np.int64]
    flagged: Flags
    sensor_names: tuple[str, ...] = ()

    @classmethod
    def of(cls, history: EstimateHistory) -> Said:
        """Return what a history says."""
        status = np.array([each.value for each in history.status], dtype=np.int64)
        return cls(status, history.flagged, history.sensor_names)

    def more_than(self, other: Said) -> Said:
        """Return what is said here that another never says."""
        never = ~np.bitwise_or.reduce(other.status, initial=0)
        unflagged = ~np.bitwise_or.reduce(other.flagged, axis=0)
        return Said(self.status & never, self.flagged & unflagged, self.sensor_names)

    @property
    def anything(self) -> NDArray[np.bool_]:
        """(n,) whether something is said."""
        return np.asarray((self.status != 0) | (self.flagged != 0).any(axis=1))

    @property
    def any_flag(self) -> NDArray[np.bool_]:
        """(n,) whether a sensor is flagged."""
        return np.asarray((self.flagged != 0).any(axis=1))

    def words(self, lasting_s: Array) -> str:
        """Return the words with how long each was said: ``no_reading 2 s, accel:stuck 0.5 s``.

        Parameters
        ----------
        lasting_s : (n,) how long each instant's word stands, s
        """
        said = Counter[str]()
        for member in Status:
            said[(member.name or "").lower()] = lasting_s[(self.status & member.value) != 0].sum()
        for name, bits in zip(self.sensor_names, self.flagged.T, strict=True):
            for flag in Flag:
                said[f"{name}:{flag.word}"] = lasting_s[(bits & flag) != 0].sum()
        return ", ".join(f"{word} {time:.2g} s" for word, time in said.most_common() if time > 0)
