"""Do two accelerometers on the axis stand in for a gyroscope?

The suite `gyro-free`. One gesture, and what the two accelerometers read::

    from suites.gyro_free import CASES, TEST_CASE, gesture, readings

    case = CASES[TEST_CASE]
    motion = gesture.gesture(case.gesture, seed=0)
    f1, f2 = readings.readings(motion, case.half_distance_m, case.reading_errors, seed=0)
"""

from models.lazy import lazy_face

__getattr__, __dir__, __all__ = lazy_face(__name__, __file__)
