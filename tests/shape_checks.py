"""While the tests run, every call of these packages is checked against its signature.

Shapes and dtypes by jaxtyping, all else by beartype; the fields of dataclasses likewise. A module
is checked if this is imported before it: conftest.py does so first.
"""

from beartype import BeartypeConf, beartype
from jaxtyping import install_import_hook

CHECKED = tuple(
    f"simsat.control.{name}"
    for name in ("ground", "interface", "model", "correction", "supervisor", "nmpc", "learned")
)

checked = beartype(conf=BeartypeConf(is_pep484_tower=True))  # an int is a float, as to mypy

install_import_hook(CHECKED, f"{__name__}.checked")
