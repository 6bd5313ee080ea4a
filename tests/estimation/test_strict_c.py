"""C written by hand is C99 and C11, without a word of a compiler that is asked for all of them."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from ekf_baseline.ekf import Ekf
from estimation import machine
from estimation.native import LOOPS, STRICT, VECTORS, CSource
from mhe.config import MheConfig, MheRtiConfig
from mhe.realtime import Mhe, MheRti
from tests.engines import needs_compiler
from tests.mhe import pendulum

MODEL = pendulum.model()
BUILT: Sequence[Callable[[], object]] = (
    lambda: Ekf(MODEL),
    lambda: MheRti(MODEL, MheRtiConfig(horizon=3, deadline_s=0.01, lag_samples=(1, 2))),
    lambda: Mhe(MODEL.bounded(s0_m=(-0.3, 0.3)), MheConfig(horizon=3)),
)


class SeenError(Exception):
    """C was seen; nothing is compiled."""


def by_hand(monkeypatch: pytest.MonkeyPatch) -> Sequence[CSource]:
    """Return the C around generated functions that a filter and two windows compile."""
    seen: dict[str, CSource] = {}

    def see(sources: Sequence[CSource]) -> list[Path]:
        seen.update((source.text, source) for source in sources if not source.is_of_model)
        raise SeenError

    monkeypatch.setattr(machine, "shared_libraries", see)
    for build in BUILT:
        with pytest.raises(SeenError):
            build()
    return list(seen.values())


@needs_compiler
def test_c99_and_c11(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    sources = by_hand(monkeypatch)
    assert {source.flags for source in sources} == {(*STRICT, *LOOPS), (*STRICT, *VECTORS)}
    for number, source in enumerate(sources):
        (tmp_path / "own.c").write_text(source.text)
        for standard in ("-std=c99", "-std=c11"):
            command = ["gcc", *STRICT, standard, "-fsyntax-only", "own.c"]
            told = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
            assert told.returncode == 0, f"{number}, {standard}: {told.stderr}"
