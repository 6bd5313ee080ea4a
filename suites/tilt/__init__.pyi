from suites.tilt.cases import CASES as CASES
from suites.tilt.samples import CONVERSION as CONVERSION
from suites.tilt.samples import simulate_samples as simulate_samples
from suites.tilt.scores import roll_error_deg as roll_error_deg
