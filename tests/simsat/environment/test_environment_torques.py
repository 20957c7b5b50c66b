"""Each torque against its law, computed a second way: point masses, rays of air, rays of light."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array, Matrix3, Quaternion, Vector3
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.spacecraft import Spacecraft, Surface
from simsat.environment import Environment, EnvironmentSettings, OrbitSettings, build_environment
from simsat.environment.earth import DIPOLE_T, MAGNETIC_RADIUS, MU, days_since_j2000, sun_direction
from simsat.environment.fields.dipole import dipole_field
from simsat.environment.orbit import circular_orbit
from simsat.environment.solar_pressure import PRESSURE, sunlit

J = np.array([[1.620, 0.060, -0.050], [0.060, 1.488, 0.070], [-0.050, 0.070, 1.272]])
HALF, CENTRE = np.array([0.185, 0.205, 0.235]), np.array([0.012, -0.010, 0.012])
OFF = EnvironmentSettings(gravity_gradient=False, drag=False)
GENERIC = attitude.normalized(np.array([0.4, -0.5, 0.7, 0.2]))
ATTITUDES = np.array([attitude.IDENTITY, GENERIC, [0.0, 0.6, 0.0, 0.8]])


def box(centre: Vector3 = CENTRE, reflectivity: float = 0.3) -> Surface:
    normal = np.concatenate([np.eye(3), -np.eye(3)])
    area = np.tile(4.0 * np.prod(HALF) / HALF, 2)
    return Surface(centre + HALF * normal, normal, area, 2.2, reflectivity)


def craft(surface: Surface | None = None) -> Spacecraft:
    zero = np.zeros(2)
    return Spacecraft(
        "test", 50.0, J, ("x", "y"), np.eye(3)[:, :2], np.full(2, 1.4e-3),
        zero, zero, zero, zero, zero, surface=box() if surface is None else surface,
    )  # fmt: skip


def environment(
    *, orbit: OrbitSettings | None = None, spacecraft: Spacecraft | None = None, **switches: Any
) -> Environment:
    return build_environment(
        craft() if spacecraft is None else spacecraft,
        OrbitSettings() if orbit is None else orbit,
        replace(OFF, **switches),
    )


def point_masses(inertia: Matrix3, mass: float = 50.0) -> tuple[Array, float]:
    """Six equal masses on the principal axes with this inertia; positions in body axes."""
    moments, axes = np.linalg.eigh(inertia)
    spread = np.sqrt(3.0 * (0.5 * moments.sum() - moments) / mass)  # sum m x^2 per axis
    return np.concatenate([axes.T * spread[:, None], -axes.T * spread[:, None]]), mass / 6.0


@pytest.mark.parametrize("q", ATTITUDES)
def test_gravity_gradient_is_newton_s_law_on_point_masses(q: Quaternion) -> None:
    env = environment(gravity_gradient=True)
    r_B = attitude.rotation_matrix(q).T @ env.position(np.array([0.0]))[0]
    positions, mass = point_masses(J)
    # Exaggerate the size a thousandfold, or the difference of forces drowns in round-off.
    size = 1e3
    distance = r_B + size * positions
    force = -MU * mass * distance / np.linalg.norm(distance, axis=1)[:, None] ** 3
    expected = np.cross(size * positions, force).sum(axis=0) / size**2
    np.testing.assert_allclose(env.torque(0.0, q), expected, atol=1e-9)  # Nm of 4e-7


def rays(direction: Vector3, n: int = 400) -> tuple[Array, Array, float]:
    """Where a beam along `direction` enters the box: points, outward normals, area per ray."""
    u = np.linalg.svd(direction[None])[2][1:]
    reach = float(np.linalg.norm(HALF))
    grid = (np.arange(n) + 0.5) / n * 2.0 * reach - reach
    a, b = (side.ravel() for side in np.meshgrid(grid, grid))
    start = a[:, None] * u[0] + b[:, None] * u[1] - 10.0 * direction
    with np.errstate(divide="ignore"):
        slab = np.sort(np.stack([(-HALF - start) / direction, (HALF - start) / direction]), axis=0)
    enter, leave = slab[0].max(axis=1), slab[1].min(axis=1)
    hit = enter < leave
    face = slab[0][hit].argmax(axis=1)
    normal = np.zeros((hit.sum(), 3))
    normal[np.arange(len(normal)), face] = -np.sign(direction)[face]
    return CENTRE + start[hit] + enter[hit, None] * direction, normal, (2.0 * reach / n) ** 2


def in_body(q: Quaternion, vector_N: Vector3) -> Vector3:
    return attitude.rotation_matrix(q).T @ vector_N


@pytest.mark.parametrize("q", [GENERIC, attitude.normalized(np.array([0.1, 0.9, 0.3, -0.2]))])
def test_drag_is_a_beam_of_molecules_on_the_box(q: Quaternion) -> None:
    env = environment(drag=True)
    v_B = in_body(q, env.velocity(np.array([0.0]))[0])
    speed = np.linalg.norm(v_B)
    points, _, area = rays(-v_B / speed)
    force = -0.5 * 6.967e-13 * 2.2 * speed * area * v_B  # on the area of one ray
    expected = np.cross(points, force).sum(axis=0)
    np.testing.assert_allclose(env.torque(0.0, q), expected, rtol=0.01, atol=2e-9)


@pytest.mark.parametrize("q", [GENERIC, attitude.normalized(np.array([0.1, 0.9, 0.3, -0.2]))])
@pytest.mark.parametrize("reflectivity", [0.0, 0.3, 1.0])
def test_solar_pressure_is_a_beam_of_light_on_the_box(q: Quaternion, reflectivity: float) -> None:
    env = environment(spacecraft=craft(box(reflectivity=reflectivity)), solar_pressure=True)
    light = -in_body(q, np.array(sun_direction(days_since_j2000(OrbitSettings().epoch_utc))))
    points, normal, area = rays(light)
    mirrored = light - 2.0 * (normal @ light)[:, None] * normal
    force = PRESSURE * area * (light - reflectivity * mirrored)  # momentum in less momentum out
    expected = np.cross(points, force).sum(axis=0)
    sunlit_at = sunlit_time(env)
    np.testing.assert_allclose(env.torque(sunlit_at, q), expected, rtol=0.02, atol=1e-9)
    assert np.linalg.norm(expected) > 1e-8


def sunlit_time(env: Environment) -> float:
    sun = np.array(sun_direction(env.orbit.epoch_days))
    t = np.arange(0.0, env.orbit.period, 60.0)
    return float(t[np.argmax(env.position(t) @ sun)])


def test_a_box_centred_on_its_mass_feels_neither_air_nor_light() -> None:
    spacecraft = craft(box(centre=np.array([0.0, 0.0, 0.0])))
    env = environment(spacecraft=spacecraft, drag=True, solar_pressure=True)
    for q in ATTITUDES:
        assert np.abs(env.torque(0.0, q)).max() < 1e-20


def test_corotating_air_blows_from_the_side_on_a_polar_orbit() -> None:
    """One plate facing east feels air only if the air turns with the Earth."""
    polar = OrbitSettings(inclination_deg=90.0, raan_deg=0.0, arg_latitude_deg=0.0)
    plate = Surface(np.array([[0.0, 0.0, 1.0]]), np.array([[0.0, -1.0, 0.0]]), np.array([2.0]))
    still = environment(orbit=polar, spacecraft=craft(plate), drag=True)
    turning = environment(orbit=polar, spacecraft=craft(plate), drag=True, corotation=True)
    assert np.abs(still.torque(0.0, attitude.IDENTITY)).max() < 1e-20
    # Over the node at x the air moves towards +y at w R: relative velocity (0, -w R, v).
    wind, v = 7.292115e-5 * turning.orbit.radius_at(0.0), turning.orbit.speed_at(0.0)
    force = -0.5 * 6.967e-13 * 2.2 * 2.0 * wind * np.array([0.0, -wind, v])
    expected = np.cross([0.0, 0.0, 1.0], force)
    np.testing.assert_allclose(turning.torque(0.0, attitude.IDENTITY), expected, rtol=1e-9)


def test_magnetic_field_is_the_gradient_of_the_dipole_potential() -> None:
    orbit = circular_orbit(OrbitSettings())
    days, t = orbit.epoch_days, 321.0
    turn = np.deg2rad(280.46061837 + 360.98564736629 * (days + t / 86400.0))
    c, s = np.cos(turn), np.sin(turn)
    g_N = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ DIPOLE_T

    def potential(r: Vector3) -> float:
        return MAGNETIC_RADIUS**3 * (g_N @ r) / np.linalg.norm(r) ** 3

    r, h = np.array(orbit.position(t)), 100.0
    gradient = [(potential(r + h * e) - potential(r - h * e)) / (2.0 * h) for e in np.eye(3)]
    B = np.array(dipole_field(orbit)(t))
    np.testing.assert_allclose(B, -np.array(gradient), rtol=1e-6, atol=1e-11)
    assert 2e-5 < np.linalg.norm(B) < 5.5e-5  # T, at 500 km


def test_geomagnetic_pole_is_the_published_one() -> None:
    # IGRF-14 for 2025.0: the northern pole of the dipole at 80.8 N, 72.8 W.
    x, y, z = -np.array(DIPOLE_T)
    assert np.rad2deg(np.arctan2(z, np.hypot(x, y))) == pytest.approx(80.8, abs=0.05)
    assert np.rad2deg(np.arctan2(y, x)) == pytest.approx(-72.8, abs=0.05)


def test_magnetic_torque_turns_the_dipole_towards_the_field() -> None:
    env = environment(magnetic=True, dipole_Am2=(0.1, -0.05, 0.02))
    t, m = 50.0, np.array([0.1, -0.05, 0.02])
    B = np.array(dipole_field(env.orbit)(t))

    def energy(angle: Vector3) -> float:
        turned = attitude.multiply(
            GENERIC, attitude.from_axis_angle(angle, float(np.linalg.norm(angle)))
        )
        return -m @ attitude.rotation_matrix(turned).T @ B

    h = 1e-6
    slope = [(energy(h * e) - energy(-h * e)) / (2.0 * h) for e in np.eye(3)]
    np.testing.assert_allclose(env.torque(t, GENERIC), -np.array(slope), atol=1e-12)


def test_dipole_outweighs_drag_at_500_km() -> None:
    env = environment(drag=True, magnetic=True)
    t = np.linspace(0.0, env.orbit.period, 50)
    size = {k: np.linalg.norm(v, axis=1).mean()
            for k, v in env.torques(t, np.tile(GENERIC, (50, 1))).items()}  # fmt: skip
    assert size["magnetic"] > 5.0 * size["drag"]


def test_shadow_is_a_cylinder_behind_the_earth() -> None:
    sun, R = (1.0, 0.0, 0.0), 6878136.6
    edge = np.pi - np.arcsin(6378136.6 / R)
    for angle, lit in ((0.0, 1.0), (edge - 1e-3, 1.0), (edge + 1e-3, 0.0), (np.pi, 0.0)):
        assert sunlit((float(np.cos(angle)), 0.0, float(np.sin(angle))), sun, R) == lit


def test_the_log_and_the_plant_hear_the_same() -> None:
    everything = environment(
        gravity_gradient=True, drag=True, solar_pressure=True, magnetic=True,
        corotation=True, density_model="nrlmsis",
    )  # fmt: skip
    rng = np.random.default_rng(5)
    q = attitude.normalized(rng.normal(size=(40, 4)))
    t = np.linspace(0.0, 2.0 * everything.orbit.period, 40)
    by_name = everything.torques(t, q)
    assert list(by_name) == ["gravity_gradient", "drag", "solar_pressure", "magnetic"]
    one_by_one = np.array([everything.torque(*sample) for sample in zip(t, q, strict=True)])
    np.testing.assert_allclose(sum(by_name.values()), one_by_one, rtol=1e-9, atol=1e-19)
    opposite = np.array([everything.torque(*sample) for sample in zip(t, -q, strict=True)])
    np.testing.assert_allclose(one_by_one, opposite, atol=1e-20)


def test_nothing_switched_on_is_no_torque() -> None:
    env = environment()
    assert env.torques(np.zeros(2), ATTITUDES[:2]) == {}
    np.testing.assert_array_equal(env.torque(0.0, GENERIC), np.zeros(3))


@pytest.mark.parametrize(
    ("switches", "message"),
    [
        ({"f107": -1.0}, "f107 is -1"),
        ({"ap": float("nan")}, "ap is nan"),
        ({"dipole_Am2": (0.0, float("inf"), 0.0)}, "dipole-Am2 is"),
    ],
)
def test_environment_settings_are_refused_with_their_value(
    switches: dict[str, Any], message: str
) -> None:
    with pytest.raises(SettingsError, match=message):
        environment(**switches)
