"""The work behind ``pen-mhe calibrate``: what was found, as a table and as a pen file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmark.console import console, print_table
from commands.pen_output import prepare_pen_output
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
    prepare_pen_output(output, pen)
    found = calibrate_still(recordings, pen, sensors=sensors, find=find, units=units)
    found.write(output)
    print_table(
        f"{found.find} from still poses",
        ["sensor", "quantity", "value", "± one deviation", "unit"],
        [[n.sensor, n.quantity, f"{n.value:.6g}", f"{n.std:.2g}", n.unit] for n in found.numbers],
    )
    console.print()
    for sentence in found.sentences():
        console.print(sentence)
    console.print(f"written to {output}")
