"""The suite `own-pen`: the question of the benchmark, of a pen of one's own."""
