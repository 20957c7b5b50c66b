"""Text files that users give: read whole, so only if they are files and not larger than memory."""

import os
from pathlib import Path

from simsat.control.ground.errors import SettingsError

SIZE_MAX = 50_000_000  # bytes: half a million attitudes; a device has no end


def read_given(path: Path, what: str) -> str:
    """The text of a file in UTF-8, with or without the mark that spreadsheets put in front.

    Raises `SettingsError` if it is no file, too large, or no such text; `what` names it.
    """
    try:
        if not os.path.isfile(path):
            raise SettingsError(f"no {what} at '{path}': give a file")
        if os.path.getsize(path) > SIZE_MAX:
            raise SettingsError(f"the {what} '{path}' is larger than {SIZE_MAX / 1e6:.0f} MB")
        return path.read_text("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise SettingsError(f"the {what} '{path}' can't be read as text ({error})") from error
