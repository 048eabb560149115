"""Faults of the log itself, found by holding its columns against the model, before any cause is blamed."""
