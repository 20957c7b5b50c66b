"""summary.png shows what was flown."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from simsat.control.ground.attitude import from_axis_angle
from simsat.flight.loop import Ending
from simsat.replay import ReplaySettings, prepare_replay
from simsat.results.pictures.summary_picture import draw_summary
from tests.reference_cases import NO_TORQUE

TURN = np.array([0.0, 0.0, 1.0])


def draw(
    folder: Path, from_deg: float, deg_s: float, duration_s: float, ending: Ending = Ending.COMPLETE
) -> Figure:
    """The picture of a replay that turns about body z and nobody steers."""
    profile = folder / "turn.npz"
    q, omega = from_axis_angle(TURN, np.radians(from_deg)), np.radians(deg_s) * TURN
    np.savez(profile, u=np.zeros((round(2 * duration_s), 2)), dt_u=0.5, q0=q, w0=omega)
    mission = prepare_replay(ReplaySettings(profile, environment=NO_TORQUE))
    flight = mission.fly()
    flight.ending = ending
    return draw_summary(flight, mission)


def test_the_error_s_curves_do_not_jump(tmp_path: Path) -> None:
    """Two turns: q_0 falls to nearly -1 and comes back, where a sign by q_0 >= 0 would jump."""
    figure = draw(tmp_path, 0.0, 18.0, 40.0)
    curves = np.array([line.get_ydata() for line in figure.axes[0].lines])
    assert curves[0].min() < -0.9
    assert np.abs(np.diff(curves)).max() < 0.01  # half of 18 deg/s in 0.05 s: 0.008


@pytest.mark.parametrize(
    ("flight", "label"),
    [
        ((-2.017, 0.1, 22.0), ["settled, 15.2 s"]),
        ((-2.017, 0.1, 22.0, Ending.DIVERGED), []),
        ((-8.2, 1.0, 8.0), []),  # below 0.5 deg, but in passing
    ],
)
def test_what_has_converged_is_drawn_as_settled(
    flight: tuple[float, float, float], label: list[str], tmp_path: Path
) -> None:
    figure = draw(tmp_path, *flight)
    assert figure.axes[1].get_legend_handles_labels()[1] == ["0.5 deg", *label]
