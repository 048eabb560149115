"""The hidden effects, a file for each part of the machine."""
