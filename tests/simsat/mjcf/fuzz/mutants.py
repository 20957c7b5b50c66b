"""Mutants of the shipped spacecraft files, from a seed: what a hand, a script or a CAD export does.

Two sorts: `kinds` are things that someone might want (a weld, a thruster, a panel on a rotor, a
keyframe); the rest take the MJCF schema and change, add or drop attributes and elements anywhere.
"""

import copy
import random
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path

from simsat.mjcf.shipped import find_model, shipped_models
from tests.simsat.mjcf.fuzz import kinds
from tests.simsat.mjcf.fuzz.values import number, schema, value

NAMES = [name for name in shipped_models() if find_model(name).parent.name == name]


def mutant(seed: int) -> tuple[str, str]:
    """A file's text and a word on what was done to it."""
    rng = random.Random(seed)
    name = rng.choice(NAMES)
    root = flat(find_model(name))
    done = []
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        act = rng.choice(kinds.ALL if rng.random() < 0.65 else SCHEMATIC)
        with suppress(IndexError):  # an earlier one has taken away what this one needs
            act(root, rng)
        done.append(act.__name__)
    return ET.tostring(root, encoding="unicode"), f"{name}: {', '.join(done)}"


@cache
def _parsed(path: Path) -> ET.Element:
    root = ET.parse(path).getroot()
    for parent in list(root.iter()):
        for place, child in reversed(list(enumerate(parent))):
            if child.tag == "include":
                parent[place : place + 1] = list(
                    _parsed((path.parent / child.attrib["file"]).resolve())
                )
    return root


def flat(path: Path) -> ET.Element:
    """A file with its includes in their places."""
    return copy.deepcopy(_parsed(path))


def set_attribute(root: ET.Element, rng: random.Random) -> None:
    """A number, mostly a plain one: what the schema takes there is not looked up."""
    element = rng.choice([e for e in root.iter() if e.tag in schema()])
    attribute = rng.choice(schema()[element.tag])
    if attribute not in ("file", "name", "class"):
        element.set(attribute, value(attribute, root, rng))


def change_number(root: ET.Element, rng: random.Random) -> None:
    places = [
        (e, a) for e in root.iter() for a, v in e.attrib.items() if re.fullmatch(r"[-+\d.e ]+", v)
    ]
    element, attribute = rng.choice(places)
    words = element.attrib[attribute].split()
    k = rng.randrange(len(words))
    words[k] = rng.choice((number(rng), repr(float(words[k]) * 10 ** rng.uniform(-3, 3)),
                           repr(-float(words[k]))))  # fmt: skip
    element.set(attribute, " ".join(words))


def drop_attribute(root: ET.Element, rng: random.Random) -> None:
    element = rng.choice([e for e in root.iter() if e.attrib])
    del element.attrib[rng.choice(tuple(element.attrib))]


def drop_element(root: ET.Element, rng: random.Random) -> None:
    parent = rng.choice([e for e in root.iter() if len(e)])
    parent.remove(rng.choice(list(parent)))


def double_element(root: ET.Element, rng: random.Random) -> None:
    parent = rng.choice([e for e in root.iter() if len(e)])
    again = copy.deepcopy(rng.choice(list(parent)))
    for e in again.iter():
        if "name" in e.attrib:
            e.set("name", e.attrib["name"] + "_2")
        if again.tag == "default" and "class" in e.attrib:
            e.set("class", e.attrib["class"] + "_2")
    parent.append(again)


def move_element(root: ET.Element, rng: random.Random) -> None:
    """From one body to another: its place in the tree is all that changes."""
    homes = [e for e in root.iter() if e.tag in ("body", "worldbody")]
    home = rng.choice([e for e in homes if len(e)])
    child = rng.choice(list(home))
    home.remove(child)
    inside = set(child.iter())
    rng.choice([e for e in homes if e not in inside]).append(child)


Mutation = Callable[[ET.Element, random.Random], None]
SCHEMATIC: tuple[Mutation, ...] = (
    set_attribute, set_attribute, change_number, change_number, drop_attribute, drop_element,
    double_element, move_element,
)  # fmt: skip
