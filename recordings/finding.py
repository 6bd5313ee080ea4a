"""What is wrong with a recording, or may be: an entry of a list that a reader or a check makes."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """Something that an estimate may suffer from.

    Parameters
    ----------
    what : in words: ``the accelerometer has no gravity in it``
    where : file, columns or sensor: ``accel``
    sure : how sure that is, 0 to 1
    remedy : what to do
    """

    what: str
    where: str
    sure: float
    remedy: str

    def sentence(self) -> str:
        """Return it as one sentence."""
        how = "" if self.sure > 0.9 else ", probably"
        return f"{self.where}: {self.what}{how}; {self.remedy}"
