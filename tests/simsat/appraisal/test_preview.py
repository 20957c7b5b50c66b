"""What is said before a flight: times against the theory of bang-bang slews, and the warnings."""

import re
from typing import Any

import numpy as np
import pytest

import simsat
from simsat.appraisal.preview import Preview, preview, warnings
from simsat.control.model.reachable import Reach
from simsat.results.summary import foretell


def seen(model: str = "three_wheel", **settings: Any) -> Preview:
    return preview(simsat.prepare_mission(model, **settings))


def test_times_are_those_of_a_bang_bang_turn() -> None:
    """From rest to rest at torque u an inertia J turns by phi in 2 sqrt(phi J / u)."""
    craft = simsat.prepare_mission("three_wheel").model.spacecraft
    T0 = np.sqrt(np.trace(craft.J) / 3.0 / 0.05)
    found = seen(angle_deg=90)
    assert found.natural_time == pytest.approx(T0, rel=1e-8)
    assert found.slew == pytest.approx(2.0 * T0 * np.sqrt(np.pi / 2.0), rel=1e-6)
    assert found.braking == pytest.approx(found.slew / 2.0, rel=1e-6)
    assert (found.period, found.horizon, found.duration) == (0.5, 12.0, 100.0)


def test_little_momentum_makes_a_slew_longer() -> None:
    """Kepler's wheels store 1 deg/s: coasting at that rate takes most of a half turn."""
    found = seen("kepler", angle_deg=180)
    craft = simsat.prepare_mission("kepler").model.spacecraft
    rate = craft.momentum_max.min() / (np.trace(craft.J) / 3.0)
    assert found.slew >= np.pi / rate


def test_the_learned_controller_has_no_horizon() -> None:
    assert seen(controller="nmpc-learned").horizon is None


def test_what_is_usual_needs_no_warning() -> None:
    for model in ("two_wheel", "three_wheel", "hubble", "cubesat_1u"):
        assert list(warnings(seen(model, angle_deg=180))) == []


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"nmpc": {"horizon": 4}}, "horizon of 2 s is shorter than the 8.0. s that stopping takes: "
                                   "--nmpc.horizon 17 or more"),
        ({"start": {"omega_deg_s": (60, 0, 0)}}, "the horizon of 12 s is shorter than the 3"),
        ({"nmpc": {"period": 2.5}}, "period of 2.5 s is long for a craft with a natural time"),
        ({"model": "two_wheel", "nmpc": {"period": 1.0}}, "beyond 0.7 s it flies worse"),
        ({"nmpc": {"period": 0.05, "horizon": 300}}, "period of 0.05 s is short for a craft"),
        ({"duration_s": 10}, "the flight of 10 s may be too short for a slew of about 16 s"),
    ],
)  # fmt: skip
def test_what_will_go_wrong_is_said(settings: dict[str, Any], sentence: str) -> None:
    found = seen(**settings)
    assert any(re.search(sentence, warning) for warning in warnings(found)), list(warnings(found))
    assert "  warning: " in foretell(found)


def test_momentum_that_can_not_be_held_is_said() -> None:
    found = seen("two_wheel", start={"omega_deg_s": (0.0, 0.0, 5.0)})
    assert found.reach.reach is Reach.NEAREST_REST
    assert found.reach.reason in foretell(found)
    assert "The craft can rest at the target." in foretell(seen())
