"""The experiments of the hydraulic document."""
