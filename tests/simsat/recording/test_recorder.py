"""The recording, read back: is it what was flown?"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
from rerun.chunk import RrdReader

from simsat.control.ground import attitude
from simsat.flight.loop import Flight
from simsat.flight.mission import Mission, prepare
from simsat.recording.recorder import Recorder
from simsat.replay import ReplaySettings, prepare_replay
from simsat.settings import FlightSettings

SETTINGS = FlightSettings(duration_s=25.0)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Mission, Flight, Path]:
    rr.set_strict_mode(True)
    path = tmp_path_factory.mktemp("recording") / "recording.rrd"
    mission = prepare(SETTINGS)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("simsat.recording.recorder.WRITE_EVERY_S", 0.02)  # many small writes
        with Recorder(path, mission, "# notes") as recorder:
            flight = mission.fly(recorder.follow)
    return mission, flight, path


def column(path: Path, entity: str, component: str) -> tuple[np.ndarray, np.ndarray]:
    """(times in s, values) of one component, over all chunks of an entity."""
    times, values = [], []
    for chunk in RrdReader(path).stream():
        if str(chunk.entity_path) != entity:
            continue
        batch = chunk.to_record_batch()
        names = [name for name in batch.schema.names if name.endswith(component)]
        if names and "sim_time" in batch.schema.names:
            times += batch["sim_time"].cast("int64").to_pylist()
            values += batch[names[0]].to_pylist()
    order = np.argsort(times)
    return 1e-9 * np.array(times)[order], np.array(values)[order]


def test_the_bus_is_recorded_in_its_true_attitude(
    recorded: tuple[Mission, Flight, Path],
) -> None:
    _, flight, path = recorded
    t, q = column(path, "/world/bus", "quaternion")
    np.testing.assert_allclose(t, flight.plant.log.t, atol=1e-9)
    expected = attitude.scalar_last(flight.plant.attitudes)
    np.testing.assert_allclose(q.reshape(-1, 4), expected, atol=1e-6)  # single precision


def test_the_rotors_turn_in_the_recording(recorded: tuple[Mission, Flight, Path]) -> None:
    """The rotor's attitude relative to the bus is its wheel angle, the integral of its speed."""
    mission, flight, path = recorded
    _, bus = column(path, "/world/bus", "quaternion")
    _, rotor = column(path, "/world/rotor_x", "quaternion")
    q_bus = np.roll(bus.reshape(-1, 4), 1, axis=1)
    q_rotor = np.roll(rotor.reshape(-1, 4), 1, axis=1)
    turn = attitude.multiply(attitude.conjugate(q_bus), q_rotor)
    angle = flight.plant.log.qpos[: flight.plant.log.rows, mission.model.wheels[0].qpos]
    cosine = np.cos(0.5 * angle)
    np.testing.assert_allclose(np.abs(turn[:, 0]), np.abs(cosine), atol=1e-5)


def test_signals_carry_the_flight(recorded: tuple[Mission, Flight, Path]) -> None:
    mission, flight, path = recorded
    error = np.degrees(attitude.error_angle(flight.plant.attitudes, mission.target))
    t, values = column(path, "/signals/error", "scalars")
    np.testing.assert_allclose(values[:, 0], error, atol=1e-9)
    _, torque = column(path, "/signals/torque", "scalars")
    np.testing.assert_allclose(torque[:, :2], 1e3 * flight.plant.torques, atol=1e-9)
    np.testing.assert_allclose(torque[:, 2:], [[50.0, -50.0]] * len(t))
    _, gravity = column(path, "/environment/gravity_gradient", "scalars")
    truth = mission.environment.torques(flight.plant.log.t, flight.plant.attitudes)
    np.testing.assert_allclose(gravity, 1e6 * truth["gravity_gradient"], atol=1e-9)
    _, status = column(path, "/planner/status", "state")
    assert len(status) == len(flight.steps)
    assert {value[0] for value in status} <= {"optimal", "unfinished"}


def test_the_error_s_curves_do_not_jump_from_write_to_write(tmp_path: Path) -> None:
    """Two turns that nobody stops: written in many parts, on from where the last one ended."""
    profile, turn = tmp_path / "turn.npz", np.array([0.0, 0.0, 1.0])
    np.savez(profile, u=np.zeros((80, 2)), dt_u=0.5, w0=np.radians(18.0) * turn)
    mission = prepare_replay(ReplaySettings(profile))
    path = tmp_path / "recording.rrd"
    with pytest.MonkeyPatch.context() as patch, Recorder(path, mission, "") as recorder:
        patch.setattr("simsat.recording.recorder.WRITE_EVERY_S", 0.0)
        flight = mission.fly(recorder.follow)
    error = attitude.error_quaternion(flight.plant.attitudes, mission.target)
    assert np.abs(np.diff(error, axis=0)).max() > 1.0
    _, q = column(path, "/signals/quaternion", "scalars")
    np.testing.assert_allclose(q, attitude.continuous(error), atol=1e-12)
    assert np.abs(np.diff(q, axis=0)).max() < 0.01  # half of 18 deg/s in 0.05 s: 0.008


def test_every_geom_and_the_blueprint_are_in_the_file(
    recorded: tuple[Mission, Flight, Path],
) -> None:
    mission, _, path = recorded
    entities = {str(chunk.entity_path) for chunk in RrdReader(path).stream()}
    for shape in mission.model.shapes:
        body = mission.model.body_names[shape.body]
        assert f"/world/{body}/{shape.name}" in entities
    assert len(RrdReader(path).blueprints()) == 1


def test_a_craft_without_environment_or_geoms_is_recorded_too(tmp_path: Path) -> None:
    bare = tmp_path / "bare.xml"
    bare.write_text(
        '<mujoco><option integrator="RK4" gravity="0 0 0"><flag autoreset="disable"/></option>'
        '<worldbody><body><freejoint/><inertial pos="0 0 0" mass="9" diaginertia="1 1 1"/>'
        '<body><inertial pos="0 0 0" mass="1" diaginertia="2e-3 1e-3 1e-3"/>'
        '<joint name="w" axis="1 0 0"/></body></body></worldbody>'
        '<actuator><motor joint="w"/></actuator></mujoco>'
    )
    none = replace(SETTINGS.environment, gravity_gradient=False, drag=False)
    mission = prepare(replace(SETTINGS, model=bare, duration_s=2.0, environment=none))
    path = tmp_path / "recording.rrd"
    with Recorder(path, mission, "") as recorder:
        mission.fly(recorder.follow)
    assert len(column(path, "/signals/rate", "scalars")[0]) == 41
