"""What are a pen's sensors worth? Biases, scales and noise, found from recordings by themselves.

A way to calibrate is a file with a function of its own and a command of `commands.calibrate`:
`pen_mhe.calibration.still` from still poses.
"""
