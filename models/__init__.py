"""What moves, and what does a sensor on it read?

Pens and turntables as data, the state-space model that every estimator reads, models of one's
own, motions and the simulation of readings::

    from models import load_pen, pen_model

    model = pen_model(load_pen("reference"), ["accel", "gyro", "camera"])
"""

from models.lazy import lazy_face

__getattr__, __dir__, __all__ = lazy_face(__name__, __file__)
