"""The last seconds of a filter: what was read and told when, and the estimate at each reading.

What comes late is put where it belongs, and the estimates from there on are made anew.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..ground.arrays import Array, Vector3
from ..interface.measurement import Fix, Sighting
from .propagation import propagated
from .state import FilterState, GyroKnowledge
from .update import with_fix, with_sighting

SPAN = 3.0  # s kept: the latest instrument we know is 1 s late
SAME_TIME = 1e-6  # s

Aid = Fix | Sighting


@dataclass(frozen=True)
class Node:
    """A gyro reading, what was told of its time, and the estimate with all that."""

    t: float
    reading: Vector3
    """rad/s."""
    aids: tuple[Aid, ...]
    state: FilterState
    """Stale while the timeline is being added to."""


Timeline = tuple[Node, ...]


def started(fix: Fix, reading: Vector3, first: FilterState) -> Timeline:
    """A timeline of one reading, that of the first fix."""
    return (Node(fix.t, reading, (fix,), first),)


def extended(
    timeline: Timeline, t: Array, readings: Array, aids: tuple[Aid, ...], gyro: GyroKnowledge
) -> Timeline:
    """The timeline with new readings at rising times t, shape (k), (k, 3), and with aids of any
    time; those from before it are left out."""
    nodes, known = list(timeline), len(timeline)
    last = nodes[-1]
    for time, reading in zip(t.tolist(), readings, strict=True):
        if time > last.t + SAME_TIME:
            nodes.append(Node(time, reading, (), last.state))
    changed = known
    for aid in sorted(aids, key=lambda aid: aid.t):
        place = _placed(nodes, aid)
        if place is not None:
            changed = min(changed, place)
    return _trimmed(_recomputed(nodes, changed, gyro))


def _placed(nodes: list[Node], aid: Aid) -> int | None:
    """Put an aid to the reading of its time, between two readings to one in between; the first
    node whose estimate is to be made anew for it. None if it is too old, of the future or known."""
    times = np.array([node.t for node in nodes])
    place = int(np.searchsorted(times, aid.t - SAME_TIME))
    if place == len(nodes) or (place == 0 and aid.t < times[0] - SAME_TIME):
        return None
    node = nodes[place]
    if place == 0 and not any(_same(aid, old) for old in node.aids):
        # nothing before it to be propagated from
        nodes[0] = replace(node, aids=(*node.aids, aid), state=with_aids(node.state, (aid,)))
        return 1
    if abs(node.t - aid.t) <= SAME_TIME:
        if any(_same(aid, old) for old in node.aids):
            return None
        nodes[place] = replace(node, aids=(*node.aids, aid))
    else:
        before = nodes[place - 1]
        share = (aid.t - before.t) / (node.t - before.t)
        reading = before.reading + share * (node.reading - before.reading)
        nodes.insert(place, Node(aid.t, reading, (aid,), before.state))
    return place


def _same(a: Aid, b: Aid) -> bool:
    """Whether an instrument repeats itself."""
    if isinstance(a, Fix) and isinstance(b, Fix):
        return np.array_equal(a.q, b.q)
    if isinstance(a, Sighting) and isinstance(b, Sighting):
        return np.array_equal(a.direction_B, b.direction_B)
    return False


def _recomputed(nodes: list[Node], first: int, gyro: GyroKnowledge) -> list[Node]:
    """The nodes with the estimates from `first` on, which is not 0, made anew."""
    for k in range(first, len(nodes)):
        node, before = nodes[k], nodes[k - 1]
        state = propagated(before.state, node.t, before.reading, node.reading, gyro)
        nodes[k] = replace(node, state=with_aids(state, node.aids))
    return nodes


def with_aids(state: FilterState, aids: tuple[Aid, ...]) -> FilterState:
    """The estimate after everything told of its time."""
    for aid in aids:
        state = with_fix(state, aid) if isinstance(aid, Fix) else with_sighting(state, aid)
    return state


def _trimmed(nodes: list[Node]) -> Timeline:
    newest = nodes[-1].t
    return tuple(node for node in nodes if node.t > newest - SPAN)
