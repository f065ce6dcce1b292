"""Linear algebra on one thread in each of the suite's workers: two at a time that take all cores wait for each other, and
small systems of equations take twenty times as long.  Imported before numpy is.
"""

import os

for library in ("OPENBLAS", "MKL", "OMP"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")
