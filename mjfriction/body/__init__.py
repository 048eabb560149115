"""Rigid-body terms; the only room that imports Pinocchio."""
