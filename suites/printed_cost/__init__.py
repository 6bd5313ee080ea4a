"""What do the errors of the paper's equations cost?"""
