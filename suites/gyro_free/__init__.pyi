from suites.gyro_free import gesture as gesture
from suites.gyro_free import readings as readings
from suites.gyro_free.cases import CASES as CASES
from suites.gyro_free.cases import NO_ROLL as NO_ROLL
from suites.gyro_free.cases import TEST_CASE as TEST_CASE
from suites.gyro_free.cases import TWO_ACCELS as TWO_ACCELS
from suites.gyro_free.scores import angle_between as angle_between
