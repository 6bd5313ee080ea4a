"""A recording without a pen file: what it shows of its sensors, and a pen file that says so.

`pen_mhe.no_pen.pen_for.pen_for` finds the pen, `pen_mhe.no_pen.which.pen_of` says which pen a
recording is estimated with where nobody names one.
"""
