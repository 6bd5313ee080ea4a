"""Tests of the suite of a pen of one's own."""
