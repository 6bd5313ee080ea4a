from suites.pen.turntable_starts import StartTrial as StartTrial
from suites.pen.turntable_starts import run_start as run_start
