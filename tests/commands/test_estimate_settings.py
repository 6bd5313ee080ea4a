"""Settings on the command line: an option that the estimator does not read is refused by name."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import pytest
import typer
from typer.testing import CliRunner

from commands.cli import app
from commands.option_groups import fields_group, grouped
from commands.setting_options import OPTIONS, flag_of, settings_group
from ekf_baseline.ekf import Ekf
from pen_mhe.estimators import ESTIMATORS, EstimatorRow, settings_of

runner = CliRunner()
pytestmark = pytest.mark.usefixtures("interpreted")

QUICK = ("ekf", "mhe-rti")
"""Estimators that run with their defaults in quick tests; those of all are run elsewhere."""

WRITTEN = {
    "gate_probability": "0.9",
    "late_samples": "7",
    "alpha": "0.5",
    "beta": "1.0",
    "kappa": "2.0",
    "horizon": "3",
    "arrival_cost": "smoothed",
    "huber": "accel=2,gyro=3",
    "sparse_noise": "0.5",
    "deadline_s": "10",
    "lag_samples": "2",
    "tolerance": "1e-6",
    "max_iterations": "9",
    "reuse_threshold": "0.2",
    "hessian": "exact",
    "ipopt": "max_iter=9, mu_strategy=adaptive,tol=1e-7",
}
MEANT: dict[str, Any] = {
    "gate_probability": 0.9,
    "late_samples": 7,
    "alpha": 0.5,
    "beta": 1.0,
    "kappa": 2.0,
    "horizon": 3,
    "arrival_cost": "smoothed",
    "huber": {"accel": 2.0, "gyro": 3.0},
    "sparse_noise": 0.5,
    "deadline_s": 10.0,
    "lag_samples": 2,
    "tolerance": 1e-6,
    "max_iterations": 9,
    "reuse_threshold": 0.2,
    "hessian": "exact",
    "ipopt": {"max_iter": 9, "mu_strategy": "adaptive", "tol": 1e-7},
}


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recording") / "pen.parquet"
    arguments = ["simulate", "--output", str(path), "--duration", "0.1", "--seed", "2"]
    assert runner.invoke(app, [*arguments, "--sensors", "accel,gyro"]).exit_code == 0
    return path


def estimate(recording: Path, estimator: str, options: list[str]) -> tuple[int, str]:
    """Return exit code and standard error of ``pen-mhe estimate``."""
    output = recording.with_name("o.csv")
    output.unlink(missing_ok=True)
    given = f"--pen reference --output {output} --estimator {estimator}".split()
    result = runner.invoke(app, ["estimate", str(recording), *given, *options])
    assert output.exists() == (result.exit_code == 0)
    return result.exit_code, result.stderr


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_what_is_read_arrives_and_the_rest_is_refused(
    recording: Path, estimator: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    built: list[Any] = []
    row = ESTIMATORS[estimator]

    def make(model: Any, config: Any) -> Any:
        built.append(config)
        return row.make(model, config)

    noted = EstimatorRow(make=make, config=row.config, defaults=row.defaults)
    monkeypatch.setattr("pen_mhe.estimators.ESTIMATORS", {**ESTIMATORS, estimator: noted})
    read = [name for name in WRITTEN if name in settings_of(estimator)]
    options = [word for name in read for word in (flag_of(name), WRITTEN[name])]
    code, said = estimate(recording, estimator, options)
    assert code == 0, said
    assert built == [row.config(**{**row.defaults, **{name: MEANT[name] for name in read}})]
    for name in WRITTEN.keys() - read:
        code, said = estimate(recording, estimator, [flag_of(name), WRITTEN[name]])
        assert code == 2
        assert said.startswith(f"pen-mhe: option {flag_of(name)} is not read by {estimator}, ")
        assert said.count("\n") == 1
    assert len(built) == 1


@pytest.mark.parametrize(
    "estimator",
    [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in ESTIMATORS],
)
def test_what_is_not_given_is_not_passed_on(recording: Path, estimator: str) -> None:
    assert estimate(recording, estimator, [])[0] == 0


def test_a_default_that_is_written_out_is_given(recording: Path) -> None:
    assert estimate(recording, "ekf", ["--horizon", "20"])[0] == 2


def test_the_call_that_was_a_plain_ekf(recording: Path) -> None:
    code, said = estimate(recording, "ekf", ["--sparse-noise", "2", "--horizon", "7"])
    assert (code, said) == (
        2,
        "pen-mhe: options --horizon and --sparse-noise are not read by ekf, expected one of "
        "--gate-probability, --late-samples, --huber; "
        "mhe-ipopt, mhe-rti, mhe and mhe-sparse read them\n",
    )


def test_options_are_the_settings_of_all_estimators() -> None:
    settings = {name for estimator in ESTIMATORS for name in settings_of(estimator)}
    assert {each.name for each in settings_group().options} == settings == set(WRITTEN)
    assert set(OPTIONS) == settings, "a row that no config has, or a setting without help"


def test_a_new_estimators_setting_is_an_option(monkeypatch: pytest.MonkeyPatch) -> None:
    @dataclass(frozen=True, kw_only=True)
    class ToyConfig:
        waves: int | None = None

    row = EstimatorRow(make=Ekf, config=ToyConfig)
    monkeypatch.setattr("pen_mhe.estimators.ESTIMATORS", {**ESTIMATORS, "toy": row})
    told: list[Any] = []

    @grouped(settings=settings_group())
    def command(settings: dict[str, Any]) -> None:
        told.append(settings)

    toy = typer.Typer()
    toy.command()(command)
    assert runner.invoke(toy, ["--waves", "3"]).exit_code == 0
    assert runner.invoke(toy, []).exit_code == 0
    assert told == [{"waves": 3}, {}]


@dataclass(frozen=True, kw_only=True)
class Size:
    width: Annotated[float, typer.Option(help="Across.")]
    height: Annotated[float, typer.Option(help="Up.")] = 2.0


def test_a_group_is_one_parameter() -> None:
    told: list[Any] = []

    @grouped(size=fields_group(Size))
    def command(size: Size, name: Annotated[str, typer.Option()] = "box") -> None:
        """Draw."""
        told.append((size, name))

    app = typer.Typer()
    app.command()(command)
    assert runner.invoke(app, ["--width", "3"]).exit_code == 0
    assert told == [(Size(width=3.0), "box")]
    missing = runner.invoke(app, ["--height", "3"])
    assert missing.exit_code == 2
    assert "--width" in missing.stderr
    shown = runner.invoke(app, ["--help"]).output
    assert all(text in shown for text in ("Draw.", "Across.", "Up.", "--name"))


def test_codegen_refuses_too(tmp_path: Path) -> None:
    given = ["--pen", "reference", "--estimator", "ekf", "--horizon", "7"]
    result = runner.invoke(app, ["codegen", *given, "--output", str(tmp_path / "c")])
    assert result.exit_code == 2
    sentence = (
        "setting horizon is not read by ekf, expected one of gate_probability, late_samples, "
        "huber; "
        "mhe-rti reads it"
    )
    assert result.stderr == f"pen-mhe: {sentence}\n"
    assert not (tmp_path / "c").exists()
