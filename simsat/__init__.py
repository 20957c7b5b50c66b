"""Fly an underactuated spacecraft in MuJoCo, and believe the numbers."""

import importlib.util
import sys
from pathlib import Path


def _refuse_foreign_control() -> None:
    """python-control is imported by the same name as our `control`; say so where it comes first."""
    spec = importlib.util.find_spec("control")
    ours = Path(__file__).resolve().parents[1] / "control"
    found = Path(spec.origin).resolve().parent if spec and spec.origin else None
    if found == ours:
        return
    sentence = (
        f"'import control' finds {found} instead of simsat's own package in {ours}: run from the "
        "project's folder, or remove python-control from this environment"
    )
    if sys.argv[0] == "-m":  # python -m simsat...: one sentence, no traceback
        print(f"error: {sentence}", file=sys.stderr)
        raise SystemExit(2)
    raise ImportError(sentence)


_refuse_foreign_control()
