"""What goes through the pipe is in the file; where it can't be, nobody waits for ever."""

import subprocess
import sys
from pathlib import Path

import pytest

from simsat.recording.outlet import Outlet
from tests.places import ROOT

SENT = bytes(range(256)) * 4000  # a megabyte: more than a pipe holds


def sent_through(path: Path) -> Outlet:
    outlet = Outlet(path)
    with open(outlet.name, "wb") as pipe:
        outlet.taken()
        pipe.write(SENT)
    outlet.close()
    return outlet


def test_everything_that_is_written_arrives(tmp_path: Path) -> None:
    assert not sent_through(tmp_path / "file").lost
    assert (tmp_path / "file").read_bytes() == SENT


@pytest.mark.parametrize("limit", [0, 1, 300_000])
def test_a_file_that_can_t_grow_is_removed_and_the_rest_is_let_through(
    limit: int, tmp_path: Path
) -> None:
    """In a process of its own, whose files may not grow beyond the limit."""
    script = (
        "import resource, sys; from pathlib import Path\n"
        "from tests.simsat.recording.test_outlet import sent_through\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]), 1_000_000_000))\n"
        "print(sent_through(Path(sys.argv[2])).lost)\n"
    )
    path = tmp_path / "file"
    answer = subprocess.run(
        [sys.executable, "-c", script, str(limit), str(path)],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert answer.stdout.strip() == "True"
    assert not path.exists()


def test_a_file_that_can_t_be_made_is_lost_at_once(tmp_path: Path) -> None:
    assert sent_through(tmp_path / "nowhere" / "file").lost
