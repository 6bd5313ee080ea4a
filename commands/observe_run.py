"""The work behind ``pen-mhe observe``: what a choice of sensors can see, in words."""

from __future__ import annotations

from collections.abc import Sequence

from benchmark.console import console, print_table
from models.pen_file import load_pen
from pen_mhe.sensor_verdict import observe


def run_observe(
    pen: str, sensors: Sequence[str] | None, writing_area: bool, duration_s: float
) -> None:
    """Print a table of the states and the unobservable directions."""
    found = observe(load_pen(pen), sensors, writing_area=writing_area, duration_s=duration_s)
    model = found.model
    print_table(
        f"{model.name}: {', '.join(sensor.name for sensor in model.sensors)}; {duration_s:g} s",
        ["state", "known before (std)", *found.by_motion],
        found.rows(),
    )
    console.print(
        "\nA percentage is the part of the prior's standard deviation that stays at least, "
        "whatever the estimator; from 30 % on a state is not observable."
    )
    for motion, verdict in found.by_motion.items():
        seen = verdict.observability
        console.print(f"\n{motion}: {seen.rank} of {model.n_x} directions are observable")
        for direction in seen.directions:
            console.print(f"  no reading shows {direction.words}")
