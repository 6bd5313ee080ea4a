"""Twenty still poses of a board, for the page about them: python -m tests.poses_file FILE."""

from __future__ import annotations

import sys
from pathlib import Path

import pen_mhe as pm
from recordings.formats.tables import recording_to_table, write_table
from tests.pen_mhe.calibration.poses import TWENTY, board

if __name__ == "__main__":
    recording = board(1, TWENTY, rest_s=2.0).recording
    write_table(recording_to_table(recording, pm.load_pen("reference")), Path(sys.argv[1]))
