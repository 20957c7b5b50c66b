"""While the tests run, every call of these packages is checked against its signature.

Shapes and dtypes by jaxtyping, all else by beartype; the fields of dataclasses likewise. A module
is checked if this is imported before it: conftest.py does so first.

`learned` is left out: a flight of the learned planner takes 2.3 times as long with it, 1.4 without.
"""

from beartype import BeartypeConf, beartype
from jaxtyping import install_import_hook

CHECKED = tuple(
    f"simsat.control.{name}" for name in ("ground", "model", "correction", "supervisor", "nmpc")
)

checked = beartype(conf=BeartypeConf(is_pep484_tower=True))  # an int is a float, as to mypy

install_import_hook(CHECKED, f"{__name__}.checked")
