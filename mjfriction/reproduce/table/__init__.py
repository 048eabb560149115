"""The experiments of the pre-sliding document."""
