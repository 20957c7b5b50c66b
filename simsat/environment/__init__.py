"""What space does to the spacecraft: orbit, gravity gradient, drag, sunlight, magnetic field."""

from simsat.environment.environment import Environment, EnvironmentSettings, build_environment
from simsat.environment.orbit import Orbit, OrbitSettings

__all__ = ["Environment", "EnvironmentSettings", "Orbit", "OrbitSettings", "build_environment"]
