"""The commands of simsat by name: `simsat run ...`, as `python -m simsat.run ...`."""

import importlib
import runpy
import sys

COMMANDS = {
    "run": "fly one spacecraft once",
    "new": "write a spacecraft file from a mass table or inertia tensor and a wheel list",
    "replay": "play a torque profile open loop",
    "campaign": "fly many attitudes under several controllers and compare them",
    "verify": "fly what a folder holds again and compare",
    "bad_network_study": "fly bad networks with and without a supervisor",
    "learning.train": "train the network that corrects the torque on the wheels",
    "learning.train_appendage": "train the network of what bends or swings",
    "learning.data": "fly training flights and keep their telemetry",
}


def main() -> int:
    """List what there is, or run a command."""
    words = sys.argv[1:]
    if words and words[0] in COMMANDS:
        sys.argv = [f"simsat {words[0]}", *words[1:]]
        try:
            runpy.run_module(f"simsat.{words[0]}", run_name="__main__", alter_sys=True)
        except ImportError as error:  # a part that was not installed says what is missing
            print(f"error: {error}", file=sys.stderr)
            return 2
        return 0
    if words[:1] == ["--version"]:
        print(f"simsat {importlib.import_module('simsat').__version__}")
        return 0
    if words and words[0] not in ("--help", "-h"):
        names = ", ".join(COMMANDS)
        print(f"error: no command '{words[0]}'; there are: {names}", file=sys.stderr)
        return 2
    print(overview())
    return 0


def overview() -> str:
    """Commands, spacecraft and controllers, a line each."""
    from simsat.flight.controllers import CONTROLLERS  # half a second to import
    from simsat.mjcf.shipped import about, shipped_models

    parts = {
        "commands, `python -m simsat.NAME --help` tells more": COMMANDS,
        "spacecraft, --model NAME or an MJCF file": {m: about(m) for m in shipped_models()},
        "controllers, --controller NAME or your own, package.module:name": {
            name: (make.__doc__ or "").partition("\n")[0].rstrip(".")
            for name, make in CONTROLLERS.items()
        },
    }
    lines = ["simsat: fly an underactuated spacecraft in MuJoCo, and believe the numbers"]
    for title, entries in parts.items():
        width = max(map(len, entries))
        lines += ["", title, *(f"  {name:<{width}}  {text}" for name, text in entries.items())]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
