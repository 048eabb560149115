"""Simulated machines in place of real ones: a robot file in closed loop along a trajectory, and its sensor readings."""
