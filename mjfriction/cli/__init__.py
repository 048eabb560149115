"""The command line, one file per verb."""

import os

# Matrices are small here: threads within each product only wait for one another, and several commands beside each other
# would take five times as long.  It must be said before numpy is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
