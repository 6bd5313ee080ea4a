"""From a recording in a file to a table in another, and a figure: the work of ``pen-mhe estimate``.

CSV and Parquet are read, estimated and written in parts, so that memory does not grow with them.
Read whole, up to the limits that `models.limits` states, is a format without parts, a table of
another logger's or one that must be mended, and what is smoothed, or compared with a truth of
another clock, which keep all of a run.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from typing import Any

from estimation.output_file import whole_file
from models.errors import InputError
from models.pen_config import PenConfig
from pen_mhe.estimate_run import estimate_recording
from pen_mhe.no_pen.axis import AnyAxis
from pen_mhe.no_pen.found_pen import check_not_edited, place_of
from pen_mhe.no_pen.which import WhichPen, check_no_axis, pen_of
from pen_mhe.run_summary import RunSummary
from pen_mhe.streaming.drawn import DrawnRows
from pen_mhe.streaming.run import Reporting, estimate_stream, silent
from pen_mhe.truth.given import GivenTruth
from recordings.asked import ColumnsAsked
from recordings.formats.table_stream import TableStream
from recordings.formats.table_writer import TableWriter
from recordings.formats.tables import check_output, write_table
from recordings.read import RecordingPath, in_parts, read_written
from recordings.unfit import UnfitTableError
from recordings.written import WrittenRecording

FIGURE_SUFFIXES = (".png", ".pdf", ".svg")


def estimate_file(
    recording: RecordingPath,
    pen: PenConfig | None,
    output: Path,
    *,
    axis: AnyAxis | None = None,
    figure: Path | None = None,
    units: Mapping[str, str] | None = None,
    columns: ColumnsAsked | None = None,
    strict: bool = False,
    smooth: bool = False,
    truth: GivenTruth | None = None,
    reporting: Reporting = silent,
    **options: Any,
) -> RunSummary:
    """Estimate a recording; return what the run says of itself.

    Parameters
    ----------
    recording : of one of `recordings.formats.table.FORMATS`, or several of one recording
    pen : None takes what the recording shows, see `pen_mhe.no_pen.which.pen_of`, and writes the
        pen file beside the output, see `pen_mhe.no_pen.found_pen.place_of`
    axis : without a pen, see `pen_mhe.no_pen.pen_for.pen_for`
    output, figure : files to write
    units, columns, strict : of a table, see `recordings.read.read_written`
    reporting : of the work, as it is done
    smooth, truth, options : see `pen_mhe.estimate_run.estimate_recording`

    Raises
    ------
    InputError
        If the recording is none, something given makes no sense, or a file cannot be written.
    """
    check_output(output)
    if figure is not None:
        check_output(figure, FIGURE_SUFFIXES)
    if truth is not None:
        options["truth"] = truth
    more = {"figure": figure, "reporting": reporting, **options}
    asked: dict[str, Any] = {"units": units, "columns": columns}
    notes: tuple[str, ...] = ()
    if pen is None:
        which = pen_of(recording, axis, **asked, strict=strict)
        if which.found is not None:
            return _with_found_pen(
                which, place_of(recording, output), output, smooth=smooth, **more
            )
        pen, notes = which.pen, (which.note,)
    else:
        check_no_axis(axis)

    def read() -> WrittenRecording:
        loaded = read_written(recording, pen, **asked, strict=strict)
        return replace(loaded, notes=(*notes, *loaded.notes))

    stream = None if smooth or truth else in_parts(recording, pen, **asked)
    if stream is None:
        return _of_whole(read(), pen, output, smooth=smooth, **more)
    try:
        summary = _of_parts(stream, pen, output, **more)
        return replace(summary, notes=(*notes, *summary.notes))
    except UnfitTableError as refused:
        if strict:
            raise
        try:
            loaded = read()
        except InputError:
            raise refused from None
    return _of_whole(loaded, pen, output, **more)


def _with_found_pen(which: WhichPen, place: Path, output: Path, **options: Any) -> RunSummary:
    """Estimate with a pen that was found, and write its file."""
    assert which.found is not None
    assert which.loaded is not None
    check_not_edited(place)
    summary = _of_whole(which.loaded, which.pen, output, **options)
    which.found.write(place)
    return replace(summary, notes=(f"{which.note}, written to {place}", *summary.notes))


def _of_parts(
    opened: AbstractContextManager[TableStream],
    pen: PenConfig,
    output: Path,
    *,
    figure: Path | None,
    **options: Any,
) -> RunSummary:
    drawn = None if figure is None else DrawnRows()
    with (
        opened as stream,
        whole_file(output) as file,
        TableWriter(file, output.suffix) as writer,
    ):
        summary = estimate_stream(stream, pen, writer.write, drawn=drawn, **options)
    if figure is not None and drawn is not None:
        _save(
            figure,
            drawn.history,
            truth=drawn.truth,
            samples=summary.samples,
            unseen=summary.unseen,
        )
    return summary


def _of_whole(
    loaded: WrittenRecording,
    pen: PenConfig,
    output: Path,
    *,
    figure: Path | None,
    reporting: Reporting,
    **options: Any,
) -> RunSummary:
    with reporting(options["estimator"]) as start:
        result = estimate_recording(loaded, pen, on_start=start, **options)
    write_table(result.to_pandas(), output)
    if figure is not None:
        _save(figure, result.output, result.ink, truth=result.truth, unseen=result.unseen)
    return result.summary()


def _save(path: Path, *drawn: Any, **more: Any) -> None:
    """Draw `pen_mhe.figures.estimate_figure` into a file."""
    from pen_mhe.figures import estimate_figure, save  # slow to import

    save(estimate_figure(*drawn, **more), path)
