"""What do the errors of the paper's equations cost?

The paper's pen with and without its errors, and how far its accelerometer is off::

    from suites.printed_cost import DURATION_S, MODELS, paper_pen, simulated

    pens = {name: paper_pen(errors) for name, errors in MODELS.items()}
    recording = simulated(1.0, 0, DURATION_S)
"""

from models.lazy import lazy_face

__getattr__, __dir__, __all__ = lazy_face(__name__, __file__)
