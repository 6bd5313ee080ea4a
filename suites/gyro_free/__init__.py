"""Suite ``gyro-free``: two accelerometers on the axis, no gyroscope."""
