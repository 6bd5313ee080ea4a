"""What may be the cause of an alarm, in order of simplicity."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from models.state_space import StateSpaceModel


@dataclass(frozen=True)
class Hypothesis:
    """A cause that explains an alarm, or does not.

    Parameters
    ----------
    left_out : numbers of the sensors that say nothing
    freed : those whose biases may be anything
    is_restart : whether what was known of the state is wrong, biases aside
    level : of `estimation.watch.livelier.LEVELS`
    is_sudden : whether that began with the alarm; else it was so all the time that is replayed
    """

    left_out: frozenset[int] = frozenset()
    freed: frozenset[int] = frozenset()
    is_restart: bool = False
    level: int = 0
    is_sudden: bool = False


class Causes:
    """The hypotheses for a model's sensors."""

    def __init__(self, model: StateSpaceModel, n_levels: int) -> None:
        sensors = list(enumerate(model.sensors))
        self._suspects = [i for i, s in sensors if s.is_disturbed]
        # A disturbance looks like a bias; freed, that would be believed while it lasts.
        self._with_bias = [i for i, s in sensors if s.bias_states and not s.is_disturbed]
        self._inertial = [i for i, s in sensors if s.feels_gravity or s.reads_rate]
        self._others = [
            i for i, s in sensors if s.is_measured and not (s.feels_gravity or s.reads_rate)
        ]
        self.n_levels = n_levels

    def tiers(
        self,
        out: frozenset[int],
        level: int,
        *,
        may_free: list[int],
        may_restart: bool,
        is_livelier: bool,
    ) -> Iterator[list[Hypothesis]]:
        """Yield groups of equally simple hypotheses, the simplest first.

        Parameters
        ----------
        out : sensors that are left out already
        level : how lively the motion is taken to be now
        may_free : sensors whose biases were not freed lately
        is_livelier : whether all inertial sensors say that it moves more than usual
        """
        kept = [i for i in self._inertial if i not in out]
        free = [i for i in self._with_bias if i in may_free and i not in out]
        others = [i for i in self._others if i not in out]
        starts = (False, True) if may_restart else (False,)
        suspects = [i for i in self._suspects if i not in out]
        if suspects and len(kept) + len(others) > 1:
            yield [Hypothesis(out | {i}, frozenset(), level=level) for i in suspects]
        top, moves_more = self.n_levels - 1, is_livelier or level > 0
        levels = range(level + 1, top + (1 if is_livelier and level > 0 else 0))
        if level == 0:
            yield [Hypothesis(out, frozenset({i}), is_sudden=True) for i in free]
        for is_restart in starts:
            livelier = [[Hypothesis(out, frozenset(), is_restart, more)] for more in levels]
            if moves_more:
                yield from livelier
            if is_restart:
                yield [Hypothesis(out, is_restart=True, level=level)]
            yield [Hypothesis(out, frozenset({i}), is_restart, level) for i in free]
            if len(kept) + len(others) > 1:
                yield [Hypothesis(out | {i}, frozenset(), is_restart, level) for i in kept]
            if not moves_more:
                yield from livelier
            if len(kept) > 1 and others:
                yield [Hypothesis(out | set(kept), frozenset(), is_restart, level)]
            if kept:
                yield [Hypothesis(out | {i}, frozenset(), is_restart, level) for i in others]
            if moves_more and top > max([level, *levels]):
                yield [Hypothesis(out, frozenset(), is_restart, top)]

    def returning(
        self,
        others: frozenset[int],
        sensor: int,
        level: int,
        *,
        has_freed: bool,
        may_restart: bool,
    ) -> list[Hypothesis]:
        """Return hypotheses that a sensor that was left out is right again.

        Where all inertial sensors are out, they may have been right and the motion livelier.
        """
        freed = frozenset({sensor}) if sensor in self._with_bias else frozenset[int]()
        biases = (frozenset[int](), freed) if has_freed else (frozenset[int](),)
        found = [Hypothesis(others, each, may_restart, level) for each in biases]
        inertial = frozenset(self._inertial)
        if has_freed and len(inertial) > 1 and inertial <= others | {sensor}:
            found += [
                Hypothesis(others - inertial, frozenset(), may_restart, more)
                for more in range(level, self.n_levels)
            ]
        return found
