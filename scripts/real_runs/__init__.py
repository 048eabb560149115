"""Real machines' runs: read as their authors recorded them, and judged as they judge."""
