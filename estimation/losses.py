"""Settings per sensor of what is done with outliers: thresholds of losses, gates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from models.arrays import is_real
from models.errors import InputError
from models.frozen_mapping import FrozenMapping
from models.names import expected_one_of


def checked_thresholds(huber: Any) -> Mapping[str, float]:
    """Return sensor → threshold of Huber's loss, frozen; `InputError` unless all are positive."""
    if not isinstance(huber, Mapping):
        raise InputError(f"huber is {huber!r}, expected sensor → threshold")
    for name, threshold in huber.items():
        if not (is_real(threshold) and threshold > 0):
            raise InputError(
                f"threshold {threshold!r} of Huber's loss on {name}, expected a positive number"
            )
    return FrozenMapping(huber)


def checked_gates(gates: Any) -> float | Mapping[str, float] | None:
    """Return the probability of all gates, or sensor → probability, frozen, or None.

    Raises
    ------
    InputError
        If one is not a probability.
    """
    if gates is None:
        return None
    if not isinstance(gates, Mapping):
        _check_gate(gates, "gate_probability is")
        return float(gates)
    for name, gate in gates.items():
        _check_gate(gate, f"gate_probability of {name} is")
    return FrozenMapping(gates)


def _check_gate(gate: Any, what: str) -> None:
    if not (is_real(gate) and 0 < gate < 1):
        raise InputError(f"{what} {gate!r}, expected between 0 and 1")


def of_sensors(
    given: Mapping[str, float], sensors: Sequence[str], what: str
) -> Mapping[str, float]:
    """Return settings by sensor; `InputError` where one is not among `sensors`.

    Parameters
    ----------
    what : the setting, for messages: ``Huber's loss``
    """
    for name in given:
        if name not in sensors:
            raise InputError(
                f"{what} on sensor {name}, which is not part of the model; "
                f"{expected_one_of(name, sensors)}"
            )
    return given
