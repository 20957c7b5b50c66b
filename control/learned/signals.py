"""The learned controller's curves for the recording."""

import numpy as np

from ..ground.attitude import rotation_matrix
from .guidance.drift import unactuated_error
from .guidance.task import GuidanceTask
from .guidance.trajectory import Trajectory
from .prediction.selection import ModelSelection, PredictionModel
from .prediction.state import PlanningState


def signals_of(
    task: GuidanceTask, state: PlanningState, trajectory: Trajectory, selection: ModelSelection
) -> dict[str, float]:
    """By name with the unit; those about the unactuated axis only where there is one."""
    signals = {
        "time_to_go_s": len(trajectory.torque) * task.period,
        "terminal_error_rad": trajectory.terminal_error,
        "filter_restarts": float(state.estimate.restarts),
        "prediction_model": float(list(PredictionModel).index(selection.selected)),
    }
    for model, rise in selection.value_rise.items():
        signals[f"value_rise_{model.name.lower()}_deg"] = np.rad2deg(rise)
    n = state.model.spacecraft.unactuated
    if n is not None:
        along = n @ rotation_matrix(state.q).T @ state.model.h_N
        signals |= {
            "unactuated_momentum_Nms": float(along),
            "phi_n_deg": np.rad2deg(unactuated_error(state.model, state.q, task.target)),
            "arrival_bias_deg": np.rad2deg(trajectory.bias),
        }
    return signals
