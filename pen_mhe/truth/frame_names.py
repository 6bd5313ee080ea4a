"""What may be said of a truth's frame."""

from __future__ import annotations

SAME, LEVEL, FREE = "same", "level", "free"
FRAMES = (SAME, LEVEL, FREE)
