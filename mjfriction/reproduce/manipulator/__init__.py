"""The experiments of the manipulator document."""
