"""Motors that weaken with speed: the plant against SciPy, and planners that stay inside."""

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import simsat
from simsat.control.ground import attitude
from simsat.control.ground.envelope import TorqueEnvelope
from simsat.control.ground.errors import ModelError
from simsat.control.ground.spacecraft import nominal
from simsat.mjcf import Model, interpret
from simsat.plant.plant import Plant
from simsat.results.metrics import judge
from simsat.results.summary import describe, result_table
from tests.simsat.mjcf.edits import MOTOR_X, at_end, text

RPM = 2.0 * np.pi / 60.0
LINE = "0 0.05  6000 0"
"""Back-emf alone: T (1 - speed / 6000 rpm)."""
KNEE = "0 0.05  3000 0.05  6000 0.01"
PLAIN = '<motor name="motor_x" joint="wheel_x" ctrllimited="true" ctrlrange="-0.05 0.05"/>'
"""A motor without a torque-rate limit."""


def weak(data: str, wheel: str = "wheel_x.", unit: str = "rpm") -> tuple[str, str]:
    return at_end(f'<custom><numeric name="{wheel}torque_envelope_{unit}" data="{data}"/></custom>')


def read(*edits: tuple[str, str]) -> Model:
    return interpret(mujoco.MjModel.from_xml_string(text(*edits)), "edited")


def spun_up(model: Model, seconds: float, torque: float = 0.05) -> Plant:
    plant = Plant(model, 0.05, round(seconds / 0.05))
    plant.reset(attitude.IDENTITY)
    plant.advance(np.array([torque, 0.0]), round(seconds / 0.05))
    return plant


def euler(model: Model, curve: dict[float, float], seconds: float) -> np.ndarray:
    """Wheel speeds (rad/s) and body rates after some time at full torque of wheel x, by SciPy.

    (J - Js A A') w' = -A u - w x H,  Js (Omega' + A'w') = u,  u_x = what the curve of
    (rpm: Nm) gives at Omega_x.
    """
    craft = model.spacecraft
    hub = np.linalg.inv(craft.J - craft.A @ np.diag(craft.Js) @ craft.A.T)

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        w, speed = y[:3], y[3:]
        u = np.array([np.interp(abs(speed[0]) / RPM, list(curve), list(curve.values())), 0.0])
        H = craft.J @ w + craft.A @ (craft.Js * speed)
        turn = hub @ (-craft.A @ u - np.cross(w, H))
        return np.concatenate([turn, u / craft.Js - craft.A.T @ turn])

    end = solve_ivp(rate, (0.0, seconds), np.zeros(5), rtol=1e-11, atol=1e-12, max_step=0.05)
    return end.y[:, -1]


@pytest.mark.parametrize(
    ("data", "curve"),
    [(LINE, {0: 0.05, 6000: 0.0}), (KNEE, {0: 0.05, 3000: 0.05, 6000: 0.01})],
)
@pytest.mark.parametrize("seconds", [5.0, 15.0, 22.0])
def test_a_wheel_spins_up_as_scipy_says(
    data: str, curve: dict[float, float], seconds: float
) -> None:
    model = read((MOTOR_X, PLAIN), weak(data))
    plant = spun_up(model, seconds)
    expected = euler(model, curve, seconds)
    assert plant.wheel_speeds[-1, 0] == pytest.approx(expected[3], rel=1e-6)
    np.testing.assert_allclose(plant.rates[-1], expected[:3], rtol=1e-5, atol=1e-8)


def test_back_emf_is_an_exponential() -> None:
    """Omega = Omega_0 (1 - exp(-a T t / Omega_0)) with one wheel's agility a, in closed form; the
    bus is held by its own inertia alone, gyroscopics are second order here."""
    model = read((MOTOR_X, PLAIN), weak(LINE))
    craft = model.spacecraft
    a = 1.0 / craft.Js[0] + np.linalg.inv(craft.J_hub)[0, 0]
    plant = spun_up(model, 3.0)
    full = 6000.0 * RPM
    expected = full * (1.0 - np.exp(-a * 0.05 * plant.log.t / full))
    np.testing.assert_allclose(plant.wheel_speeds[:, 0], expected, rtol=2e-4)


