"""Checks of a recording: what an estimate of it may suffer from, a small file each."""
