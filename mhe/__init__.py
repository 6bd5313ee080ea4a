"""What does the optimisation-based estimator say?"""
