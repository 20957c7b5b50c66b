"""The learned layer: data, training, report. It never imports the closed loop in its core files.

One thread for matrix products, where nothing else was asked for: they are small, and the weights
must not depend on the number of cores. It counts only if NumPy was not imported before.

Raises `ImportError` without PyTorch, which only training needs.
"""

import os
from importlib.util import find_spec

from simsat.starting import begin_command

begin_command()

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

if find_spec("torch") is None:
    raise ImportError(
        "training needs PyTorch, which flying doesn't: pip install 'simsat[learning]', "
        "or make setup in a checkout",
        name=__name__,  # so that python -m prints this sentence instead of a traceback
    )
