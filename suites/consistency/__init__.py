"""Can one trust the standard deviations?"""
