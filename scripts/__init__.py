"""Scripts that regenerate files of the project, run its benchmarks and show its use."""
