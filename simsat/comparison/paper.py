"""The paper's own results, for tables that stand beside them: 100 simulations each, degrees.

Source: the paper, table 1 (aggregates) and the improvements its text states.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class PaperColumn:
    """One controller's column of the paper's table; mean and deviation over its runs."""

    steady_state_mean: float
    steady_state_deviation: float
    steady_state_maximum: float
    final_mean: float
    final_deviation: float
    final_maximum: float


PAPER_TABLE = {
    "nmpc": PaperColumn(0.1476, 0.0672, 0.4940, 0.0870, 0.0704, 0.4915),
    "nmpc-pinn": PaperColumn(0.1385, 0.0437, 0.3392, 0.0722, 0.0452, 0.1607),
    "nmpc-pinn-supervisor": PaperColumn(0.1419, 0.0495, 0.3747, 0.0759, 0.0497, 0.2315),
}
"""By the name that the controller has here."""

PAPER_IMPROVEMENT = {
    "nmpc-pinn": PaperColumn(6.13, 35.01, 31.35, 16.93, 35.77, 67.30),
    "nmpc-pinn-supervisor": PaperColumn(3.82, 26.32, 24.16, 12.74, 29.42, 52.90),
}
"""Percent of the baseline, as the paper states them (from figures before rounding)."""
