"""Units are written one way, in labels, headings and tables: ``elevation (deg)``."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

import pen_mhe as pm
from models import paper_turntable
from pen_mhe.figures import estimate_figure
from tests.house import ROOT, modules
from tests.pages import PAGES, SITE

mpl.use("Agg")

_BASE = "m|cm|mm|s|ms|µs|us|ns|deg|°|rad|g|mg|Hz|kHz|%|µT|uT|N|kg|K|bytes|kB|nats"
_UNIT = rf"(?:{_BASE})(?:/(?:s|s²|s³|m|mm|√Hz))?²?"
OTHER_WAYS = (
    re.compile(rf" / \(?{_UNIT}\)?$"),
    re.compile(rf", {_UNIT}$"),
    re.compile(rf"\[{_UNIT}\]$"),
    re.compile(r"\([^()\d]*°[^()\d]*\)$"),
)
"""How a label of a figure may not end."""
BARE = re.compile(rf"^[a-z][a-z ]* (?:{_UNIT})$")
"""How a heading of a table may not be, either; a name of code has no blank."""
CALLS = {"set_xlabel": (0,), "set_ylabel": (0,), "Panel": (1, 2)}
"""Function → places of the labels that it is given."""
KEYWORDS = {"xlabel", "ylabel", "x_label", "y_label"}


def otherwise(label: str) -> bool:
    """Whether a label has its unit in another way than in parentheses, as the report does."""
    return any(way.search(label) for way in OTHER_WAYS)


@pytest.mark.parametrize(
    "label",
    ["tip / mm", "rate / (m/s²)", "rate / °/s", "lever, mm", "time [s]", "elevation (°)"],
)
def test_another_way_is_seen(label: str) -> None:
    assert otherwise(label)


@pytest.mark.parametrize(
    "label",
    ["tip (mm)", "rate (deg/s)", "error / claimed σ", "tip, mean distance", "accel+gyro, ekf"],
)
def test_the_one_way_is_let_pass(label: str) -> None:
    assert not otherwise(label)


def drawn() -> Iterator[Figure]:
    """Yield what the front door draws: pens, a turntable, a model with units of its own."""
    table = pm.turntable_model(paper_turntable())
    own = pm.own_model(
        "tank",
        states={"level_m": (1.0, 1.0), "heat_k": (300.0, 1.0)},
        transition=lambda x, w, dt: x + dt * w,
        n_noises=2,
        sensors={"gauge": pm.OwnSensor(lambda x: x[0], {"x": "m"}, noise_std=0.1, rate_hz=5.0)},
    )
    for model in (table, own):
        recording = pm.simulate_model(model, duration_s=0.5, seed=0)
        history = pm.run(pm.create_estimator("ekf", model), recording)
        yield history.plot(list(history.names))
        yield pm.compare({"ekf": history}, recording.truth).figure
    recording = pm.simulate("reference", ["accel", "gyro", "camera"], duration_s=0.2, seed=0)
    for sensors, unseen in ((None, ()), (["accel", "gyro"], ("tip_x_m", "azimuth_rad"))):
        run = pm.estimate(recording, "reference", sensors=sensors, estimator="ekf")
        yield run.output.plot(list(run.output.names)[:8])
        yield estimate_figure(run.output, truth=recording.truth, unseen=unseen)


@pytest.mark.usefixtures("interpreted")
def test_labels_of_drawn_figures() -> None:
    labels = {
        label
        for figure in drawn()
        for axes in figure.axes
        for label in (axes.get_xlabel(), axes.get_ylabel())
        if label
    }
    assert {"time (s)", "tip x (mm)", "azimuth (deg)", "step (ms)", "tilt phi (deg)"} <= labels
    assert {label for label in labels if otherwise(label)} == set()


def text_of(node: ast.expr) -> Iterator[str]:
    """Yield the texts that an expression is made of, what it formats left out."""
    match node:
        case ast.Constant(value=str(text)):
            yield text
        case ast.JoinedStr(values=parts):
            yield "".join(p.value if isinstance(p, ast.Constant) else "x" for p in parts)
        case ast.IfExp(body=one, orelse=other):
            yield from text_of(one)
            yield from text_of(other)


def labels_in(code: str) -> Iterator[str]:
    """Yield the labels that code writes down, where it draws."""
    for node in ast.walk(ast.parse(code)):
        match node:
            case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name)):
                for place in CALLS.get(name, ()):
                    if place < len(node.args):
                        yield from text_of(node.args[place])
                for keyword in node.keywords:
                    if keyword.arg in KEYWORDS:
                        yield from text_of(keyword.value)


def notebooks() -> list[Path]:
    return sorted((ROOT / "notebooks").glob("*.ipynb"))


def cells(path: Path) -> list[dict[str, object]]:
    found: list[dict[str, object]] = json.loads(path.read_text("utf-8"))["cells"]
    return found


def code_of(path: Path) -> str:
    if path.suffix == ".py":
        return path.read_text("utf-8")
    return "\n".join(
        "".join(map(str, np.ravel(cell["source"])))
        for cell in cells(path)
        if cell["cell_type"] == "code"
    )


def test_labels_that_code_and_notebooks_write() -> None:
    docs = [path for path in (ROOT / "docs").rglob("*.py") if SITE not in path.parents]
    files = modules().values()
    labels = {
        (path.relative_to(ROOT).as_posix(), label)
        for path in (*files, *docs, *notebooks())
        for label in labels_in(code_of(path))
    }
    assert len({path for path, _ in labels}) > 10
    assert {found for found in labels if otherwise(found[1])} == set()


@pytest.mark.parametrize("path", notebooks(), ids=lambda path: path.stem)
def test_headings_of_tables_in_notebooks(path: Path) -> None:
    text = path.read_text("utf-8")
    headings = set(re.findall(r"<th>([^<]+)</th>", text))
    assert headings or "to_html" not in text
    assert {heading for heading in headings if otherwise(heading)} == set()


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_headings_of_tables_in_pages(path: Path) -> None:
    """The first row, and the first two columns: a table may stand on its side."""
    text = re.sub(r"^```.*?^```", "", path.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
    found = set()
    for table in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE):
        rows = [[cell.strip() for cell in row.strip("|").split(" | ")] for row in table.split("\n")]
        headings = {*rows[0], *(cell for row in rows[2:] for cell in row[:2])}
        found |= {cell for cell in headings if otherwise(cell) or BARE.search(cell)}
    assert found == set()
