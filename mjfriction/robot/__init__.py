"""A robot file in and out: the rigid bodies, the friction laws, the drives and their sensors, as one thing."""
