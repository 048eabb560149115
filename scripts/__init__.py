"""Chores that regenerate what the project ships."""
