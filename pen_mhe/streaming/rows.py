"""The rows that an estimator is given of a recording that comes in parts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Protocol

from estimation.orders import Stacked, no_rows
from estimation.recording import Recording
from models.state_space import StateSpaceModel
from recordings.formats.table_stream import TableStream
from recordings.parts import RecordingPart, UsedParts


class Order(Protocol):
    """Of capture or of arrival; see `estimation.orders`."""

    @property
    def model(self) -> StateSpaceModel:
        """Whose rows they are."""

    def take(self, part: Recording) -> Stacked:
        """Return the rows of the next part."""

    def end(self) -> Stacked:
        """Return the rows behind the last part."""


def stacked_parts(
    stream: TableStream,
    used: UsedParts,
    order: Order,
    *,
    on_read: Callable[[float], None] | None = None,
) -> Iterator[tuple[RecordingPart | None, Stacked]]:
    """Yield each part that is used with its rows, then what arrives behind the last with None.

    Parameters
    ----------
    on_read : see `recordings.formats.table_stream.TableStream.parts`
    """
    for raw in stream.parts(on_read):
        part = used.take(raw)
        if part is not None:
            yield part, no_rows(order.model) if part.used is None else order.take(part.used)
        if used.is_over:
            break
    yield None, order.end()
