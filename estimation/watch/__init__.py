"""Running tests of what an estimator is told: does it fit, and is the estimate still known?"""
