"""The command line, one file per verb."""

import os

# The matrices are small: threads within a product mostly wait for one another, and several commands in parallel would
# take five times as long.  This must be set before numpy is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
