"""A turned rod as an Arduino prints it, for the first page: python -m tests.rod_file FILE."""

from __future__ import annotations

import sys

import numpy as np

from tests.recordings.rods import turned_rod

MG = 9.80665e-3

if __name__ == "__main__":
    rod = turned_rod(1)
    rows = np.column_stack([1e3 * rod.time_s, rod.force / MG, np.degrees(rod.rate)])
    header = "millis,ax,ay,az,gx,gy,gz"
    np.savetxt(sys.argv[1], rows, "%.3f", ",", header=header, comments="")
