"""The cache of compiled code: what its key depends on, and several processes at once."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from ekf_baseline.ekf import Ekf
from estimation import native
from estimation.recording import Measurement
from models.arrays import Array
from models.pen import pen_model
from tests.engines import needs_compiler
from tests.estimation import pens

pytestmark = needs_compiler

ROOT = Path(__file__).parents[2]
PROCESSES = 3
SCRIPT = """
import sys
from ekf_baseline.ekf import Ekf
from estimation.recording import Measurement
from mhe.config import MheConfig
from mhe.realtime import Mhe
from tests.mhe import pendulum

print("ready", flush=True)
sys.stdin.readline()
for build in (Ekf, lambda model: Mhe(model, MheConfig(horizon=3))):
    estimator = build(pendulum.model())
    state = estimator.init()
    for measurement in pendulum.simulate(6, 1):
        state, estimate = estimator.step(state, measurement)
    print(estimate.state.mean.tolist(), estimate.state.covariance.tolist())
"""


def built(function: ca.Function) -> list[Path]:
    return native.shared_libraries([native.CSource(native.generated([function]))])


def small_function(factor: float = 2.0) -> ca.Function:
    x = ca.SX.sym("x", 3)
    return ca.Function("small", [x], [factor * ca.sin(x)])


@pytest.fixture
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("PEN_MHE_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def libraries(cache: Path) -> set[str]:
    return {path.name for path in cache.iterdir()}


CHANGES = {
    "flags": ("FLAGS", (*native.FLAGS, "-DNOTHING")),
    "compiler": ("_identity", lambda gcc: ("another compiler", "1", "2")),
    "processor": ("processor", lambda: "another processor"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_the_key_depends_on(change: str, own_cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    native.compiled(small_function())
    before = libraries(own_cache)
    monkeypatch.setattr(native, *CHANGES[change])
    native.compiled(small_function())
    assert len(before) == 1
    assert len(libraries(own_cache)) == 2
    assert before < libraries(own_cache)


def test_the_key_depends_on_the_code_and_on_nothing_else(own_cache: Path) -> None:
    for factor in (2.0, 3.0, 2.0, 3.0):
        native.compiled(small_function(factor))
    assert len(libraries(own_cache)) == 2


def test_codes_of_one_length_are_not_taken_for_each_other(own_cache: Path) -> None:
    first, second = small_function(3.0), small_function(5.0)
    assert len(native.generated([first])) == len(native.generated([second]))
    assert built(first) != built(second)
    assert len(libraries(own_cache)) == 2


def test_where_the_cache_cannot_be_written_the_process_has_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blocked = tmp_path / "file" / "cache"
    blocked.parent.touch()
    monkeypatch.setenv("PEN_MHE_CACHE", str(blocked))
    with pytest.warns(RuntimeWarning, match="cache .*file/cache: Not a directory, so") as told:
        [first] = built(small_function())
    assert len(told) == 1
    assert first.is_file()
    assert built(small_function()) == [first]
    assert built(small_function(3.0))[0].parent == first.parent


def test_a_cache_that_is_only_read_serves(own_cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = built(small_function())
    monkeypatch.setattr(native, "writable", pytest.fail)
    assert built(small_function()) == made


def test_the_processor_is_more_than_its_architecture() -> None:
    """Code for this machine's own instructions must not run on an older one."""
    if not Path("/proc/cpuinfo").exists():
        pytest.skip("no /proc/cpuinfo")
    assert "flags" in native.processor() or "Features" in native.processor()


def results(cache: Path, processes: int) -> list[str]:
    """What some processes say that build the same estimators at the same time."""
    environment = os.environ | {"PEN_MHE_CACHE": str(cache), "OMP_NUM_THREADS": "1"}
    running = [
        subprocess.Popen(
            [sys.executable, "-c", SCRIPT],
            cwd=ROOT,
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        for _ in range(processes)
    ]
    for process in running:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
    for process in running:
        assert process.stdin is not None
        process.stdin.write("\n")
        process.stdin.flush()
    said = [process.communicate(timeout=120)[0] for process in running]
    assert [process.returncode for process in running] == [0] * processes
    return said


def test_several_processes_start_with_an_empty_cache(tmp_path: Path) -> None:
    said = results(tmp_path / "together", PROCESSES)
    assert said[0].count("[") > 2
    assert set(said) == {said[0]}
    assert results(tmp_path / "alone", 1) == said[:1]
    together, alone = libraries(tmp_path / "together"), libraries(tmp_path / "alone")
    assert together == alone, "not one library per hash, or something left behind"
    assert all(name.endswith(".so") for name in together)


def test_a_second_pen_of_the_same_shape_compiles_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Lengths and levels of noise are arguments of what is compiled; zeros are part of a shape."""
    monkeypatch.setenv("PEN_MHE_CACHE", str(tmp_path))
    first = pens.pen_config()
    data = first.model_dump()
    data["sensors"]["accel"]["position_m"] = (0.0, 0.0, 0.137)
    data["sensors"]["accel"]["noise_density_m_s2_per_sqrt_hz"] *= 1.7
    data["sensors"]["camera"]["position_m"] = (0.0, 0.0, 0.171)
    second = type(first).model_validate(data)
    y = np.linspace(0.1, 0.9, 12)
    means, built_by = list[Array](), list[set[str]]()
    for pen in (first, second):
        ekf = Ekf(pen_model(pen))
        state, _ = ekf.step(ekf.init(), Measurement(0.0, y))
        means.append(ekf.step(state, Measurement(0.01, y))[1].state.mean)
        built_by.append(libraries(tmp_path))
    assert built_by[0] == built_by[1] != set()
    assert np.abs(means[0] - means[1]).max() > 1e-6
