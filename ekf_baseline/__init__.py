"""What does the linearised estimator say?

The extended Kalman filter, one stage a measurement::

    from ekf_baseline import Ekf

    estimator = Ekf(model)
    state, estimate = estimator.step(estimator.init(), measurement)
"""

from models.lazy import lazy_face

__getattr__, __dir__, __all__ = lazy_face(__name__, __file__)
