"""Friction laws inside MuJoCo: the only package that imports MuJoCo."""
