"""Runs tasks in processes or on a cluster, and keeps what they found."""
