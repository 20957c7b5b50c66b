"""Fly kept results again and compare them to the last bit: python -m simsat.verify FOLDER --help.

The folder is a run's, a replay's or a campaign's; exit code 0 says that everything is the same, 1
that something differs, 2 that there is nothing to compare.
"""

import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pyarrow.parquet as pq
import tyro
from tqdm import tqdm

from simsat.campaign.folder import IDENTITY
from simsat.campaign.rows import read_records, trajectory_path
from simsat.campaign.run import FAILED, CampaignRun, RunResult, fly_run, repeatable
from simsat.command import command, parse
from simsat.control.ground.errors import OutputError, SettingsError
from simsat.flight.loop import Ending
from simsat.flight.mission import Mission, prepare
from simsat.identity.difference import differences
from simsat.identity.flight import expected_identity, mission_identity
from simsat.parallel.pool import WorkerLostError, run_all
from simsat.parallel.processes import local_pool
from simsat.replay import ReplaySettings, prepare_replay
from simsat.results.comparing import Figures, Verification, compared, series_figures
