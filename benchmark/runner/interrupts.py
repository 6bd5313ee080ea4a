"""Ctrl-C: what it may break off, what it waits for, what is said then.

Where no handler can be set, in another thread than the main one, and where interrupts are
ignored, as behind ``&`` in a script, an interrupt does what it did before.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker
from types import FrameType

from models.errors import Interrupted

REPEAT_S = 1.0
"""Between an interrupt that was swallowed and the next."""


def interrupted(done: int) -> Interrupted:
    """Return the sentence for a run that an interrupt ended after so many tasks."""
    return Interrupted(
        f"interrupted after {done} tasks, which are kept; the same command continues"
    )


@contextmanager
def undisturbed() -> Iterator[None]:
    """Let an interrupt wait until this block is done."""
    with _interrupts_noted(lambda: None):
        yield


@contextmanager
def not_swallowed() -> Iterator[None]:
    """Let an interrupt break off this block, whatever the block makes of it.

    A solver that is interrupted within its C++ may return as if it had failed, or raise
    something else: what it says then is no result. So the interrupt is repeated until the
    block ends.
    """

    def break_off(*_: object) -> None:
        if hasattr(signal, "setitimer"):  # not on Windows
            signal.signal(signal.SIGALRM, break_off)
            signal.setitimer(signal.ITIMER_REAL, REPEAT_S)
        raise KeyboardInterrupt

    try:
        with _interrupts_noted(break_off):
            yield
    finally:
        if hasattr(signal, "setitimer") and signal.getsignal(signal.SIGALRM) is break_off:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, signal.SIG_DFL)


@contextmanager
def _interrupts_noted(then: Callable[[], None]) -> Iterator[None]:
    """Call a function at each interrupt; raise `KeyboardInterrupt` at the end if one came."""
    heard = signal.getsignal(signal.SIGINT) not in (signal.SIG_IGN, None)
    if not heard or threading.current_thread() is not threading.main_thread():
        yield
        return
    came = False

    def note(number: int, frame: FrameType | None) -> None:
        nonlocal came
        came = True
        then()

    before = signal.signal(signal.SIGINT, note)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        if came:
            raise KeyboardInterrupt


@contextmanager
def deaf_children() -> Iterator[None]:
    """Start processes within this block that no interrupt reaches until they ask for it.

    A terminal sends Ctrl-C to all processes; one that is only just importing would complain.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    resource_tracker.ensure_running()  # else it is started within, and opens the ears again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
