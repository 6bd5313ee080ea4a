"""What is a measurement, what is an estimate?

Recordings, estimates and their history, what an estimator is, the loop that drives every one,
and how to judge them: consistency (NIS, NEES) and observability::

    from estimation import nis, run

    history = run(estimator, recording)
    squared, rows = nis(history)
"""

from models.lazy import lazy_face

__getattr__, __dir__, __all__ = lazy_face(__name__, __file__)
