"""From a recording in a file to a table in another, and a figure: the work of ``pen-mhe estimate``.

CSV and Parquet are read, estimated and written in parts, so that memory does not grow with them. A
format without parts is read whole, and so is what is smoothed, which keeps all of a run: up to the
limit that `models.limits` states.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from estimation.output_file import whole_file
from models.pen_config import PenConfig
from pen_mhe.estimate_run import estimate_recording
from pen_mhe.run_summary import RunSummary
from pen_mhe.streaming.drawn import DrawnRows
from pen_mhe.streaming.run import Reporting, estimate_stream, silent
from recordings.formats.table import format_of
from recordings.formats.table_writer import TableWriter
from recordings.formats.tables import check_output, write_table
from recordings.read import read_written

FIGURE_SUFFIXES = (".png", ".pdf", ".svg")


def estimate_file(
    recording: Path,
    pen: PenConfig,
    output: Path,
    *,
    figure: Path | None = None,
    units: Mapping[str, str] | None = None,
    smooth: bool = False,
    reporting: Reporting = silent,
    **options: Any,
) -> RunSummary:
    """Estimate a recording; return what the run says of itself.

    Parameters
    ----------
    recording : of one of `recordings.formats.table.FORMATS`
    output, figure : files to write
    units : of a table's columns, see `recordings.read.read_written`
    reporting : of the work, as it is done
    smooth, options : see `pen_mhe.estimate_run.estimate_recording`

    Raises
    ------
    InputError
        If the recording is none, something given makes no sense, or a file cannot be written.
    """
    check_output(output)
    if figure is not None:
        check_output(figure, FIGURE_SUFFIXES)
    row = format_of(recording) if recording.exists() else None
    if smooth or row is None or row.stream is None:
        loaded = read_written(recording, pen, units=units)
        with reporting(options["estimator"]) as start:
            result = estimate_recording(loaded, pen, smooth=smooth, on_start=start, **options)
        write_table(result.output.to_pandas(), output)
        if figure is not None:
            _save(figure, result.output, result.ink, truth=result.used.truth)
        return result.summary()
    drawn = None if figure is None else DrawnRows()
    with (
        row.stream(recording, pen, units=units) as stream,
        whole_file(output) as file,
        TableWriter(file, output.suffix) as writer,
    ):
        summary = estimate_stream(
            stream, pen, writer.write, drawn=drawn, reporting=reporting, **options
        )
    if figure is not None and drawn is not None:
        _save(figure, drawn.history, truth=drawn.truth, samples=summary.samples)
    return summary


def _save(path: Path, *drawn: Any, **more: Any) -> None:
    """Draw `pen_mhe.figures.estimate_figure` into a file."""
    from pen_mhe.figures import estimate_figure, save  # slow to import

    save(estimate_figure(*drawn, **more), path)
