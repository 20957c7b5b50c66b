"""The Gymnasium environments: their contract, and that they fly what `simsat.fly` flies."""

import subprocess
import sys
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import simsat
from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.own import in_units
from simsat.control.nmpc.planner import build_attitude_ocp
from simsat.gym import SlewEnv, follow_policy
from simsat.gym.senses import RATE_BOUND, RATE_SCALE
from simsat.mjcf.shipped import shipped_models
from tests.places import ROOT

NAMES = sorted(name for name in gymnasium.registry if name.startswith("simsat/"))
START: dict[str, Any] = {"axis": (0.48, -0.64, 0.60), "angle_deg": 125.0}


def flown(env: SlewEnv, policy: Any, **options: Any) -> list[float]:
    """An episode to its end; its rewards."""
    seen, _ = env.reset(seed=0, options=options or START)
    rewards, over = [], False
    while not over:
        seen, reward, terminated, over, _ = env.step(policy(seen))
        assert not terminated
        rewards.append(reward)
    return rewards


def pd(seen: Array) -> Array:
    """A policy that turns three wheels home."""
    return 9.6 * seen[1:4] + 1.8 * seen[4:7]


def pd_pilot(brief: Any) -> Any:
    return follow_policy(pd, brief)


def shaken(seen: Array) -> Array:
    """A policy for any number of wheels that reaches the torque limits and beyond."""
    wheels = (len(seen) - 7) // 2
    return np.array([2.0 * np.cos(9.0 * np.sum(seen) + i) for i in range(wheels)])


def shaken_pilot(brief: Any) -> Any:
    return follow_policy(shaken, brief)


def test_every_shipped_spacecraft_has_an_environment() -> None:
    assert len(NAMES) == len(shipped_models())
    assert {"simsat/TwoWheel-v0", "simsat/ThreeWheel-v0", "simsat/FlexiblePanels-v0"} <= set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_gymnasium_s_own_check_passes_without_a_warning(name: str) -> None:
    """Warnings are errors under pytest, and Gymnasium's are warnings."""
    check_env(gymnasium.make(name).unwrapped)


def test_another_model_and_any_setting_are_keyword_arguments() -> None:
    env = gymnasium.make("simsat/TwoWheel-v0", model="three_wheel", nmpc={"period": 0.25})
    assert env.action_space.shape == (3,)
    env.reset(seed=0)
    assert env.step(np.zeros(3))[4]["t_s"] == 0.25
    path = gymnasium.make("simsat/TwoWheel-v0", model=ROOT / "models/pyramid/pyramid.xml")
    assert path.action_space.shape == (4,)


@pytest.mark.parametrize(
    ("model", "policy", "pilot"),
    [("three_wheel", pd, pd_pilot), ("two_wheel", shaken, shaken_pilot),
     ("flexible_panels", shaken, shaken_pilot)],
)  # fmt: skip
def test_an_episode_is_the_flight_of_the_same_controller_bit_for_bit(
    model: str, policy: Any, pilot: Any
) -> None:
    env = SlewEnv(model, duration_s=20)
    flown(env, policy)
    flight = simsat.fly(model, controller=pilot, duration_s=20, **START)
    ours, theirs = env.result.flight.plant.log, flight.flight.plant.log
    for name in ("qpos", "qvel", "torque"):
        np.testing.assert_array_equal(getattr(ours, name), getattr(theirs, name))
    assert np.max(np.abs(ours.torque)) > 0.01, "nothing moved"
    assert env.result.table.equals(flight.table)
    assert env.result.metrics["final_error_deg"] == flight.metrics["final_error_deg"]


def test_noise_of_the_sensors_is_the_flight_s_and_new_in_every_episode() -> None:
    env = SlewEnv("three_wheel", duration_s=10, sensors={"enabled": True})
    flown(env, pd)
    first = env.result
    seed = first.mission.settings.sensors.seed
    sensors = {"enabled": True, "seed": seed}
    flight = simsat.fly("three_wheel", controller=pd_pilot, duration_s=10, sensors=sensors, **START)
    assert first.table.equals(flight.table)
    env.reset(options=START)
    assert env.result.mission.settings.sensors.seed != seed


def test_the_nmpc_s_commands_fly_its_flight() -> None:
    """To round-off: a torque divided by its limit and multiplied again may lose its last bit."""
    flight = simsat.fly(controller="nmpc", duration_s=20)
    env = SlewEnv("two_wheel", duration_s=20)
    commands = iter(flight.flight.commands)
    flown(env, lambda seen: next(commands) / 0.05)
    ours, theirs = env.result.flight.plant, flight.flight.plant
    apart = attitude.error_angle(ours.attitudes, theirs.attitudes)
    assert np.max(apart) < 1e-11  # rad


@pytest.mark.parametrize("model", ["two_wheel", "three_wheel"])
def test_the_reward_is_minus_the_nmpc_s_stage_cost(model: str) -> None:
    """The planner's own residuals, evaluated by CasADi."""
    env = SlewEnv(model, duration_s=5, nmpc={"weights": {"effort": 0.1}})
    mission = simsat.prepare_mission(model, controller=pd_pilot, nmpc={"weights": {"effort": 0.1}})
    units = mission.timing.units
    settings = in_units(mission.brief.settings.nmpc, units)
    ocp = build_attitude_ocp(mission.model.spacecraft.in_units(units), settings)
    rng = np.random.default_rng(3)
    actions = rng.uniform(-1, 1, (10, mission.model.spacecraft.wheels))
    rows = iter(actions)
    rewards = flown(env, lambda seen: next(rows))
    plant = env.result.flight.plant
    before = np.vstack([0.0 * actions[:1], actions[:-1]])
    for k, (action, previous, paid) in enumerate(zip(actions, before, rewards, strict=True)):
        state = plant.state(10 * (k + 1))
        q = attitude.error_quaternion(state.q, mission.target)
        motion = np.concatenate([state.omega, state.wheel_speed]) / units.rate
        x = np.concatenate([q, motion, 0.05 / units.torque * previous])
        r = np.array(ocp.evaluate(x, 0.05 / units.torque * action, np.zeros(3))[1])
        np.testing.assert_allclose(paid, -0.5 * np.sum(r**2), rtol=1e-9)


