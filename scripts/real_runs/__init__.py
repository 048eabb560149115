"""Runs of real machines: read as their authors recorded them, and evaluated as they evaluate them."""
