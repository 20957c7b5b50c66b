"""Mutants by the thousand: python -m tests.simsat.mjcf.fuzz.run --first 0 --count 3000.

Each is refused with one `ModelError`, or accepted, and then `oracle` must agree. Anything else,
another exception, an objection or no end within `PATIENCE_S`, is printed with the seed that makes
it again.
"""

import argparse
import collections
import faulthandler
import sys
import tempfile
import traceback
from pathlib import Path

from simsat.control.ground.errors import DivergedError, ModelError
from simsat.mjcf import read_model
from tests.simsat.mjcf.fuzz.mutants import mutant
from tests.simsat.mjcf.fuzz.oracle import objections

PATIENCE_S = 60


def judge(seed: int, folder: Path) -> tuple[str, str]:
    """('accepted' | 'refused' | what went wrong, details)."""
    text, what = mutant(seed)
    path = folder / "mutant.xml"
    path.write_text(text)
    try:
        model = read_model(path)
    except ModelError as error:
        return "refused", f"{what}: {error}".replace(str(path), "")
    except Exception:
        return "traceback", f"{what}\n{traceback.format_exc()}"
    try:
        found = list(objections(model))
    except DivergedError as error:
        return "diverged", f"{what}: {error}"
    except Exception:
        return "traceback in flight", f"{what}\n{traceback.format_exc()}"
    return ("wrong", f"{what}: {'; '.join(found)}") if found else ("accepted", what)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--show", default="", help="verdicts to print, all but accepted ... wrong")
    args = parser.parse_args()
    counts: collections.Counter[str] = collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(args.first, args.first + args.count):
            print(f"\rseed {seed}", end="", file=sys.stderr, flush=True)
            faulthandler.dump_traceback_later(PATIENCE_S, exit=True)  # MuJoCo hears no signal
            verdict, details = judge(seed, Path(folder))
            faulthandler.cancel_dump_traceback_later()
            counts[verdict] += 1
            if verdict not in ("accepted", "refused") or verdict in args.show.split(","):
                print(f"{seed} {verdict}: {details}", flush=True)
    print("", ", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items())))
    return 0 if counts.keys() <= {"accepted", "refused"} else 1


if __name__ == "__main__":
    sys.exit(main())