def test_the_observation_is_the_documented_one() -> None:
    env = SlewEnv("three_wheel", duration_s=5, start={"wheel_speed_rpm": (3000.0, 0.0, -1500.0)})
    env.reset(seed=1)
    seen, *_ = env.step(np.array([0.5, -5.0, 0.25]))
    truth = env.result.flight.plant.state()
    q = truth.q if truth.q[0] >= 0 else -truth.q
    speeds = truth.wheel_speed / (6000 * np.pi / 30)
    rates = truth.omega * env.result.mission.timing.units.time / RATE_SCALE
    expected = np.concatenate([q, rates, speeds, [0.5, -1.0, 0.25]])
    np.testing.assert_allclose(seen, expected, rtol=1e-6)
    assert seen.dtype == np.float32


def test_what_a_tumbling_spacecraft_shows_stays_inside_the_space() -> None:
    start = {"omega_deg_s": (100.0, 0.0, 0.0)}
    env = SlewEnv("two_wheel", duration_s=5, start=start)
    seen, _ = env.reset(seed=0)
    assert seen[4] == RATE_BOUND
    assert seen in env.observation_space


def test_seeds_draw_rotations_evenly() -> None:
    env = SlewEnv("two_wheel", angles_deg=(60.0, 90.0), duration_s=5)
    starts, infos = zip(*(env.reset(seed=seed) for seed in range(200)), strict=True)
    angles = np.array([info["error_deg"] for info in infos])
    axes = np.array(starts)[:, 1:4] / np.sin(np.radians(angles / 2))[:, None]
    assert 60.0 <= angles.min() < 63.0
    assert 87.0 < angles.max() <= 90.0
    # three standard deviations of the mean of 200 components with variance 1/3
    assert np.max(np.abs(axes.mean(axis=0))) < 3.0 * np.sqrt(1 / 3 / 200)
    np.testing.assert_array_equal(env.reset(seed=7)[0], starts[7])


@pytest.mark.parametrize("mode", ["sync", "async"])
def test_a_vector_of_environments_is_each_of_them(mode: str) -> None:
    kwargs = {"context": "spawn"} if mode == "async" else {}
    many = gymnasium.make_vec("simsat/ThreeWheel-v0", 2, mode, vector_kwargs=kwargs, duration_s=3)
    seen, _ = many.reset(seed=[5, 6])
    actions = np.random.default_rng(0).uniform(-1, 1, (6, 2, 3)).astype(np.float32)
    rewards = []
    for action in actions:
        seen, reward, _, over, _ = many.step(action)
        rewards.append(reward)
    many.close()
    assert over.all()
    for i, seed in enumerate((5, 6)):
        env = SlewEnv("three_wheel", duration_s=3)
        env.reset(seed=seed)
        alone = [env.step(action[i]) for action in actions]
        np.testing.assert_array_equal(seen[i], alone[-1][0])
        np.testing.assert_array_equal([row[i] for row in rewards], [step[1] for step in alone])


@pytest.mark.parametrize(
    ("options", "sentence"),
    [({"controller": "nmpc"}, "no controller: whoever calls step decides"),
     ({"angle_deg": 75.0}, "give angles_deg, a range"),
     ({"axis": (0, 0, 1)}, "the start is drawn"),
     ({"angles_deg": (0.0, 90.0)}, "angles_deg is 0 to 90: give"),
     ({"angles_deg": (90.0, 30.0)}, "angles_deg is 90 to 30: give"),
     ({"duration_s": 0.7, "nmpc.period": 0.5}, "0.7 s is not a whole number of 0.5 s steps"),
     ({"nmpc": {"periood": 1.0}}, "did you mean period?")],
)  # fmt: skip
def test_what_does_not_fit_is_refused(options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(SettingsError, match=sentence.replace("?", r"\?")):
        SlewEnv("two_wheel", **options)


def test_bad_actions_and_starts_are_refused() -> None:
    env = SlewEnv("two_wheel", duration_s=5)
    with pytest.raises(SettingsError, match="no option angle: reset takes axis and angle_deg"):
        env.reset(options={"angle": 75})
    env.reset(seed=0)
    with pytest.raises(SettingsError, match="give 2 finite shares of the torque limit"):
        env.step(np.array([np.nan, 0.0]))
    with pytest.raises(SettingsError, match="give 2 finite shares of the torque limit"):
        env.step(np.zeros(3))


def test_flying_needs_no_gymnasium_and_learning_says_so() -> None:
    script = """
import sys
sys.modules["gymnasium"] = None
import simsat
simsat.fly("three_wheel", controller=lambda brief: lambda now: 0 * now.wheel_speed, duration_s=5)
try:
    import simsat.gym
except ImportError as error:
    print(error)
"""
    answer = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert answer.stdout.startswith("learning to fly needs Gymnasium, which flying doesn't: pip")
