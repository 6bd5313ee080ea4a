"""An export as an estimator: compiled here, called through its public functions."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from codegen.constant_readings import measured_columns
from codegen.estimate_fields import estimate_fields, estimate_structure, flag_field
from codegen.export import Export
from estimation.estimate import Estimate
from estimation.native import STRICT, CSource, shared_libraries
from estimation.recording import Measurement
from estimation.result import ResultReader
from estimation.status import Status
from estimation.watch.flags import Flags, not_watched
from models.arrays import Array
from models.errors import InputError
from models.given_prior import Prior


@dataclass(frozen=True, eq=False)
class ExportedState:
    """An export's state, as the bytes of its C structure."""

    data: bytes


class Exported:
    """An estimator around an export; see `codegen.export.export_texts`.

    Its workspace is static: one instance of an export per process. What a caller of the C
    does not give (the readings of sensors that read a constant) is not taken from measurements.

    Parameters
    ----------
    export : what to compile; cached as all generated code is

    Attributes
    ----------
    state : the bytes of its C structure after the last measurement that was taken
    """

    def __init__(self, export: Export) -> None:
        [library] = build([export])
        self.exported = export.exported
        self.model = export.exported.model
        self.name = f"{export.exported.estimator} ({export.precision.c_type}, {export.form})"
        self.dtype = np.dtype(export.precision.dtype)
        real = np.ctypeslib.as_ctypes_type(self.dtype)
        self._reader = ResultReader(self.model, self.exported.loop.lags)
        self.layout = self._reader.layout
        fields = estimate_fields(self.layout)
        if self.exported.watch is not None:
            fields.append(flag_field(len(self.model.sensors)))
        self._estimate: Any = estimate_structure(fields, real)()
        self._columns = measured_columns(self.model)
        self._readings = np.empty(len(self._columns), self.dtype)
        self._library = ctypes.CDLL(str(library))
        self._init = self._library[f"{export.prefix}_init"]
        self._step = self._library[f"{export.prefix}_step"]
        address = ctypes.c_void_p
        self._step.argtypes = [address, ctypes.c_double, address, address]
        self.state = ctypes.create_string_buffer(self._library.state_size())

    def init(self, prior: Prior | None = None) -> ExportedState:
        """Return the state before the first measurement; an export has its model's prior only.

        Raises
        ------
        InputError
            If a prior is given.
        """
        if prior is not None:
            raise InputError("an exported estimator is given a prior, expected none: it has one")
        self._init(self.state)
        return ExportedState(self.state.raw)

    def step(
        self, state: ExportedState, measurement: Measurement
    ) -> tuple[ExportedState, Estimate]:
        """Take one measurement; return the new state and the estimate."""
        ctypes.memmove(self.state, state.data, len(self.state))
        self.take(measurement.time_s, measurement.y)
        estimate = self._reader.estimate(self.told())
        return ExportedState(self.state.raw), replace(estimate, flagged=self.flagged)

    def take(self, time_s: float, y: Array) -> None:
        """Take one measurement into the state that is kept here: nothing is copied.

        Raises
        ------
        InputError
            If the time is not a finite number.
        """
        with np.errstate(over="ignore"):  # too large for single precision: infinite, and told so
            self._readings[:] = y[self._columns]
        readings = self._readings.ctypes.data
        if self._step(self.state, time_s, readings, ctypes.byref(self._estimate)):
            raise InputError(f"the time of a measurement is {time_s}, expected a number")

    @property
    def flagged(self) -> Flags:
        """Return what the last step said of each sensor; of none in an export without a watch."""
        if self.exported.watch is None:
            return not_watched()
        return np.array(self._estimate.flagged, dtype=np.uint8)

    @property
    def status(self) -> Status:
        """Return what the last step said of the whole."""
        return Status(self._estimate.status)

    def told(self) -> Array:
        """Return what the last step told, as `estimation.result.result_layout` has it."""
        result = np.empty(self.layout.size)
        for block in self.layout.shapes:
            value: Any = getattr(self._estimate, block, ())  # a block of no numbers is no member
            self.layout.view(result, block).ravel()[:] = value
        return result


def build(exports: Sequence[Export]) -> list[Any]:
    """Compile exports to shared libraries, each of one file, with a clock."""
    return shared_libraries([CSource(single_file(export), STRICT) for export in exports])


def single_file(export: Export) -> str:
    """Return an export as one file, with a function that tells the size of its state."""
    include = f'#include "{export.prefix}.h"\n'
    return "\n".join(
        [
            "#define PEN_MHE_HOSTED",
            "#define _POSIX_C_SOURCE 199309L",
            export.generated,
            export.source.replace(include, export.header),
            f"int state_size(void) {{ return (int)sizeof({export.prefix}_state); }}",
        ]
    )
