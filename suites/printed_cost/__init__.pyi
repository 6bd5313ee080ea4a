from suites.printed_cost.run import AS_PRINTED as AS_PRINTED
from suites.printed_cost.run import DURATION_S as DURATION_S
from suites.printed_cost.run import MODELS as MODELS
from suites.printed_cost.run import RIGID_BODY as RIGID_BODY
from suites.printed_cost.run import SPEEDS as SPEEDS
from suites.printed_cost.run import accelerometer_error as accelerometer_error
from suites.printed_cost.run import paper_pen as paper_pen
from suites.printed_cost.run import simulated as simulated
