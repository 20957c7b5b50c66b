"""While the tests run, every call of these packages is checked against its signature.

Shapes and dtypes by jaxtyping, all else by beartype; the fields of dataclasses likewise. A module
is checked if this is imported before it: conftest.py does so first.

`learned` is left out: a flight of the learned planner takes 2.3 times as long with it, 1.4 without.
So are modules with settings, which refuse in their own words, and `interface`, where garbage comes
in.
"""

from beartype import BeartypeConf, beartype
from jaxtyping import install_import_hook

CHECKED = tuple(
    f"simsat.control.{name}"
    for name in (
        "ground", "model", "correction.features", "correction.network", "supervisor.lyapunov",
        "supervisor.plan_value", "supervisor.supervisors", "supervisor.health", "nmpc.problem",
        "nmpc.guess",
    )
)  # fmt: skip

checked = beartype(conf=BeartypeConf(is_pep484_tower=True))  # an int is a float, as to mypy

install_import_hook(CHECKED, f"{__name__}.checked")
