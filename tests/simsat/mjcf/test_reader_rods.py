"""Magnetic rods in a file: sites of a tuple, each with its limit."""

import mujoco
import numpy as np
import pytest

from simsat.control.ground.errors import ModelError
from simsat.mjcf import interpret, read_model
from simsat.results.summary import describe
from tests.places import MODELS
from tests.simsat.mjcf.edits import BUS, FREE, ROTOR_X, at_end, behind, read

SITES = '<site name="rod_a" pos="0.1 0 0" zaxis="3 0 4"/><site name="rod_b" zaxis="0 1 0"/>'
Edit = tuple[str, str]


def rods(*elements: tuple[str, str], name: str = "magnetorquers") -> Edit:
    listed = "".join(
        f'<element objtype="{"body" if site == "bus" else "site"}" objname="{site}" {limit}/>'
        for site, limit in elements
    )
    return at_end(f'<custom><tuple name="{name}">{listed}</tuple></custom>')


def test_any_number_on_any_axes_in_the_order_of_the_tuple() -> None:
    read_rods = read(
        behind(FREE, SITES), rods(("rod_b", 'prm="0.5"'), ("rod_a", 'prm="0.2"'))
    ).spacecraft.rods
    assert read_rods.names == ("rod_b", "rod_a")
    np.testing.assert_allclose(read_rods.axes.T, [[0.0, 1.0, 0.0], [0.6, 0.0, 0.8]], atol=1e-15)
    np.testing.assert_array_equal(read_rods.dipole_max, [0.5, 0.2])
    assert read().spacecraft.rods.count == 0


def test_axes_are_the_bus_s_whatever_part_of_it_carries_the_site() -> None:
    """A bracket fixed to the bus, turned by 90 degrees about z: its x axis is the bus's y axis."""
    bracket = '<body euler="0 0 1.5707963267948966"><site name="rod_a" zaxis="1 0 0"/></body>'
    craft = read(behind(FREE, bracket), rods(("rod_a", 'prm="0.2"'))).spacecraft
    np.testing.assert_allclose(craft.rods.axes[:, 0], [0.0, 1.0, 0.0], atol=1e-15)


def test_axes_are_the_bus_s_also_where_the_file_turns_the_bus() -> None:
    turned = (BUS, BUS.replace(">", ' euler="0 0 1.5707963267948966">'))
    craft = read(turned, behind(FREE, SITES), rods(("rod_a", 'prm="0.2"'))).spacecraft
    np.testing.assert_allclose(craft.rods.axes[:, 0], [0.6, 0.0, 0.8], atol=1e-12)


@pytest.mark.parametrize(
    ("elements", "message"),
    [
        ([("rod_a", "")], "rod 'rod_a' has no dipole limit; give its largest dipole in A m.2"),
        ([("rod_a", 'prm="-0.2"')], "'rod_a' has the dipole limit -0.2 A m.2 .*must be above zero"),
        ([("rod_a", 'prm="inf"')], "'rod_a' has the dipole limit inf"),
        ([("rod_a", 'prm="0.2"')] * 2, "rod 'rod_a' is listed twice"),
        ([("bus", 'prm="0.2"')], "'bus' is no site; a rod is a site of the bus"),
    ],
)
def test_a_rod_without_limit_twice_or_of_another_kind(
    elements: list[tuple[str, str]], message: str
) -> None:
    with pytest.raises(ModelError, match=message):
        read(behind(FREE, SITES), rods(*elements))


@pytest.mark.parametrize("zaxis", ["3 0 4", "-3 0 -4"])
def test_two_rods_in_one_place_along_one_axis_are_one(zaxis: str) -> None:
    """A spare beside the first is another matter."""
    both = rods(("rod_a", 'prm="0.2"'), ("copy", 'prm="0.2"'))

    def second(pos: str) -> Edit:
        return behind(FREE, SITES + f'<site name="copy" pos="{pos}" zaxis="{zaxis}"/>')

    with pytest.raises(ModelError, match="'copy' lies where rod 'rod_a' does, along the same axis"):
        read(second("0.1 0 0"), both)
    assert read(second("0.1 0.02 0"), both).spacecraft.rods.count == 2


def test_a_rod_on_a_rotor_is_refused_with_the_place() -> None:
    on_rotor = behind(ROTOR_X, '<site name="rod_a" zaxis="0 0 1"/>')
    with pytest.raises(ModelError, match="'rod_a' sits on 'rotor_x', which is not fixed to the"):
        read(on_rotor, rods(("rod_a", 'prm="0.2"')))


def test_a_zero_axis_is_refused_with_the_line() -> None:
    with pytest.raises(ValueError, match="zaxis too small"):
        read(behind(FREE, '<site name="rod_a" zaxis="0 0 0"/>'), rods(("rod_a", 'prm="0.2"')))


def test_slips_of_the_tuple_s_name_are_refused_and_others_ignored() -> None:
    with pytest.raises(ModelError, match="tuple 'magnetorquer' is not known; did you mean 'magn"):
        read(behind(FREE, SITES), rods(("rod_a", 'prm="0.2"'), name="magnetorquer"))
    other = read(behind(FREE, SITES), rods(("rod_a", 'prm="0.2"'), name="antennas"))
    assert other.ignored == ("tuple 'antennas'",)


def test_rods_change_neither_the_craft_nor_what_was_learned_of_it() -> None:
    with_rods = read_model(MODELS / "two_wheel_rods" / "two_wheel_rods.xml")
    without = read_model(MODELS / "two_wheel" / "two_wheel.xml").spacecraft
    craft = with_rods.spacecraft
    np.testing.assert_array_equal(craft.J, without.J)
    assert craft.fingerprint == without.fingerprint
    assert with_rods.ignored == ()
    np.testing.assert_allclose(craft.rods.axes, np.eye(3), atol=1e-12)
    assert "3 magnetic rod(s)" in describe(with_rods, craft)
    assert "rod_z      axis   0.0000   0.0000   1.0000  dipole 0.2 A m^2" in describe(
        with_rods, craft
    )


def test_a_compiled_model_keeps_its_rods() -> None:
    spec = mujoco.MjSpec.from_file(str(MODELS / "two_wheel_rods" / "two_wheel_rods.xml"))
    rods = interpret(spec.compile(), "compiled").spacecraft.rods
    assert rods.names == ("rod_x", "rod_y", "rod_z")
