"""Machines that play the real one: a robot file in closed loop along a trajectory, and what its sensors say."""
