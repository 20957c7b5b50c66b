"""The learned layer: data, training, report. It never imports the closed loop in its core files.

One thread for matrix products, where nothing else was asked for: they are small, and the weights
must not depend on the number of cores. It counts only if NumPy was not imported before.
"""

import os

from simsat.starting import begin_command

begin_command()

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
