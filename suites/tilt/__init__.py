"""What is a model worth for a tilt, against fusion with a fixed weight?

The suite `tilt`. What a carrier that turns reads, and how far off a direction is::

    from suites.tilt import CASES, roll_error_deg, simulate_samples

    samples = simulate_samples(CASES["full turn"], seed=0)
    roll_error_deg(samples, samples.direction)
"""

from models.lazy import lazy_face

__getattr__, __dir__, __all__ = lazy_face(__name__, __file__)