def test_a_steep_fall_does_not_ring() -> None:
    """From all to nothing within 1 rpm: the wheel stays there, at what the motor can give."""
    plant = spun_up(read((MOTOR_X, PLAIN), weak("0 0.05 3000 0.05 3001 0")), 60.0)
    speed = plant.wheel_speeds[-200:, 0] / RPM
    assert np.all((speed > 2999.0) & (speed < 3003.0))  # a step at full torque brings 3.5 rpm
    assert np.abs(np.diff(plant.torques[-200:, 0])).max() < 1e-4


def test_braking_keeps_its_torque_and_reverses_at_its_rate() -> None:
    """At 5900 rpm 0.0113 Nm are left to drive, all 0.05 to brake; the ramp starts from 0.0113."""
    model = read(weak(KNEE))
    plant = Plant(model, 0.05, 60)
    plant.reset(attitude.IDENTITY, None, np.array([5900.0 * RPM, 0.0]))
    plant.advance(np.array([0.05, 0.0]), 20)
    left = 0.01 + 0.04 * (6000.0 - plant.wheel_speeds[20, 0] / RPM) / 3000.0
    assert plant.torques[20, 0] == pytest.approx(left, rel=1e-3)
    plant.advance(np.array([-0.05, 0.0]), 40)
    change = np.diff(plant.torques[20:, 0])
    assert change.min() > -0.4 * 0.05 * (1 + 1e-9)  # Nm in a sample
    ramp = (0.05 + left) / 0.4
    assert plant.torques[20 + int(np.ceil(ramp / 0.05)), 0] == pytest.approx(-0.05, rel=1e-9)


def test_backwards_it_is_the_same() -> None:
    model = read((MOTOR_X, PLAIN), weak(KNEE))
    there, back = spun_up(model, 30.0), spun_up(model, 30.0, -0.05)
    np.testing.assert_allclose(back.wheel_speeds[:, 0], -there.wheel_speeds[:, 0], rtol=1e-6)


def test_all_of_its_torque_up_to_its_knee_changes_no_bit() -> None:
    plain, weakened = read(), read(weak("0 0.05 5999 0.05 6000 0"))
    for name in ("qpos", "torque"):
        np.testing.assert_array_equal(
            getattr(spun_up(weakened, 10.0).log, name), getattr(spun_up(plain, 10.0).log, name)
        )


def test_the_fastest_box_is_the_fastest() -> None:
    """Against a fine grid of ramp, coast, ramp: angle = w t_coast + w^2 J / u, w = Js s / J."""
    rng = np.random.default_rng(0)
    J, Js = 1.5, 1.4e-3
    for _ in range(100):
        speeds = np.concatenate([[0.0], np.cumsum(rng.uniform(1.0, 200.0, 4))])
        torques = np.sort(rng.uniform(0.0, 0.1, 5))[::-1] * rng.choice([1.0, 0.1, 10.0])
        envelope = TorqueEnvelope(tuple(zip(speeds.tolist(), torques.tolist(), strict=True)))
        limit = rng.choice([rng.uniform(10.0, 800.0), np.inf])
        torque, speed = envelope.fastest_box(Js**2 / (np.pi * J), float(limit))
        assert speed <= limit
        assert torque <= np.interp(speed, speeds, torques) * (1 + 1e-12)
        grid = np.linspace(0.0, min(limit, 20_000.0), 200_001)[1:]
        best = slew(np.interp(grid, speeds, torques), grid, J, Js).min()
        assert slew(np.array([torque]), np.array([speed]), J, Js)[0] <= best * (1.0 + 1e-9)


def slew(torque: np.ndarray, speed: np.ndarray, J: float, Js: float) -> np.ndarray:
    """Shortest time of half a turn within torque and wheel speed, s."""
    rate = np.minimum(Js * speed / J, np.sqrt(np.pi * torque / J))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(rate > 0.0, np.pi / rate + rate * J / torque, np.inf)


def test_a_cap_cuts_the_curve_at_the_limit() -> None:
    capped = TorqueEnvelope(((0.0, 0.3), (100.0, 0.1))).capped(0.2)
    np.testing.assert_allclose(capped.points, [(0.0, 0.2), (50.0, 0.2), (100.0, 0.1)])
    model = read(weak("0 0.1 6000 0"))  # the file's own limit is 0.05 Nm
    assert model.spacecraft.torque_max[0] == 0.05
    envelope = model.spacecraft.envelopes[0]
    assert envelope is not None
    assert envelope.knee == pytest.approx(3000.0 * RPM)


