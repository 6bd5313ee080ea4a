"""The public header says what everything is, and in which unit."""

from __future__ import annotations

import ctypes
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from codegen.estimate_fields import estimate_fields, estimate_structure, offsets
from codegen.export import export_texts
from codegen.exportable import exportable
from codegen.folder import export_files
from codegen.names import macros
from estimation.outputs import derived_outputs
from estimation.result import result_layout
from estimation.status import SENTENCES, Status
from mhe.config import MheRtiConfig
from mhe.realtime import MheRti
from models.errors import InputError
from models.pen import pen_model
from models.pen_file import load_pen
from models.units import readable_unit
from tests.codegen.exports import made
from tests.codegen.toolchains import STRICT, written
from tests.engines import needs_compiler
from tests.estimation import pens

PEN = pen_model(load_pen("reference"), ["accel", "gyro"])
C_TYPES = {"double": ctypes.c_double, "float": ctypes.c_float}
HEADER = made("mhe-rti", PEN).header


def test_every_state_has_its_place_and_unit() -> None:
    for i, (name, unit) in enumerate(zip(PEN.state_names, PEN.state_units, strict=True)):
        assert f"PEN_STATE_{name.upper()} = {i}, /* {unit} */" in HEADER
    assert f"#define PEN_N_X {PEN.n_x} " in HEADER


def test_everything_derived_has_its_place_and_unit() -> None:
    """Angles, quaternion, and what turns with the attitude; the README says how to read it."""
    derived = derived_outputs(PEN)
    assert {"azimuth_rad", "elevation_rad", "spin_rad", "attitude_w"} < set(derived.names)
    for i, (name, unit) in enumerate(zip(derived.names, derived.units, strict=True)):
        assert f"PEN_DERIVED_{name.upper()} = {i}, /* {unit} */" in HEADER
    assert f"#define PEN_N_DERIVED {len(derived.names)} " in HEADER
    for member in ("derived", "derived_std"):
        assert re.search(rf"pen_real {member}\[PEN_N_DERIVED\]; /\* .+ \*/", HEADER)
    readme = export_files(made("ekf", PEN), None, "…")["README.md"]
    assert f"estimate.derived[PEN_DERIVED_{derived.names[0].upper()}] in " in readme
    assert all(f"`{name}`" in readme for name in derived.names)


@needs_compiler
@pytest.mark.parametrize("real", ["double", "float"])
def test_a_model_that_is_read_by_its_states_has_no_member_for_more(
    real: str, tmp_path: Path
) -> None:
    """C99 has no arrays of no numbers: a pedantic compiler takes the header."""
    export = made("ekf", pens.draw_pen_run(20, seed=11).model, real)
    assert not derived_outputs(export.exported.model).names
    assert "#define PEN_N_DERIVED 0 " in export.header
    assert not re.search(r"\bderived", export.header.split("typedef struct {")[1])
    assert "derived" not in export_files(export, None, "…")["README.md"]
    folder = written(export, tmp_path)
    (folder / "only.c").write_text('#include "pen.h"\nint main(void) { return PEN_N_DERIVED; }')
    subprocess.run(["gcc", *STRICT, "-fsyntax-only", "only.c"], cwd=folder, check=True)


def test_every_reading_of_a_sensor_has_its_place_and_unit() -> None:
    place = 0
    for sensor in PEN.sensors:
        for axis, unit in zip(sensor.axes, sensor.unit_of_axis, strict=True):
            line = f"PEN_READING_{sensor.name.upper()}_{axis.upper()} = {place}, "
            assert (line + f"/* {readable_unit(unit)} */" in HEADER) == (sensor.is_measured)
            place += sensor.is_measured
    assert f"#define PEN_N_Y {place} " in HEADER
    assert "area: " in HEADER, "the step adds its readings"


def test_every_status_has_its_bit_and_sentence() -> None:
    for name, member in Status.__members__.items():
        assert f"#define PEN_STATUS_{name} {member.value}u /* {SENTENCES[member]} */" in HEADER


@pytest.mark.parametrize("lags", [(), (3, 5)])
def test_every_block_of_a_result_is_told(lags: tuple[int, ...]) -> None:
    layout = result_layout(PEN, lags)
    named = {field.name for field in estimate_fields(layout)}
    assert named >= {block for block, shape in layout.shapes.items() if np.prod(shape)}
    of_lags = {block for block in layout.shapes if block.startswith("lagged_")}
    assert named >= set(layout.shapes) - of_lags, "this pen has all blocks that C tells"
    assert bool(lags) == (named >= of_lags)
    places = offsets(layout)
    ends = [
        places[block] + i
        for block in layout.shapes
        for i in range(layout.view(np.zeros(layout.size), block).size)
    ]
    assert sorted(ends) == list(range(layout.size)), "no two blocks share a place"


@needs_compiler
@pytest.mark.parametrize("lags", [(), (1, 2, 4)])
@pytest.mark.parametrize("real", C_TYPES)
def test_python_and_c_agree_on_the_estimate(
    real: str, lags: tuple[int, ...], tmp_path: Path
) -> None:
    settings = {"horizon": 4, "lag_samples": lags} if lags else None
    name = "mhe-rti" if lags else "ekf"
    export = made(name, pens.draw_pen_run(20, seed=11).model, real, settings=settings)
    fields = estimate_fields(result_layout(export.exported.model, lags))
    structure = estimate_structure(fields, C_TYPES[real])
    source = "\n".join(
        [
            '#include "pen.h"',
            "#include <stddef.h>",
            "#include <stdio.h>",
            "int main(void) {",
            *(f'printf("%zu\\n", offsetof(pen_estimate, {field.name}));' for field in fields),
            'printf("%zu\\n", sizeof(pen_estimate)); return 0; }',
        ]
    )
    folder = written(export, tmp_path)
    (folder / "places.c").write_text(source)
    subprocess.run(["gcc", "places.c", "-o", "places"], cwd=folder, check=True)
    told = subprocess.run([str(folder / "places")], capture_output=True, text=True, check=True)
    wanted = [getattr(structure, field.name).offset for field in fields]
    assert [int(x) for x in told.stdout.split()] == [*wanted, ctypes.sizeof(structure)]


@pytest.mark.usefixtures("interpreted")
@pytest.mark.parametrize("arrival_cost", ["filtered", "none"])
def test_a_window_begins_as_in_python(arrival_cost: str) -> None:
    start = exportable("mhe-rti", PEN, horizon=3, arrival_cost=arrival_cost).start
    config = MheRtiConfig(horizon=3, arrival_cost=arrival_cost)
    np.testing.assert_array_equal(start, MheRti(PEN, config).init().memory)


def test_a_prefix_is_everywhere() -> None:
    export = export_texts(exportable("ekf", PEN), prefix="left_hand")
    assert "typedef double left_hand_real;" in export.header
    assert not re.search(r"\bpen_|\bPEN_(?!MHE)", export.header + export.source)


@pytest.mark.parametrize("prefix", ["", "Pen", "1st", "my-pen", "stift ", "a b"])
def test_a_prefix_that_c_cannot_have(prefix: str) -> None:
    with pytest.raises(InputError, match=r"prefix '.*', expected small letters"):
        export_texts(exportable("ekf", PEN), prefix=prefix)


def test_names_become_distinct_words_of_c() -> None:
    assert macros(["tip_x_m", "x-1", "x_1", "Öl"]) == ["TIP_X_M", "X_1", "X_1_2", "_L"]
