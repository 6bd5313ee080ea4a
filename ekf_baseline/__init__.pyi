from ekf_baseline.ekf import Ekf as Ekf
from ekf_baseline.ekf import EkfConfig as EkfConfig
from ekf_baseline.state import EkfState as EkfState
from ekf_baseline.ukf import Ukf as Ukf
from ekf_baseline.ukf import UkfConfig as UkfConfig
from ekf_baseline.ukf_state import UkfState as UkfState
