from suites.some_tasks import SuiteRun as SuiteRun
from suites.some_tasks import run_some as run_some
