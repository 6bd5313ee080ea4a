"""How fast is an estimator, against others on identical windows?"""
