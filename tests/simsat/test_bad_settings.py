"""Nonsense is refused at the door, in one sentence that names the flag and what is allowed."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from simsat.control.ground.errors import ModelError, SettingsError
from simsat.control.ground.settings import changed
from simsat.control.learned.settings import LearnedSettings
from simsat.control.nmpc.cost import Weights
from simsat.control.nmpc.planner import NmpcSettings
from simsat.control.solver import SolverSettings
from simsat.control.supervisor.faithful import FaithfulSettings
from simsat.control.supervisor.sound import SoundSettings
from simsat.control.supervisor.value import ValueSettings
from simsat.environment import EnvironmentSettings
from simsat.flight.mission import prepare
from simsat.learning.correction.data import FleetSettings
from simsat.learning.data import DataSettings
from simsat.learning.train import TrainCommand, TrainSettings
from simsat.mjcf import read_model
from simsat.mjcf.shipped import MODELS, find_model
from simsat.sensors.settings import SensorSettings
from simsat.settings import CommonSettings, FlightSettings, NominalSettings, StartSettings


@pytest.mark.parametrize(
    ("settings", "values", "sentence"),
    [
        (Weights, {"attitude": 0.0}, r"--nmpc\.weights\.attitude is 0: .* above 0$"),
        (Weights, {"unactuated": -1.0}, r"--nmpc\.weights\.unactuated is -1: .* from 0 up$"),
        (Weights, {"rate": math.nan}, r"--nmpc\.weights\.rate is nan"),
        (Weights, {"effort": -1.0}, r"--nmpc\.weights\.effort is -1"),
        (Weights, {"increment": math.inf}, r"--nmpc\.weights\.increment is inf"),
        (Weights, {"terminal": -1.0}, r"--nmpc\.weights\.terminal is -1"),
        (
            NmpcSettings,
            {"period": 0.0},
            r"--nmpc\.period is 0: give a .* above 0 or nothing$",
        ),
        (NmpcSettings, {"period": math.nan}, r"--nmpc\.period is nan"),
        (NmpcSettings, {"horizon": 0}, r"--nmpc\.horizon is 0: .* from 1 to 500$"),
        (NmpcSettings, {"horizon": 501}, r"--nmpc\.horizon is 501"),
        (
            NmpcSettings,
            {"keep_rate_below_deg_s": 0.0},
            r"below-deg-s is 0: .* from 1e-06 up or nothing$",
        ),
        (CommonSettings, {"model": Path("\udcff")}, r"--model is '\\udcff': give a path$"),
        (SolverSettings, {"max_iterations": 0}, r"max-iterations is 0: .* from 1 up$"),
        (SolverSettings, {"tolerance": math.nan}, r"--nmpc\.solver\.tolerance is nan"),
        (SolverSettings, {"damping": -1.0}, r"--nmpc\.solver\.damping is -1"),
        (LearnedSettings, {"rate_noise": 0.0}, r"--learned\.rate-noise is 0: .* above 0 "),
        (LearnedSettings, {"rearm_deg": -1.0}, r"--learned\.rearm-deg is -1"),
        (LearnedSettings, {"search_plans": -1}, r"--learned\.search-plans is -1"),
        (LearnedSettings, {"margin_s": math.nan}, r"--learned\.margin-s is nan"),
        (LearnedSettings, {"hold_s": -5.0}, r"--learned\.hold-s is -5"),
        (
            LearnedSettings,
            {"hold_periods": 2},
            r"--learned\.hold-periods is 2: .* from 3 up or nothing$",
        ),
        (FaithfulSettings, {"attitude_gain": -1.0}, r"--faithful\.attitude-gain is -1"),
        (SoundSettings, {"attitude_gain": math.nan}, r"--sound\.attitude-gain is nan"),
        (SoundSettings, {"disturbance_max": -1.0}, r"--sound\.disturbance-max is -1"),
        (
            ValueSettings,
            {"decrease": 2.0},
            r"--value\.decrease is 2: .* from 0 to 1$",
        ),
        (ValueSettings, {"decrease": math.nan}, r"--value\.decrease is nan"),
        (NominalSettings, {"mismatch": math.nan}, r"--nominal\.mismatch is nan: .* from 0 up$"),
        (
            NominalSettings,
            {"inertia_factors": (1.0, 0.0, 1.0)},
            r"inertia-factors is 1 0 1: give 3 values, each a finite number above 0 or nothing$",
        ),
        (FleetSettings, {"duration_s": math.nan}, r"^--duration-s is nan: .* above 0 "),
        (FleetSettings, {"seed": -1}, r"^--seed is -1: .* from 0 up$"),
        (EnvironmentSettings, {"f107": 1e6}, r"--environment\.f107 is 1e\+06: .* from 0 to 1000$"),
        (DataSettings, {"workers": 0}, r"^--workers is 0: .* from 1 up$"),
        (TrainSettings, {"duration_s": math.inf}, r"^--duration-s is inf"),
        (TrainSettings, {"seed": -1}, r"^--seed is -1"),
        (TrainCommand, {"workers": 0}, r"^--workers is 0"),
        (
            StartSettings,
            {"omega_deg_s": (0, math.nan, 0)},
            r"is 0 nan 0: .* from -3600 to 3600$",
        ),
        (StartSettings, {"omega_deg_s": (0, 0, -1e300)}, r"omega-deg-s is 0 0 -1e\+300"),
        (FlightSettings, {"axis": (1e-320, 0.0, 0.0)}, r"--axis must be three finite numbers"),
        (FlightSettings, {"target": (1e200, 0.0, 0.0, 0.0)}, r"--target must be a quaternion"),
    ],
)
def test_a_setting_out_of_range(
    settings: Callable[..., Any], values: dict[str, Any], sentence: str
) -> None:
    with pytest.raises(SettingsError, match=sentence):
        settings(**values)


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"sound.s_lo": -math.inf}, "--sound.s-lo is -inf"),
        ({"start": {"wheel_speed_rpm": (0.0, math.nan)}}, "--start.wheel-speed-rpm is 0 nan"),
        ({"correction.switch.on-above-deg": math.inf}, "--correction.switch.on-above-deg is inf"),
        ({"nmpc.horizon": 12.5}, "--nmpc.horizon is 12.5: give a whole number from 1 to 500"),
        ({"nmpc.horizon": True}, "--nmpc.horizon is 'True': give a whole number"),
        ({"supervisor": "Sound"}, "--supervisor is 'Sound': give one of faithful, sound, value"),
        (
            {"environment.density_model": "msis"},
            "--environment.density-model is 'msis': give",
        ),
        ({"nmpc.solver.backend": "numpy"}, "--nmpc.solver.backend is 'numpy': give one of auto"),
        ({"sensors.enabled": 1}, "--sensors.enabled is 1: give true or false"),
        ({"axis": (1.0, 0.0)}, "--axis is 1 0: give 3 values, each a finite number"),
        ({"nmpc": 3}, "--nmpc is 3: give a NmpcSettings"),
        ({"nmpc.horizons": 3}, "no setting 'nmpc.horizons': no 'horizons'; did you mean horizon?"),
    ],
)
def test_every_value_must_fit_however_deep(values: dict[str, Any], sentence: str) -> None:
    with pytest.raises(SettingsError, match=f"^{sentence}"):
        changed(FlightSettings(), values)


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"nominal": NominalSettings(mismatch=1e9)}, r"--nominal\.mismatch 1e\+09 makes .* above"),
        (
            {"start": StartSettings(wheel_speed_rpm=(0.0, -6001.0))},
            r"--start gives the wheels 0, -6001 rpm, their limits are 6000, 6000$",
        ),
        (
            {"start": StartSettings(omega_deg_s=(3000.0, 0.0, 0.0), zero_momentum=True)},
            r"--start gives the wheels .* their limits are 6000, 6000$",
        ),
        (
            {"sensors": SensorSettings(enabled=True, delay_samples=21)},
            r"--sensors\.delay-samples is 21, the whole flight has 21$",
        ),
        (
            {"duration_s": 1e12},
            r"1e\+12 s in samples of --sample-s 0\.05 s make 2e\+13 samples, more",
        ),
    ],
)
def test_settings_that_do_not_fit_the_flight(values: dict[str, Any], sentence: str) -> None:
    with pytest.raises(SettingsError, match=sentence):
        prepare(FlightSettings(**{"duration_s": 1.0, **values}))


def test_an_unknown_name_lists_the_models_that_exist() -> None:
    with pytest.raises(ModelError, match=r"^no model 'two_whel'; there are: .*pyramid.*two_wheel,"):
        find_model(Path("two_whel"))


def test_a_folder_is_no_model_file() -> None:
    with pytest.raises(ModelError, match=r"two_wheel' is a folder; name the MJCF file in it$"):
        read_model(MODELS / "two_wheel")
