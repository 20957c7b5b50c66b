"""What several tests need: the two-wheel model, and models edited in code."""

import tests.shape_checks  # noqa: F401  # before the modules that it checks

# isort: split

from collections.abc import Callable

import mujoco
import pytest

from simsat.mjcf import Model, interpret, read_model
from tests.places import MODELS

TWO_WHEEL = MODELS / "two_wheel" / "two_wheel.xml"


@pytest.fixture(scope="session")
def two_wheel() -> Model:
    return read_model(TWO_WHEEL)


@pytest.fixture
def edited() -> Callable[[Callable[[mujoco.MjSpec], None]], Model]:
    """Read the two-wheel model after an edit of its MjSpec."""

    def read(edit: Callable[[mujoco.MjSpec], None]) -> Model:
        spec = mujoco.MjSpec.from_file(str(TWO_WHEEL))
        edit(spec)
        return interpret(spec.compile(), "edited")

    return read
