"""Which of accelerometer, gyroscope and camera does a pen need?

The suite `pen`: the turntable experiment of [Pen], and the same question on the whole pen. One bad
start on the turntable by itself::

    from suites.pen import StartTrial, run_start

    run_start(StartTrial("accel+gyro", "ekf", start_error_rad=1.0), seed=0).outcome
"""

from models.lazy import lazy_face

__getattr__, __dir__, __all__ = lazy_face(__name__, __file__)
