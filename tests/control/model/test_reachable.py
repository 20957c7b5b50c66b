"""Where a craft can rest: the wheels can hold the momentum there, and at no nearer attitude."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

from simsat.control.ground import attitude
from simsat.control.model.reachable import (
    Reach,
    coning_angle,
    envelope_share,
    nearest_rest,
    reachable,
)
from simsat.control.nmpc.planner import NmpcSettings, PlanStatus, build_nmpc
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


@pytest.mark.parametrize("scale", [1.0, 1e-4, 1e4])
def test_the_decision_is_the_same_for_a_craft_of_any_size(scale: float) -> None:
    """J x k, u x k, H x k is the same craft in other units of mass."""
    craft = replace(
        TWO_WHEELS,
        J=scale * TWO_WHEELS.J,
        Js=scale * TWO_WHEELS.Js,
        torque_max=scale * TWO_WHEELS.torque_max,
    )
    for spin_deg_s, reach in ((1.5, Reach.CONING), (2.5, Reach.NEAREST_REST)):
        H = craft.J @ np.radians([0.0, 0.0, spin_deg_s])
        assert reachable(craft, attitude.IDENTITY, H).reach is reach


def test_momentum_in_the_wheels_plane_rests_where_its_part_along_n_says() -> None:
    """asin(h_n / |H|): .29 deg for 0.2 and 1e-3 Nms."""
    target = attitude.normalized(np.array([0.5, -0.3, 0.2, 0.7]))
    H_N = attitude.rotation_matrix(target) @ np.array([0.16, 0.12, 1e-3])
    found = reachable(TWO_WHEELS, target, H_N)
    assert found.reach is Reach.NEAREST_REST
    assert found.angle == pytest.approx(np.arcsin(1e-3 / np.hypot(0.2, 1e-3)))
    assert found.attitude is not None
    assert attitude.error_angle(found.attitude, target) == pytest.approx(found.angle)
    assert "0.001 Nms" in found.reason
    assert "0.286 deg" in found.reason


def test_momentum_along_n_alone_can_only_be_coned_around() -> None:
    """rho of 1e-3 Nms: s = h / Jnn, then (2 s)^(2/3) (J/u)^(1/3)."""
    found = reachable(TWO_WHEELS, attitude.IDENTITY, np.array([0.0, 0.0, 1e-3]))
    assert found.reach is Reach.CONING
    rho = (2.0 * 1e-3 / 1.2) ** (2 / 3) * ((1.5 + 1.6 + 1.2) / 3.0 / 0.05) ** (1 / 3)
    assert found.angle == pytest.approx(rho)
    assert "2.46 deg wide" in found.reason


def test_a_target_that_can_be_held_is_said_to_be() -> None:
    identity = attitude.IDENTITY
    for craft, H in (
        (TWO_WHEELS, [0.0, 0.0, 0.0]),
        (TWO_WHEELS, [0.3, 0.4, 0.0]),
        (TWO_WHEELS, [0.0, 0.0, 1e-17]),  # round-off of a start at rest
        (THREE_WHEELS, [0.1, 0.2, 0.3]),
    ):
        found = reachable(craft, identity, np.array(H))
        assert found.reach is Reach.TARGET
        assert found.angle == 0.0


def test_more_momentum_than_the_wheels_can_hold_leaves_nothing() -> None:
    """0.9 Nms a wheel: at right angles the envelope is a square, a cube or, of four, wider."""
    limit = 1.432394e-3 * 628.3
    for factor, reach in ((0.99, Reach.TARGET), (1.01, Reach.NOTHING)):
        for direction in ([1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.3, -1.0, 0.0]):
            H = factor * limit * np.array(direction)
            for craft in (TWO_WHEELS, THREE_WHEELS):
                assert reachable(craft, attitude.IDENTITY, H).reach is reach
    found = reachable(TWO_WHEELS, attitude.IDENTITY, np.array([0.0, 1.8, 0.0]))
    assert "1.8 Nms, 2 times" in found.reason
    one = spacecraft(np.eye(3)[:, :1])
    zero = np.array([0.0, 0.0, 0.0])
    assert reachable(one, attitude.IDENTITY, zero).reach is Reach.NOTHING


@pytest.mark.parametrize("seed", range(5))
def test_the_envelope_is_what_linear_programming_finds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for wheels, flat in ((2, True), (3, False), (4, False), (3, True), (6, False)):
        A = rng.normal(size=(3, wheels)) * np.array([1.0, 1.0, 0.0 if flat else 1.0])[:, None]
        craft = spacecraft(A / np.linalg.norm(A, axis=0))
        H = A @ rng.normal(size=wheels)
        room = craft.momentum_max
        best = linprog(  # least t with A p = H, |p_i| <= t room_i
            np.r_[np.zeros(wheels), 1.0],
            A_eq=np.c_[craft.A, np.zeros(3)],
            b_eq=H,
            A_ub=np.block([[np.eye(wheels), -room[:, None]], [-np.eye(wheels), -room[:, None]]]),
            b_ub=np.zeros(2 * wheels),
            bounds=(None, None),
        )
        assert envelope_share(craft, H) == pytest.approx(best.fun, rel=1e-6)
    unlimited = replace(TWO_WHEELS, speed_max=np.full(2, np.inf))
    assert envelope_share(unlimited, np.array([5.0, 0.0, 0.0])) == 0.0


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
