"""How does an estimator get onto another machine?"""
