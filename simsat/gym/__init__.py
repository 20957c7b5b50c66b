"""Slews as Gymnasium environments, once imported: `gymnasium.make("simsat/TwoWheel-v0")`.

Every spacecraft in models/ has one, of its name; `model="my_craft.xml"` and every other setting of
a flight are keyword arguments. What an agent learns here flies with `simsat.fly` and in campaigns,
as a controller (`follow_policy`).

Raises `ImportError` without Gymnasium, which only this room needs.
"""

from importlib.util import find_spec

if find_spec("gymnasium") is None:
    raise ImportError(
        "learning to fly needs Gymnasium, which flying doesn't: pip install 'simsat[gym]'",
        name=__name__,
    )

import gymnasium

from simsat.gym.environment import SlewEnv
from simsat.gym.policy import follow_policy
from simsat.mjcf.shipped import shipped_models

__all__ = ["SlewEnv", "follow_policy"]

for _model in shipped_models():
    _name = _model.replace("_", " ").title().replace(" ", "")
    gymnasium.register(
        f"simsat/{_name}-v0",
        entry_point="simsat.gym.environment:SlewEnv",
        kwargs={"model": _model},
    )
