"""Killed at random moments, campaigns and runs lose nothing and leave no process."""

from pathlib import Path

import pytest

from tests.bench.kills import kill_campaigns, kill_runs

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not Path("/proc").exists(), reason="looks at processes through /proc"),
]


def test_campaigns_end_in_the_undisturbed_tables(tmp_path: Path) -> None:
    assert kill_campaigns(24, 0, tmp_path).total() == 24


def test_runs_leave_whole_files(tmp_path: Path) -> None:
    assert kill_runs(12, 0, tmp_path).total() == 12
