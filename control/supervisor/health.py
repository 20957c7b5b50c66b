"""Model health: how often the planner's optimal cost fell, as it would if its model were right."""

import math
from dataclasses import dataclass

WINDOW = 20  # control periods looked back on
TRIVIAL = 1e-4  # share of the largest cost seen below which the target is reached, up or down


@dataclass(frozen=True)
class Health:
    """The costs so far, as far as they matter; `health_after` makes the next one."""

    cost: float | None = None
    """The last one."""
    largest: float = 0.0
    fell: tuple[bool, ...] = ()
    """Whether each of the last costs lay below the one before it, newest last."""

    @property
    def share(self) -> float:
        """Share of the last periods in which the cost fell; 1 until there are two."""
        return sum(self.fell) / len(self.fell) if self.fell else 1.0


def health_after(health: Health, cost: float) -> Health:
    """The health after another optimal cost; costs that are all but zero, or no numbers, tell
    nothing."""
    if not math.isfinite(cost):
        return health
    largest = max(health.largest, cost)
    if health.cost is None or cost < TRIVIAL * largest:
        return Health(cost, largest, health.fell)
    return Health(cost, largest, (*health.fell, cost < health.cost)[-WINDOW:])
