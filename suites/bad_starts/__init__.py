"""Does optimisation pay where the start is wrong?

One run of one estimator, and what it is made of::

    from suites.bad_starts import CASES, run_bad_start

    run_bad_start(CASES["held-60"], "ekf", seed=0).error
"""

from models.lazy import lazy_face

__getattr__, __dir__, __all__ = lazy_face(__name__, __file__)
