"""What does the linearised estimator say?"""
