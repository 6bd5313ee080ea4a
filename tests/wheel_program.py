"""What `make test-wheel` runs with the installed wheel: a recording, an estimate, its errors."""

from __future__ import annotations

import platform
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import pen_mhe as pm

MOST_DEG = 5.0


def main() -> None:
    """Simulate and estimate with every estimator; stop where one fails or is far off."""
    folder = Path(pm.__file__).resolve().parent
    assert folder.parent.name == "site-packages", f"{folder} is no installed package"
    recording = pm.simulate("reference", ["accel", "gyro", "camera"], duration_s=1.0)
    model = pm.pen_model(pm.load_pen("reference"), ["accel", "gyro", "camera"])
    for name in ("ekf", "mhe-rti", "mhe", "mhe-ipopt"):
        history = pm.run(pm.create_estimator(name, model), recording)
        assert history.solved_fraction == 1.0, f"{name}: solved {history.solved_fraction:.1%}"
        assert recording.truth is not None
        true = recording.truth.states(["elevation_rad"], history.time_s)[:, 0]
        error = np.degrees(np.abs(history.column("elevation_rad") - true)[-1])
        assert error < MOST_DEG, f"{name}: elevation {error:.2f} deg off at the end"
        print(f"{name}: elevation {error:.3f} deg off at the end")
    with TemporaryDirectory() as written:
        pm.export_c("ekf", model, Path(written))
        assert (Path(written) / "pen.c").is_file(), "the export wrote no pen.c"
    print(f"Python {platform.python_version()}, pen-mhe {pm.__version__}: the wheel works")


if __name__ == "__main__":
    main()
