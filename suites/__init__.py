"""Which sensors, which estimator?

One folder a question. What a terminal runs whole, some tasks at a time::

    from suites import run_some

    pens = run_some("pen", [("rest", "accel+gyro", "ekf", 2)])
    pens.results.rows, pens.verdicts()
"""

from models.lazy import lazy_face

__getattr__, __dir__, __all__ = lazy_face(__name__, __file__)
