from mhe.arrival_cost import ARRIVAL_COSTS as ARRIVAL_COSTS
from mhe.config import MheConfig as MheConfig
from mhe.realtime import Mhe as Mhe
from mhe.realtime import MheRti as MheRti
from mhe.reference.ipopt import MheIpopt as MheIpopt
from mhe.trajectory import Trajectory as Trajectory
from mhe.trajectory import WindowSolution as WindowSolution
