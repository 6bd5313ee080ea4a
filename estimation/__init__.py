"""What is a measurement, what is an estimate?"""
