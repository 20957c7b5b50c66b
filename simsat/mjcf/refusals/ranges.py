"""Refusals of ranges that MuJoCo would leave out without a word: a limit written backwards."""

from collections.abc import Iterator

import mujoco

JOINT = ("range", "actfrcrange")
ACTUATOR = ("ctrlrange", "forcerange", "actrange")
SPELLED = {"actfrcrange": "actuatorfrcrange"}


def empty_ranges(spec: mujoco.MjSpec) -> Iterator[str]:
    """Ranges whose first number is not the smaller one: the compiled model has no trace of them."""
    for kind, elements, ranges in (
        ("joint", spec.joints, JOINT),
        ("actuator", spec.actuators, ACTUATOR),
    ):
        for k, element in enumerate(elements):
            for name in ranges:
                low, high = getattr(element, name)
                if low >= high and (low, high) != (0.0, 0.0):
                    who = f"'{element.name}'" if element.name else f"number {k + 1}"
                    yield (
                        f"{kind} {who}: {SPELLED.get(name, name)} {low:g} {high:g} holds nothing, "
                        "MuJoCo would leave the limit out; give the smaller number first"
                    )
