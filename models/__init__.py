"""What moves, and what does a sensor on it read?"""
