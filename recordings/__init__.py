"""Where do recordings come from?

Readers of files and folders, tables to write, simulated recordings of pens, turntables and
models of one's own, thinning of camera frames::

    from recordings import read_recording, simulate

    recording = simulate("reference", ["accel", "gyro"], motion="turn", seed=1)
"""

from models.lazy import lazy_face

__getattr__, __dir__, __all__ = lazy_face(__name__, __file__)
