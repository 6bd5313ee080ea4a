"""How does an estimator get onto a microcontroller?

As C99 without allocation and without libraries, in double or single precision::

    from codegen import export_texts, write_export

    write_export(export_texts("mhe-rti", model, real="float"), "pen_c")
"""

from models.lazy import lazy_face

__getattr__, __dir__, __all__ = lazy_face(__name__, __file__)
