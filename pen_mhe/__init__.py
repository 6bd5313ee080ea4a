"""Which motion sensors does a pen need, and what do estimators make of them?

One symbolic model, several estimators: a Kalman filter (``ekf``) and moving-horizon estimators
(``mhe``, ``mhe-rti``, ``mhe-ipopt``). From sensors to a table of errors::

    import pen_mhe as pm

    pen = pm.load_pen("reference")  # or the path of a pen file
    sensors = ["accel", "gyro", "camera"]
    recording = pm.simulate(pen, sensors, motion="turn", duration_s=0.5, seed=1)
    model = pm.pen_model(pen, sensors)

    histories = {
        name: pm.run(pm.create_estimator(name, model), recording) for name in ("ekf", "mhe")
    }
    compared = pm.compare(histories, recording.truth)
    print(compared)  # errors, claimed deviations, times; compared.table, compared.figure

    table = histories["mhe"].to_pandas()  # a row per instant: states, deviations, status
    print(table[["time_s", "tip_x_m", "tip_x_m_std", "status"]].tail())

Of a recording that you have: `read_recording`, and `estimate` for all of it in one call; without a
pen file it finds one, as `pen_for` does. What a
choice of sensors can see at all: `observe`. A model of your own, without a pen: `own_model`. C for
a microcontroller: `export_c`. One sample at a time, live: ``estimator.step(state, measurement)``.

States end in their unit (``tip_x_m``, ``azimuth_rad``); their standard deviations in ``_std``.
What goes wrong in a step is said in its `Status`; bad input raises `InputError`, with a sentence.
More of each kind is in the rooms: ``from mhe import …``, ``models``, ``estimation``,
``ekf_baseline``, ``classical_baseline``, ``recordings``, ``codegen``.
"""

from pen_mhe.shadowed import check_rooms

check_rooms(__file__)  # before the first import of another room

from models.lazy import lazy_face  # noqa: E402

__getattr__, __dir__, __all__ = lazy_face(__name__, __file__)
