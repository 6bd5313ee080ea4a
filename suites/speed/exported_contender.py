"""An estimator exported as C, on the same stream: what runs on a pen, here through ctypes.

Timed is the call that takes a measurement into the state that the C keeps; the state is set
back outside the clock.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from codegen.export import export_texts
from codegen.exportable import exportable
from codegen.exported import Exported, ExportedState
from estimation import native
from estimation.recording import Measurement
from models.errors import InputError
from models.state_space import StateSpaceModel
from suites.speed.contender import ContenderAbsentError, RaceOutcome
from suites.speed.own_contenders import VERSION
from suites.speed.samples import Sample


class ExportedStep:
    """An export's step, one sample at a time.

    Parameters
    ----------
    name : one of `codegen.exportable.EXPORTABLE`
    real : ``double`` or ``float``
    settings : of the estimator
    """

    version = VERSION

    def __init__(
        self,
        model: StateSpaceModel,
        example: Sample,
        name: str,
        real: str = "double",
        settings: Mapping[str, Any] = MappingProxyType({}),
    ) -> None:
        if native.compiler() is None:
            raise ContenderAbsentError("there is no export to run without a compiler")
        try:
            self._exported = Exported(export_texts(exportable(name, model, **settings), real))
        except InputError as refusal:
            raise ContenderAbsentError(str(refusal)) from None
        self._state = self._exported.init()
        self._before: tuple[ExportedState, Measurement] | None = None

    def prepare(self, item: Sample) -> None:
        """Set the state back by taking the step before once more."""
        self._measurement = item.measurement
        if self._before is None:
            self._exported.init()
        else:
            self._exported.step(*self._before)

    def solve(self) -> None:
        """Take the measurement."""
        self._exported.take(self._measurement.time_s, self._measurement.y)

    def outcome(self) -> RaceOutcome:
        """Go on to the next sample."""
        self._before = self._state, self._measurement
        self._state, estimate = self._exported.step(*self._before)
        return RaceOutcome(estimate.status.is_solved, estimate.state.mean)
