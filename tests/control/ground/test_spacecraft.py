import pickle
from dataclasses import replace

import numpy as np

from tests.ocp_cases import TWO_WHEELS


def test_what_was_computed_of_a_craft_makes_no_other_craft_of_it() -> None:
    """A pickle is the key under which prepared problems are kept."""
    craft = replace(TWO_WHEELS)
    before = pickle.dumps(craft)
    n = craft.unactuated
    assert n is not None
    assert pickle.dumps(craft) == before
    again = pickle.loads(before)
    assert np.array_equal(again.unactuated, n)
    assert replace(craft, A=np.eye(3)[:, 1:]).unactuated[0] == 1.0  # type: ignore[index]
