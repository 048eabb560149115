"""Logs as input: reading and checking them, and estimating the motion they recorded."""
