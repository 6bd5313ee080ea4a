"""The work behind ``pen-mhe calibrate``: what was found, as a table and as a pen file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console

from benchmark.console import console, print_table
from commands.pen_output import check_pen_output
from pen_mhe.calibration.camera import calibrate_camera
from pen_mhe.calibration.camera_fit import Progress
from pen_mhe.calibration.magnetometer import calibrate_magnetometer
from pen_mhe.calibration.magnetometer_result import MagnetometerCalibration
from pen_mhe.calibration.result import StillCalibration
from pen_mhe.calibration.still import calibrate_still


def run_still(
    recordings: Sequence[Path],
    output: Path,
    pen: str,
    sensors: Sequence[str] | None,
    find: str,
    units: Mapping[str, str],
) -> None:
    """Calibrate on still poses, write the pen file, and say how sure its numbers are."""
    check_pen_output(output, pen, recordings)
    found = calibrate_still(recordings, pen, sensors=sensors, find=find, units=units)
    _written(found, output, f"{found.find} from still poses")


def run_magnetometer(
    recordings: Sequence[Path],
    output: Path,
    pen: str,
    sensors: Sequence[str] | None,
    units: Mapping[str, str],
) -> None:
    """Calibrate on turns, write the pen file, and say how sure its numbers are."""
    check_pen_output(output, pen, recordings)
    found = calibrate_magnetometer(recordings, pen, sensors=sensors, units=units)
    _written(found, output, "hard and soft iron from turns")


def _written(found: StillCalibration | MagnetometerCalibration, output: Path, title: str) -> None:
    found.write(output)
    print_table(
        title,
        ["sensor", "quantity", "value", "± one deviation", "unit"],
        [[n.sensor, n.quantity, f"{n.value:.6g}", f"{n.std:.2g}", n.unit] for n in found.numbers],
    )
    console.print()
    for sentence in found.sentences():
        console.print(sentence)
    console.print(f"written to {output}")


def run_camera(
    recording: Path,
    output: Path,
    pen: str,
    sensors: Sequence[str] | None,
    units: Mapping[str, str],
) -> None:
    """Calibrate on a camera's frames, write the pen file, and say how sure its numbers are."""
    check_pen_output(output, pen, [recording])
    with _working() as on_progress:
        found = calibrate_camera(
            recording, pen, sensors=sensors, units=units, on_progress=on_progress
        )
    found.write(output)
    print_table(
        f"changes of the pen file by {found.frame_count} frames",
        ["number", "change", "± one deviation", "unit", "first half", "second half"],
        [
            [
                n.name,
                f"{n.value:+.4g}",
                f"{n.std:.2g}",
                n.unit,
                *(f"{value:+.3g} ± {std:.2g}" for value, std in n.halves),
            ]
            for n in found.found
        ],
    )
    console.print()
    for sentence in found.sentences():
        console.print(sentence)
    console.print(f"written to {output}")


@contextmanager
def _working() -> Iterator[Progress | None]:
    """Show how far it is on a terminal; nothing in a pipe."""
    stderr = Console(stderr=True)
    if not stderr.is_terminal:
        yield None
        return
    with stderr.status("building the filter") as status:
        yield lambda number, density: status.update(f"round {number}: {density:.5g} nats a frame")
