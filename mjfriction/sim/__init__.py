"""Friction laws inside MuJoCo: the only room that knows MuJoCo."""
