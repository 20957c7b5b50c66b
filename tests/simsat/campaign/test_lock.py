"""A folder has one campaign at a time; a killed one's lock is nobody's."""

import errno
import fcntl
import subprocess
import sys
from pathlib import Path

import pytest

from simsat.campaign.lock import locked
from simsat.control.ground.errors import OutputError
from tests.places import ROOT

HOLD = """
import sys
from pathlib import Path
from simsat.campaign.lock import locked
with locked(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""


def test_a_second_process_is_refused_until_the_first_is_gone_even_killed(tmp_path: Path) -> None:
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT,
    )  # fmt: skip
    with holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "held\n"
        with (
            pytest.raises(OutputError, match=f"is in use by process {holder.pid} on .*: wait"),
            locked(tmp_path),
        ):
            pass
        holder.kill()
    with locked(tmp_path):
        pass
    with locked(tmp_path):  # and it is given back
        pass


def test_a_file_system_without_locks_is_warned_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(handle: int, how: int) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", refuse)
    with locked(tmp_path):
        pass
    assert "can't be locked here; start nothing else in it" in capsys.readouterr().err


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="needs a folder nobody can write")
def test_a_folder_that_cannot_be_written_is_bad_input() -> None:
    with (
        pytest.raises(OutputError, match="can't write in the folder '/proc/self': "),
        locked(Path("/proc/self")),
    ):
        pass
