"""Replays whose results are remembered until the step that asks for them is through."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, TypeVar

from estimation.watch.deadline import Spending, TimedLevels
from estimation.watch.hypotheses import Hypothesis
from estimation.watch.past import Anchor, Past
from estimation.watch.replay import Replayed, Replays

FoundT = TypeVar("FoundT")


class RememberedReplays:
    """`Replays` that keep to a deadline; see `estimation.watch.deadline`.

    Parameters
    ----------
    levels : of the replays
    """

    def __init__(self, replays: Replays, levels: TimedLevels, spending: Spending) -> None:
        self._replays, self._levels, self._spending = replays, levels, spending
        self._found: dict[Hashable, Any] = {}
        self._state: Any = None
        self.without, self.has_reading = replays.without, replays.has_reading

    def ask_for(self, state: Any) -> None:
        """Forget all that is not of a step from this state."""
        if state is not self._state:
            self._state = state
            self._found.clear()
            self._levels.forget()

    def start(self, past: Past, level: int, back_s: float) -> Anchor:
        """See `Replays.start`."""
        return self._once(
            ("start", past.count, level, back_s),
            lambda: self._replays.start(past, level, back_s),
        )

    def before(self, past: Past, level: int, number: int) -> Anchor:
        """See `Replays.before`."""
        return self._once(
            ("before", past.count, level, number),
            lambda: self._replays.before(past, level, number),
        )

    def replayed(
        self,
        past: Past,
        start: Anchor,
        hypothesis: Hypothesis,
        *,
        level: int,
        undropped: frozenset[int],
        **given: Any,
    ) -> Replayed | None:
        """See `Replays.replayed`."""
        return self._once(
            (past.count, start.number, hypothesis, level, undropped),
            lambda: self._replays.replayed(
                past, start, hypothesis, level=level, undropped=undropped, **given
            ),
        )

    def _once(self, key: Hashable, find: Callable[[], FoundT]) -> FoundT:
        if key not in self._found:
            self._spending.check()
            self._found[key] = find()
        found: FoundT = self._found[key]
        return found
