"""How does an estimator get onto a microcontroller?

As C99 without allocation and without libraries, in double or single precision::

    from codegen import export_c

    export_c("mhe-rti", model, "pen_c", real="float")
"""

from models.lazy import lazy_face

__getattr__, __dir__, __all__ = lazy_face(__name__, __file__)
