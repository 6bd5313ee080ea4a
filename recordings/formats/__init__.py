"""Readers of recordings, a file per format."""
