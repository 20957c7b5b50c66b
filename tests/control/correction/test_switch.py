import math

import pytest

from simsat.control.correction.switch import SwitchSettings, switched
from simsat.control.ground.errors import SettingsError


def test_it_goes_off_below_one_angle_and_comes_back_above_another() -> None:
    settings = SwitchSettings(off_below_deg=1.0, on_above_deg=1.3)
    on, states = True, []
    for degrees in [5.0, 1.2, 1.01, 0.99, 1.2, 1.29, 1.31, 1.2, 0.5]:
        on = switched(on, math.radians(degrees), settings)
        states.append(on)
    assert states == [True, True, True, False, False, False, True, True, False]


def test_an_error_jittering_about_the_threshold_switches_once() -> None:
    on, changes = True, 0
    for k in range(100):
        now = switched(on, math.radians(1.0 + 0.05 * (-1) ** k), SwitchSettings())
        changes += now is not on
        on = now
    assert changes == 1
    assert not on


def test_thresholds_in_the_wrong_order_are_refused() -> None:
    with pytest.raises(
        SettingsError, match=r"on-above-deg must not be below .* got 1\.3 and 1\.5$"
    ):
        SwitchSettings(off_below_deg=1.5)
