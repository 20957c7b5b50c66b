"""python -m simsat.campaign."""

import sys

from simsat.campaign.command import main
from simsat.command import command

sys.exit(command(main))
