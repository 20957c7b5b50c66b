"""The settings of the rods' planner."""

from dataclasses import dataclass
from typing import Annotated

from ..ground.settings import Bounds, NotNegative, Positive, Settings

FASTEST_RESPONSE = 5.0  # periods: a faster loop would answer its own sampling


@dataclass(frozen=True)
class RodSettings(Settings, group="rods"):
    """Magnetic rods: what the dipoles are planned for. Unused by a craft without rods."""

    enabled: bool = True
    """Use the rods; off they carry no dipole."""
    response_periods: Annotated[float, Bounds(FASTEST_RESPONSE)] = 20.0
    """Time constant of the hold about the axis that wheels can't push, in control periods: 10 s at
    2 Hz. Shorter is stiffer and passes on more of the gyro's noise."""
    unloading_periods: Positive = 200.0
    """Time constant at which stored momentum is dumped where the field allows it, in control
    periods."""
    near_deg: NotNegative = 0.5
    """Pointing error below which the rods hold the attitude; beyond it they only take away the
    momentum that would not let the craft rest at the target."""
    bias_momentum_Nms: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Momentum to keep in the wheels, Nms, body axes: what the unloading leaves. In the wheels'
    plane it makes the third axis controllable by wheels, and the craft less agile."""
