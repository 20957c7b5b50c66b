"""A campaign's folder: made once, held by one process at a time, resumed only by the same campaign.

`campaign.json` holds what decides the numbers: flight settings, controllers, attitudes, the study's
points, and for each of these under each controller what it is flown with (`simsat.identity`).
`settings.json` says how it was started, as in any run.
"""

import contextlib
import json
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from simsat.campaign.attitudes import InitialRotation
from simsat.campaign.lock import LOCK, locked
from simsat.campaign.run import CampaignRun
from simsat.campaign.study import label
from simsat.control.ground.errors import OutputError
from simsat.identity.code import computing
from simsat.identity.difference import differences
from simsat.results.files import PART, write_json
from simsat.results.folder import SETTINGS, make_folder, write_settings
from simsat.settings import CommonSettings, as_json

IDENTITY = "campaign.json"
FLOWN_WITH = "flown_with"


def identity(
    common: CommonSettings,
    controllers: tuple[str, ...],
    starts: tuple[InitialRotation, ...],
    runs: tuple[CampaignRun, ...],
) -> dict[str, Any]:
    """What makes two campaigns the same, as plain JSON."""
    points = {label(run.point): run.point for run in runs}.values()
    kinds = {(label(run.point), run.settings.controller): run for run in runs}.values()
    return {
        "controllers": list(controllers),
        "attitudes": as_json([asdict(start) for start in starts]),
        "study": as_json(list(points)),
        "flight": as_json(common),
        FLOWN_WITH: [run.flown_with for run in kinds],
    }


@contextlib.contextmanager
def open_folder(
    out: Path | None, resume: bool, mine: dict[str, Any], settings: Any
) -> Iterator[Path]:
    """A new folder, or with `resume` the one that this very campaign began; locked in the block.

    Raises `OutputError` if it exists, is in use, or if another campaign made it, saying what
    differs.
    """
    if out is None or not resume or not out.exists():
        folder = make_folder(out, "campaign")
    elif out.is_dir() and _is_campaign(out):
        folder = out
    else:
        raise OutputError(f"'{out}' is no campaign's folder: it has no {IDENTITY}")
    with locked(folder):
        _begin_or_go_on(folder, mine, settings)
        yield folder


def _is_campaign(folder: Path) -> bool:
    """Whether it has a campaign's identity, or nothing but what is written before that."""
    names = {path.name for path in folder.iterdir()}
    before = {LOCK, SETTINGS, SETTINGS + PART, IDENTITY + PART}
    return IDENTITY in names or names <= before


def _begin_or_go_on(folder: Path, mine: dict[str, Any], settings: Any) -> None:
    """Say in the folder what it is for, or see that it says so; a damaged file is written anew."""
    theirs = _read(folder / IDENTITY, mine)
    if theirs is not None:
        _refuse_other(folder, theirs, mine)
    if _read(folder / SETTINGS, {"settings": {}, FLOWN_WITH: {}, "versions": {}}) is None:
        write_settings(folder, settings, computing())
    if theirs is None:
        write_json(folder / IDENTITY, mine)


def _read(path: Path, like: dict[str, Any]) -> dict[str, Any] | None:
    """None if it isn't there or hasn't parts like these. Every row says itself what it is, and is
    checked when the campaign goes on: nothing hangs on this file."""
    if not path.exists():
        return None
    try:
        content = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError) as error:
        print(f"'{path}' can't be read ({error}): it is written anew")
        return None
    if not isinstance(content, dict) or not all(
        isinstance(content.get(name), type(part)) for name, part in like.items()
    ):
        print(f"'{path}' holds something else: it is written anew")
        return None
    return content


def _refuse_other(folder: Path, theirs: dict[str, Any], mine: dict[str, Any]) -> None:
    differing = [
        phrase
        for name in dict.fromkeys([*theirs, *mine])
        if name != FLOWN_WITH
        for phrase in setting_differences(theirs.get(name), mine.get(name), name)
    ]
    if differing:
        raise OutputError(
            f"'{folder}' was made with other settings ({'; '.join(differing)}); "
            "resume with its own, or choose a new --out"
        )
    pairs = zip(theirs[FLOWN_WITH], mine[FLOWN_WITH], strict=False)
    changed = dict.fromkeys(
        phrase for a, b in pairs if isinstance(a, dict) for phrase in differences(a, b)
    )
    if changed:
        raise OutputError(
            f"'{folder}' was flown with something else ({'; '.join(changed)}); "
            "put that back to resume, or choose a new --out"
        )


def setting_differences(theirs: Any, mine: Any, name: str = "") -> list[str]:
    """One phrase for each value that differs, named as on the command line."""
    if isinstance(theirs, dict) and isinstance(mine, dict):
        phrases = []
        for key in dict.fromkeys([*theirs, *mine]):
            inner = f"{name}.{key}" if name else key
            phrases += setting_differences(theirs.get(key), mine.get(key), inner)
        return phrases
    if theirs == mine:
        return []
    name = name.removeprefix("flight.")
    if isinstance(theirs, list) and isinstance(mine, list) and name == "attitudes":
        return [f"attitudes: {len(theirs)} then, {len(mine)} now, or in other places"]
    return [f"{name} was {_short(theirs)}, now {_short(mine)}"]


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
