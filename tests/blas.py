"""One thread for linear algebra, set before numpy is loaded: on small matrices threads only wait for each other.

Commands that tests start inherit it.
"""

import os

for library in ("OPENBLAS", "OMP", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")
