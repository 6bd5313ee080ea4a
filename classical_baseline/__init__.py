"""What did the papers do without a model?

Fusion with a fixed weight for the turntable, and integration of a rate that accelerometers
alone give (gyro-free)::

    from classical_baseline import FixedWeightConfig, fixed_weight

    tilts = fixed_weight.run(FixedWeightConfig(weight=0.25), time_s, acceleration, rates)
"""

from models.lazy import lazy_face

__getattr__, __dir__, __all__ = lazy_face(__name__, __file__)
