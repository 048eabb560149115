"""A yardstick for naming the cause of a gap between model and machine: cases with hidden effects, and their scoring.

The diagnosis may not import anything of this room.
"""
