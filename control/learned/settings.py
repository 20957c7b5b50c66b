"""The settings of the learned controller."""

from dataclasses import dataclass
from typing import Annotated, Literal

from ..ground.own import Own, own
from ..ground.settings import Bounds, CountOrNone, NotNegative, Positive, Settings

FEWEST_HOLD_PERIODS = 3  # two torques to move and stop, and a period of rest


@dataclass(frozen=True)
class LearnedSettings(Settings, group="learned"):
    """The learned controller."""

    network: str = "auto"
    """Network that predicts the appendages, panels or propellant: auto (the one beside the model,
    if it was trained for this spacecraft), none, a file, or a folder that learning.train_appendage
    wrote."""
    prediction: Literal["chosen", "nominal", "learned", "network"] = "chosen"
    """What plans are made with: chosen lets the value of the plan decide, period by period, between
    the nominal model, the one learned in flight, and that with a network for the appendages; the
    others fix it, for studies."""
    rate_noise: Annotated[Positive | None, Own("rate", 1e-6)] = None
    """Least gyro noise to assume, rad/s (1 sigma); 1e-6 rad in the craft's own second unless given,
    and more where the samples scatter more. Too small for the real one makes the estimate jump, too
    large slows it."""
    search_plans: CountOrNone = 5
    """How often the shape of a slew is sought at its start, every half own second, each time from
    another first guess and with what has been learned by then; 10 to 20 ms each."""
    margin_s: Annotated[NotNegative | None, Own("time", 0.25)] = None
    """Time added to the shortest slew for the motors' ramps, s; 0.25 of the craft's own seconds
    unless given. More is gentler and slower."""
    hold_s: Annotated[NotNegative | None, Own("time", 80.0)] = None
    """How long a hold to prepare for, s; 80 of the craft's own seconds unless given. The arrival is
    biased by two thirds of the drift expected over this time, and the error passes through zero at
    four fifths of it. More starts the hold further off and keeps it in bounds for longer; 0 arrives
    on the target."""
    hold_periods: Annotated[int, Bounds(FEWEST_HOLD_PERIODS)] | None = None
    """Control periods in which the hold takes out an error: none is as many as 3 own seconds are.
    Fewer is stiffer and passes on more sensor noise."""
    rearm_deg: Positive = 0.45
    """Pointing error at which a hold gives way to a new slew, degrees."""

    @property
    def margin(self) -> float:
        """Time added to the shortest slew."""
        return own(self, "margin_s")

    @property
    def hold(self) -> float:
        """How long a hold to prepare for."""
        return own(self, "hold_s")

    @property
    def noise(self) -> float:
        """Least gyro noise to assume."""
        return own(self, "rate_noise")
