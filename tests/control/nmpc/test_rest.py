"""Where a craft can rest: the momentum lies in the wheels' plane there, and no nearer attitude does
it."""

from dataclasses import replace

import numpy as np
import pytest

from simsat.control.ground import attitude
from simsat.control.nmpc.planner import NmpcSettings, PlanStatus, build_nmpc
from simsat.control.nmpc.rest import coning_angle, nearest_rest
from tests.control.nmpc.test_nmpc import measured
from tests.ocp_cases import THREE_WHEELS, TWO_WHEELS, spacecraft

SKEWED = spacecraft(attitude.normalized(np.array([[1.0, 0.2], [0.3, 1.0], [0.1, -0.4]]).T).T)


@pytest.mark.parametrize("seed", range(8))
def test_the_wheels_hold_all_momentum_at_the_nearest_rest(seed: int) -> None:
    rng = np.random.default_rng(seed)
    craft = TWO_WHEELS if seed % 2 else SKEWED
    target, H_N = attitude.normalized(rng.normal(size=4)), 0.3 * rng.normal(size=3)
    rest = nearest_rest(craft, target, H_N)
    n = craft.unactuated
    assert n is not None
    assert rest is not None
    assert n @ attitude.rotation_matrix(rest).T @ H_N == pytest.approx(0.0, abs=1e-12)  # Nms
    nearest = float(attitude.error_angle(rest, target))
    for _ in range(200):  # a smaller turn about any axis leaves momentum along n
        smaller = attitude.from_axis_angle(rng.normal(size=3), 0.98 * nearest)
        H_B = attitude.rotation_matrix(attitude.multiply(target, smaller)).T @ H_N
        assert abs(n @ H_B) > 0.0
        assert np.sign(n @ H_B) == np.sign(n @ attitude.rotation_matrix(target).T @ H_N)


def test_momentum_along_the_unactuated_axis_asks_for_a_quarter_turn() -> None:
    rest = nearest_rest(TWO_WHEELS, attitude.IDENTITY, np.array([0.0, 0.0, 0.1]))
    assert rest is not None
    assert attitude.error_angle(rest, attitude.IDENTITY) == pytest.approx(np.pi / 2)


def test_the_target_itself_stands_where_it_can_be_held() -> None:
    """No momentum, momentum in the wheels' plane, little along n, or wheels on every axis."""
    identity = attitude.IDENTITY
    assert nearest_rest(TWO_WHEELS, identity, np.array([0.0, 0.0, 0.0])) is None
    assert nearest_rest(TWO_WHEELS, identity, np.array([0.0, 0.0, 1e-3])) is None
    assert nearest_rest(THREE_WHEELS, identity, np.array([0.1, 0.2, 0.3])) is None
    in_plane = nearest_rest(TWO_WHEELS, identity, np.array([0.3, 0.4, 0.0]))
    assert in_plane is None or attitude.error_angle(in_plane, identity) < 1e-9


def test_coning_grows_with_the_spin_as_the_equation_says() -> None:
    assert np.degrees(coning_angle(TWO_WHEELS, np.radians(1.0))) == pytest.approx(20.0, abs=2.0)
    assert coning_angle(TWO_WHEELS, 8e-3) == pytest.approx(4.0 * coning_angle(TWO_WHEELS, 1e-3))
    strong = replace(TWO_WHEELS, torque_max=np.full(2, 0.4))
    assert coning_angle(strong, 1e-3) == pytest.approx(0.5 * coning_angle(TWO_WHEELS, 1e-3))


def test_a_planner_says_that_it_makes_for_the_nearest_rest() -> None:
    """A spinning bus; the decision stays while the plan goes on."""
    planner = build_nmpc(TWO_WHEELS, NmpcSettings(), attitude.IDENTITY)
    spinning = measured(attitude.IDENTITY, np.radians([0.0, 0.0, 5.0]))
    plan, memory = planner.plan(spinning, None)
    assert plan.status is PlanStatus.NEAREST_REST
    assert memory is not None
    again, _ = planner.plan(measured(attitude.IDENTITY), memory)
    assert again.status is PlanStatus.NEAREST_REST
    assert np.max(np.abs(again.torque)) > 0.01  # Nm: it turns away from the target
