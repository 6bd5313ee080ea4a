"""The exceptions that a person reads: for input that can be mended, and for an interrupt."""

from __future__ import annotations


class InputError(ValueError):
    """Bad input: one sentence that says what, where, and what was expected."""


class Interrupted(KeyboardInterrupt):
    """Stopped by Ctrl-C: one sentence that says what is kept and how to go on."""
