"""Settings of a watch."""

from __future__ import annotations

from dataclasses import dataclass

from models.arrays import is_real
from models.errors import InputError
from models.names import unknown

ON_LOST = ("restart", "hold")


@dataclass(frozen=True, kw_only=True)
class WatchConfig:
    """Settings of a watch.

    Parameters
    ----------
    on_lost : ``restart`` starts from the prior where an attitude is not known any more, or is
        refuted, and keeps what is known of biases; ``hold`` only says so
    replay_s : how far an alarm goes back, s; longer tells causes apart better, and costs more
    deadline_s : longest time that a step spends on an alarm, s; what it has not found out by then
        the next steps go on with, see `estimation.watch.in_time`. Shorter spreads an alarm over
        more steps, and gives one up that lasts longer than `replay_s`. None has none

    Raises
    ------
    InputError
        If a setting is outside its range; the message names it.
    """

    on_lost: str = "restart"
    replay_s: float = 1.5
    deadline_s: float | None = None

    def __post_init__(self) -> None:
        if self.on_lost not in ON_LOST:
            raise unknown("on_lost", self.on_lost, ON_LOST)
        if not (is_real(self.replay_s) and 0 < self.replay_s < float("inf")):
            raise InputError(f"replay_s is {self.replay_s!r}, expected a positive time")
        if self.deadline_s is not None and not (is_real(self.deadline_s) and self.deadline_s > 0):
            raise InputError(f"deadline_s is {self.deadline_s!r}, expected a positive time")
