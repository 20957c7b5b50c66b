"""Names in <custom>: those that are read, slips of them, and strangers."""

import numpy as np
import pytest

from simsat.control.ground.errors import ModelError
from tests.simsat.mjcf.edits import MOTOR_X, at_end, read


def numeric(name: str, data: str) -> tuple[str, str]:
    return at_end(f'<custom><numeric name="{name}" data="{data}"/></custom>')


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        (
            "speed_limit_rmp",
            "5000",
            "'speed_limit_rmp' is not known; did you mean 'speed_limit_rpm'",
        ),
        (
            "Speed_Limit_RPM",
            "5000",
            "'Speed_Limit_RPM' is not known; did you mean 'speed_limit_rpm'",
        ),
        ("speed-limit-rad-s", "5000", "did you mean 'speed_limit_rad_s'"),
        ("drag_coeff", "2", "did you mean 'drag_coefficient'"),
        ("nominal_inertia_factor", "1 1 1", "did you mean 'nominal_inertia_factors'"),
        ("reflectivitiy", "1", "did you mean 'reflectivity'"),
        ("wheel_x.speed_limit_rmp", "1", "did you mean 'wheel_x.speed_limit_rpm'"),
        (
            "wheel_z.speed_limit_rpm",
            "1",
            "no wheel is named 'wheel_z'.*'wheel_x', 'wheel_y'; did you",
        ),
        ("motor_x.speed_limit_rpm", "1", "no wheel is named 'motor_x'"),
        ("wheel_x.drag_coefficient", "1", "'drag_coefficient' is the whole spacecraft's"),
        ("wheel_x.speed_limit_rpm", "100 200", "has 2 numbers, it must have one"),
        ("wheel_x.speed_limit_rpm", "0", "is 0, it must be above zero"),
        ("wheel_x.speed_limit_rpm", "-10", "is -10, it must be above zero"),
        ("wheel_x.speed_limit_rad_s", "6000", "57,296 rpm for 'wheel_x'.*is the unit right"),
        ("speed_limit_rad_s", "600", "'speed_limit_rpm' and 'speed_limit_rad_s': give one of them"),
        ("reflectivity", "1.1", "'reflectivity' is 1.1, it must be one number from 0 to 1"),
        ("reflectivity", "0.1 0.1", "'reflectivity' is 0.1 0.1, it must be one number"),
    ],
)
def test_slips_are_refused(name: str, data: str, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        read(numeric(name, data))


@pytest.mark.parametrize("factors", ["1 1", "1 1 1 1", "1 0 1", "1 -1 1", "1 1 inf"])
def test_inertia_factors_are_three_and_positive(factors: str) -> None:
    stated = "0.9259259259259259 1.0752688172043012 0.9433962264150944"
    with pytest.raises(ModelError, match="'nominal_inertia_factors' must be three numbers above z"):
        read((f'data="{stated}"', f'data="{factors}"'))


def test_a_text_that_should_be_a_number_is_refused() -> None:
    entry = '<custom><text name="reflectivity" data="1"/></custom>'
    with pytest.raises(ModelError, match="text 'reflectivity': it is a number, write <numeric"):
        read(at_end(entry))


def test_strangers_are_said() -> None:
    model = read(numeric("orbit_altitude_km", "500"), numeric("Cd", "2"))
    assert model.ignored == ("numeric 'orbit_altitude_km'", "numeric 'Cd'")


def test_the_limit_of_a_wheel_without_a_motor_is_no_slip() -> None:
    model = read(numeric("wheel_x.speed_limit_rpm", "100"), (MOTOR_X, ""))
    assert model.ignored == ("numeric 'wheel_x.speed_limit_rpm'",)
    np.testing.assert_allclose(model.spacecraft.speed_max, 200.0 * np.pi)


def test_numbers_are_read_by_their_own_names() -> None:
    surface = read(numeric("reflectivity", "0.7")).spacecraft.surface
    assert (surface.drag_coefficient, surface.reflectivity) == (2.2, 0.7)
