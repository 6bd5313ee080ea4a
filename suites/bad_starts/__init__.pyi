from suites.bad_starts.cases import CASES as CASES
from suites.bad_starts.cases import case_model as case_model
from suites.bad_starts.cases import case_recording as case_recording
from suites.bad_starts.run import run_bad_start as run_bad_start
