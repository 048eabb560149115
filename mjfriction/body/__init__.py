"""Rigid-body dynamics; the only package that imports Pinocchio."""
