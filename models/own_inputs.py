"""Known inputs of a model of one's own: their names, and what acts over a step.

An input u_k is known at instant k and acts from there on: held, over the whole step to the next
instant, or interpolated, by the mean of u_k and u_{k+1}. Either way a step to instant k + 1 needs
nothing that has not arrived by then.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import casadi as ca

from models.errors import InputError
from models.names import several, unknown
from models.plain_names import check_text
from models.units import unit_ending

Inputs = Mapping[str, str] | Iterable[str]
"""Name → unit, or names whose unit is what they end in, if that is one."""


@dataclass(frozen=True)
class OwnInputs:
    """Names (n_u,), their units, and those of them that are interpolated."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    interpolated: tuple[str, ...]

    def symbols(self) -> dict[str, ca.SX]:
        """Return the inputs (n_u,) at both ends of a step; none where there are no inputs."""
        names = ("u", "u_next") if self.names else ()
        return {name: ca.SX.sym(name, len(self.names)) for name in names}

    def named(self, *ends: ca.SX) -> dict[str, ca.SX]:
        """Return name → symbol of the inputs at a step's beginning, from those at both ends."""
        return dict(zip(self.names, ca.vertsplit(ends[0]), strict=True)) if ends else {}

    def over_step(self, *ends: ca.SX) -> tuple[ca.SX, ...]:
        """Return what a transition takes behind Δt, from the inputs at both ends of its step."""
        if not self.names:
            return ()
        u, u_next = ends
        acting = [
            (u[i] + u_next[i]) / 2 if name in self.interpolated else u[i]
            for i, name in enumerate(self.names)
        ]
        return (ca.vertcat(*acting),)


def own_inputs(
    model: str, inputs: Inputs, interpolated: Iterable[str], taken: Iterable[str]
) -> OwnInputs:
    """Return the inputs of a model.

    Parameters
    ----------
    model : its name
    taken : names of its other quantities

    Raises
    ------
    InputError
        If a name is given twice, is taken, or is interpolated and no input.
    """
    names = several(inputs)
    units = (
        tuple(inputs.values()) if isinstance(inputs, Mapping) else tuple(map(unit_ending, names))
    )
    for name, unit in zip(names, units, strict=True):
        if not (isinstance(name, str) and name and isinstance(unit, str)):
            raise InputError(
                f"model {model}: input {name!r} in {unit!r}, expected a name and its unit as texts"
            )
        check_text(name, f"model {model}: input")
        if names.count(name) > 1 or name in taken:
            raise InputError(
                f"model {model}: input {name} is the name of another quantity, "
                "expected a name of its own"
            )
    for name in several(interpolated):
        if name not in names:
            raise unknown(f"model {model}: interpolated input", name, names)
    return OwnInputs(names, units, several(interpolated))
