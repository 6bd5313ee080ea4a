"""Does optimisation pay where the start is wrong?"""
