"""Where do recordings come from?"""
