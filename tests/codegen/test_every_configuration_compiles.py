"""Every model of the contract is exported as C that compiles without a warning."""

from __future__ import annotations

from pathlib import Path

import pytest

from models.paper import Paper
from models.pen import pen_model
from tests.codegen.configurations import MODELS, of_a_kind
from tests.codegen.exports import made
from tests.codegen.toolchains import HOST, TOOLCHAINS, Toolchain, compile_strictly
from tests.engines import needs_compiler
from tests.estimation import pens
from tests.mhe import pendulum

CHECK = ("-fsyntax-only",)
"""All warnings that need no optimiser, in a tenth of the time."""


@needs_compiler
@pytest.mark.parametrize("model", of_a_kind())
def test_windows_in_single_precision(model: str, tmp_path: Path) -> None:
    """The filter of every model is compiled, and run, in test_every_configuration_runs.py."""
    compile_strictly(HOST, made("mhe-rti", MODELS[model], "float"), tmp_path, CHECK)


@needs_compiler
@pytest.mark.parametrize("name", ["ekf", "mhe-rti"])
def test_in_double_precision(name: str, tmp_path: Path) -> None:
    compile_strictly(HOST, made(name, MODELS["turntable accel+gyro"]), tmp_path, CHECK)


@pytest.mark.cover
@pytest.mark.parametrize("chain", TOOLCHAINS)
@pytest.mark.parametrize(
    ("name", "real", "level"),
    [
        ("ekf", "double", "-O3"),
        ("ekf", "float", "-O3"),
        ("mhe-rti", "double", "-Os"),
        ("mhe-rti", "float", "-O2"),
        ("mhe-rti", "float", "-O3"),
    ],
)
def test_at_levels_of_optimisation(
    chain: Toolchain, name: str, real: str, level: str, tmp_path: Path
) -> None:
    compile_strictly(chain, made(name, pendulum.model(), real), tmp_path, (level,))


@pytest.mark.cover
@pytest.mark.parametrize("chain", TOOLCHAINS)
@pytest.mark.parametrize("real", ["double", "float"])
def test_bounds_and_inequalities(chain: Toolchain, real: str, tmp_path: Path) -> None:
    model = pendulum.model().bounded(s0_m=(-0.3, 0.3)).constrained(lambda x: x[0] + x[1] - 9)
    compile_strictly(chain, made("mhe-rti", model, real), tmp_path)


@needs_compiler
@pytest.mark.parametrize("form", ["covariance", "root"])
def test_as_c11_too(form: str, tmp_path: Path) -> None:
    settings = {"horizon": 6, "lag_samples": (2, 3), "deadline_s": 0.01}
    export = made("mhe-rti", pendulum.model(), "float", form, settings)
    compile_strictly(HOST, export, tmp_path, ("-std=c11", "-DPEN_MHE_CLOCK=seconds_of", *CHECK))


@needs_compiler
def test_a_pen_above_its_paper(tmp_path: Path) -> None:
    model = pen_model(pens.pen_config().model_copy(update={"paper": Paper()}))
    compile_strictly(HOST, made("mhe-rti", model, "float"), tmp_path, CHECK)
