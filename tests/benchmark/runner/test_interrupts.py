"""What an interrupt breaks off, even where something swallows it."""

from __future__ import annotations

import contextlib
import os
import signal
import time

import pytest

from benchmark.runner.interrupts import not_swallowed


def interrupt() -> None:
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(0.01)


def swallowed(then_s: float) -> None:
    """As a callback within a solver does, which then goes on."""
    with not_swallowed():
        with contextlib.suppress(KeyboardInterrupt):
            interrupt()
        time.sleep(then_s)


def test_a_swallowed_interrupt_comes_again() -> None:
    before, began = signal.getsignal(signal.SIGINT), time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        swallowed(20.0)
    assert time.monotonic() - began < 10.0
    assert signal.getsignal(signal.SIGINT) is before
    assert signal.getsignal(signal.SIGALRM) is signal.SIG_DFL
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


def test_one_that_is_swallowed_at_the_end_is_raised() -> None:
    with pytest.raises(KeyboardInterrupt):
        swallowed(0.0)


def test_without_an_interrupt_nothing_happens() -> None:
    with not_swallowed():
        time.sleep(0.01)
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
