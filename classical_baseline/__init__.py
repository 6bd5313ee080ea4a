"""What did the papers do without a model?"""