@pytest.mark.parametrize("controller", ["nmpc", "nmpc-learned"])
def test_planners_stay_inside(controller: str) -> None:
    """Wheels that pass 1000 rpm where all their torque is there, on a curve that ends at 800."""
    spec = mujoco.MjSpec.from_string(text(weak("0 0.05 200 0.05 800 0", "")))
    mission = simsat.prepare_mission(spec, controller=controller, angle_deg=125, duration_s=120)
    torque, speed = mission.believed.torque_max[0], mission.believed.speed_max[0]
    assert 0.005 < torque < 0.045
    assert 250.0 < speed / RPM < 750.0
    metrics = judge(mission.fly(), mission.target)
    assert metrics["torque_cut_by_speed"] == 0
    assert not any(metrics["limit_violations"].values())
    assert 0.9 * speed < metrics["peak_wheel_speed_rpm"] * RPM


def test_a_command_above_a_motor_is_told() -> None:
    """A law of one's own that knows nothing: what it asks is logged, what was given too."""

    def greedy(brief: object) -> object:
        return lambda measurement: np.array([0.05, 0.0])

    spec = mujoco.MjSpec.from_string(text(weak(LINE)))
    flight = simsat.fly(spec, controller=greedy, duration_s=20)
    assert flight.metrics["torque_cut_by_speed"] > 300
    assert not any(flight.metrics["limit_violations"].values())
    assert "commands above a motor" in result_table(flight.metrics)


def test_only_what_drives_a_wheel_on_is_bounded() -> None:
    craft = read(weak(LINE)).spacecraft
    speed = np.array([[3000.0, 3000.0], [-3000.0, 3000.0], [3000.0, 3000.0], [0.0, 0.0]]) * RPM
    torque = np.array([[0.01, 0.01], [-0.01, 0.01], [-0.01, 0.01], [0.01, 0.01]])
    most = craft.torque_available(speed, torque)
    np.testing.assert_allclose(most[:, 0], [0.025, 0.025, 0.05, 0.05])
    np.testing.assert_array_equal(most[:, 1], 0.05)  # wheel y keeps its torque
    metrics = simsat.fly(
        mujoco.MjSpec.from_string(text(weak(LINE))),
        controller=lambda brief: lambda measurement: np.array([-0.04, 0.0]),
        duration_s=5,
        start={"wheel_speed_rpm": (5000.0, 0.0)},
    ).metrics
    assert metrics["torque_cut_by_speed"] == 0
    assert not any(metrics["limit_violations"].values())


def test_it_is_said_at_the_start() -> None:
    model = read(weak(KNEE))
    said = describe(model, nominal(model.spacecraft))
    assert (
        "wheel_x    full torque up to 3000 rpm, then 0.01 Nm at 6000 rpm; planned with 0.05 Nm up"
        " to 3000 rpm" in said
    )


@pytest.mark.parametrize(
    ("edits", "message"),
    [
        ([weak("0 0.05 100")], "has 3 numbers: give pairs of speed and torque"),
        ([weak("0 0.05")], "has 2 numbers: give pairs"),
        ([weak("10 0.05 100 0.01")], "its speeds must ascend from 0"),
        ([weak("0 0.05 100 0.01 100 0")], "its speeds must ascend from 0"),
        ([weak("0 0.01 100 0.05")], "its torques must start above zero, not rise"),
        ([weak("0 0.01 100 -0.05")], "its torques must start above zero, not rise, and stay at ze"),
        ([weak("0 0 100 0")], "its torques must start above zero"),
        ([weak("0 0.05 600000 0")], "at most 28,648 rpm is believed"),
        ([weak(LINE), weak(LINE, unit="rad_s")], "give one of them"),
        ([weak(LINE, "wheel_z.")], "no wheel is named 'wheel_z'"),
        ([at_end('<custom><numeric name="torque_envelop_rpm" data="0 1 2 0"/></custom>')],
         "did you mean 'torque_envelope_rpm'"),
    ],
)  # fmt: skip
def test_wrong_curves_are_refused(edits: list[tuple[str, str]], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        read(*edits)
