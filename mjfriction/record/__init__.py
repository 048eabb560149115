"""A log in: reading, checking, and estimating the motion it recorded."""
