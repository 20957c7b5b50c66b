"""Each outcome from a flight that was made to come to it."""

import re
from typing import Any

import numpy as np
import pytest

import simsat
from simsat.control.interface.measurement import Measurement
from simsat.results.flight_result import FlightResult

ALONE = {"gravity_gradient": False, "drag": False}


def idle(brief: Any) -> Any:
    return lambda now: np.zeros(brief.truth.wheels)


def full_torque(brief: Any) -> Any:
    return lambda now: brief.truth.torque_max


def to_and_fro(brief: Any) -> Any:
    return lambda now: brief.truth.torque_max * np.sign(np.sin(now.t))


def failing(brief: Any) -> Any:
    def law(now: Measurement) -> Any:
        raise ValueError("no idea")

    return law


def push(t: float, q: Any) -> Any:
    return np.array([0.0, 0.0, 2e-5])


def flown(model: str, controller: Any, **settings: Any) -> FlightResult:
    return simsat.fly(model, controller=controller, environment=ALONE, **settings)


CASES: list[tuple[str, dict[str, Any], str, str]] = [
    ("settled", {"model": "three_wheel", "controller": "nmpc", "angle_deg": 20, "duration_s": 20},
     "settled", r"^settled at t = [\d.]+ s$"),
    ("too short", {"model": "three_wheel", "controller": "nmpc", "duration_s": 5},
     "too_short", r"not below 0.5 deg: the flight of 5 s is shorter than a slew of about 16"),
    ("left", {"model": "two_wheel", "controller": idle, "angle_deg": 0.3, "torques": [push],
              "duration_s": 60},
     "left", r"settled at t = 0 s and left at t = .* wheel by 2e-05 Nm in the mean$"),
    ("spinning", {"model": "two_wheel", "controller": idle, "angle_deg": 40,
                  "start": {"omega_deg_s": (0, 0, 3)}, "duration_s": 40},
     "momentum", r"not below 0.5 deg: At the target .* Nms of the momentum lie along"),
    ("myopic", {"model": "two_wheel", "controller": "nmpc", "nmpc": {"horizon": 2},
                "duration_s": 40},
     "horizon", r"the horizon of 1 s is shorter than stopping takes, 7.9"),
    ("fast wheels", {"model": "three_wheel", "controller": full_torque, "duration_s": 60},
     "speed_limit", r"a wheel was at its speed limit for 100 % of the second half"),
    ("to and fro", {"model": "three_wheel", "controller": to_and_fro, "duration_s": 40},
     "torque_limit", r"a wheel was at its torque limit for \d\d % of the second half"),
    ("idle", {"model": "three_wheel", "controller": idle, "duration_s": 40},
     "not_settled", r"^125 deg at the end, not below 0.5 deg$"),
    ("failing", {"model": "three_wheel", "controller": failing, "duration_s": 5},
     "broken_off", r"^broken off at t = 0.00 s$"),
]  # fmt: skip


@pytest.mark.parametrize(("settings", "outcome", "sentence"), [case[1:] for case in CASES],
                         ids=[case[0] for case in CASES])  # fmt: skip
def test_a_flight_says_what_became_of_it(
    settings: dict[str, Any], outcome: str, sentence: str
) -> None:
    metrics = flown(**settings).metrics
    assert metrics["outcome"] == outcome, metrics["convergence"]
    assert re.search(sentence, metrics["convergence"]), metrics["convergence"]
    assert metrics["converged"] == (outcome == "settled")
