"""A benchmark for naming the cause of a gap between model and machine: cases with hidden effects, and their scoring.

The diagnosis must not import anything from this package.
"""
