from ekf_baseline.ekf import Ekf as Ekf
from ekf_baseline.ekf import EkfConfig as EkfConfig
from ekf_baseline.state import EkfState as EkfState
