"""The command that compares mhe with IPOPT, window by window."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest
from typer.testing import CliRunner

from commands.cli import app
from suites.optimum.cases import window_table
from suites.optimum.kinds import KINDS
from suites.optimum.run import VERDICTS, compare

WINDOWS, SEED = 2, 11


def test_optimum_writes_a_row_per_window(tmp_path: Path) -> None:
    output = tmp_path / "made"
    arguments = ["--windows", str(WINDOWS), "--seed", str(SEED), "--jobs", "1"]
    result = CliRunner().invoke(app, ["optimum", *arguments, "--output", str(output)])
    assert result.exit_code == 0, result.stderr
    table = pd.read_csv(output / "optimum.csv")
    keys = window_table(WINDOWS, SEED)
    for key, row in zip(keys, table.to_dict("records"), strict=True):
        expected = compare(key)
        for name in ("seed", "model", "kind", "horizon"):
            assert row[name] == getattr(key, name)
        assert row["verdict"] == expected.verdict
        assert row["verdict"] in VERDICTS
        assert row["status"] == expected.status.label
        assert row["cost"] == pytest.approx(expected.cost, rel=1e-9)
        assert row["ipopt_cost"] == pytest.approx(expected.ipopt_cost, rel=1e-9)
    printed = result.stdout
    assert printed.startswith(f"mhe against IPOPT from the same start, {WINDOWS} windows")
    assert all(f"| {KINDS[key.kind].label} | " in printed for key in keys)
    assert all(f"| {key.model} | " in printed for key in keys)
    assert f"same minimum: {(table['verdict'] == 'same').sum()}, of which 0 are" in printed
    assert f"table in {output}" in printed
