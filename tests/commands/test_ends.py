"""How commands end: one sentence and the exit code that the help documents."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from commands import observe
from commands.cli import app
from commands.sentences import ExitCode, usage_sentence
from models.errors import Interrupted


def call(*arguments: str) -> Any:
    return CliRunner().invoke(app, arguments, prog_name="pen-mhe")


WRONG = {
    "command": (
        ("simulat",),
        "command simulat is unknown, expected one of estimate, tune, simulate,",
    ),
    "meant command": (("simulat",), "did you mean simulate?"),
    "option": (("observe", "--pne", "x"), "no such option: --pne; did you mean --pen?"),
    "first option": (("--versoin",), "no such option: --versoin; did you mean --version?"),
    "no argument": (("report",), "missing argument 'folder' (see pen-mhe report --help)"),
    "no option": (("simulate",), "missing option '--output' (see pen-mhe simulate --help)"),
    "no value": (("simulate", "--output"), "option '--output' requires an argument"),
    "no number": (("observe", "--duration", "long"), "invalid value for '--duration': "),
    "too few": (("benchmark", "--seeds", "0"), "invalid value for '--seeds': "),
    "too many words": (("observe", "accel"), "unexpected extra argument(s) (accel)"),
    "empty word": (("observe", "--pen", ""), "the word behind --pen is empty, expected a name or"),
    "empty suite": (("benchmark", ""), "the word behind benchmark is empty"),
    "choice": (
        ("estimate", "r.csv", "--pen", "dpoint", "--output", "o.csv", "--estimator", "MHE-RT"),
        "did you mean mhe-rti?",
    ),
    "pen": (
        ("observe", "--pen", "refrence"),
        "bundled pen: compass, dpoint, reference; did you mean ref",
    ),
    "sensor": (("observe", "--sensors", "gyroscope"), "did you mean gyro?"),
    "motion": (("simulate", "--output", "o.csv", "--motion", "hand"), "did you mean handwriting?"),
    "stamps": (("simulate", "--output", "o.csv", "--stamps", "arival"), "did you mean arrival?"),
    "suite": (("benchmark", "sped"), "real-time, speed; did you mean speed?"),
    "exported": (("codegen", "--output", "c", "--estimator", "mhe"), "did you mean mhe-rti?"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_call_gets_one_sentence(
    case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    arguments, sentence = WRONG[case]
    result = call(*arguments)
    assert result.exit_code == ExitCode.REFUSED == 2
    message = result.stderr.strip()
    assert message.startswith("pen-mhe: ")
    assert "\n" not in message
    assert sentence in message
    assert result.stdout == ""
    assert not list(tmp_path.iterdir())


def test_a_message_of_typer_becomes_one_sentence() -> None:
    message = "Invalid value for '--a': Value error, 'ekff' is not one of 'ekf', 'mhe'.\n"
    assert usage_sentence(message, "pen-mhe x") == (
        "invalid value for '--a': 'ekff' is not one of 'ekf', 'mhe'; did you mean ekf? "
        "(see pen-mhe x --help)"
    )


@pytest.mark.parametrize(
    ("interrupt", "sentence"),
    [
        (KeyboardInterrupt(), "interrupted; files that were written before are kept"),
        (
            Interrupted("interrupted after 3 rows, which are kept"),
            "interrupted after 3 rows, which",
        ),
    ],
)
def test_an_interrupt_is_said_in_one_sentence(
    interrupt: BaseException, sentence: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def pressed(text: str | None) -> None:
        raise interrupt

    monkeypatch.setattr(observe, "names", pressed)
    result = call("observe")
    assert result.exit_code == ExitCode.INTERRUPTED == 130
    assert result.stderr.startswith(f"pen-mhe: {sentence}")
    assert result.stderr.count("\n") == 1


def test_a_fault_of_our_own_is_no_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(text: str | None) -> None:
        raise RuntimeError("broken")

    monkeypatch.setattr(observe, "names", broken)
    result = call("observe")
    assert result.exit_code == ExitCode.FAULT == 1
    assert isinstance(result.exception, RuntimeError)


def test_ctrl_c_reaches_a_command_that_works(tmp_path: Path) -> None:
    """Whatever it is at: building commands, importing, working."""
    code = "from commands.cli import app; print('ready', flush=True); app(prog_name='pen-mhe')"
    command = [sys.executable, "-c", code, "observe", "--duration", "500"]
    for delay_s in (0.0, 0.1, 2.0):
        with subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # also behind "&"
        ) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"
            time.sleep(delay_s)
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=60)
        assert process.returncode == ExitCode.INTERRUPTED
        assert said == "pen-mhe: interrupted; files that were written before are kept\n"


def test_the_version_names_what_results_depend_on() -> None:
    result = call("--version")
    assert result.exit_code == ExitCode.DONE == 0
    python = ".".join(map(str, sys.version_info[:3]))
    assert result.stdout == (
        f"pen-mhe {version('pen-mhe')}, Python {python}, casadi {version('casadi')}\n"
    )
