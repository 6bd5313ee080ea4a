"""The suite `pen`: the turntable experiment of [Pen], and the same question on the whole pen."""
