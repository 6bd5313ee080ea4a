"""The exceptions that a person reads: for input that can be mended, and for an interrupt."""

from __future__ import annotations

from models.shown_text import one_line


class InputError(ValueError):
    """Bad input: one sentence that says what, where, and what was expected.

    Whatever a file puts into it, it is one line that a terminal only shows.
    """

    def __init__(self, sentence: str = "") -> None:
        super().__init__(one_line(sentence))


class UnforeseenError(InputError):
    """Bad input that no check foresaw; its cause is what was raised where it was read."""


class Interrupted(KeyboardInterrupt):
    """Stopped by Ctrl-C: one sentence that says what is kept and how to go on."""
