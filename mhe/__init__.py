"""What does the optimisation-based estimator say?

Three estimators of one window problem: `MheRti` makes one pass a sample, `Mhe` iterates to
convergence, `MheIpopt` hands the window to IPOPT and is the reference::

    from mhe import Mhe, MheConfig

    estimator = Mhe(model, MheConfig(horizon=10))
    state, estimate = estimator.step(estimator.init(), measurement)
"""

from models.lazy import lazy_face

__getattr__, __dir__, __all__ = lazy_face(__name__, __file__)
