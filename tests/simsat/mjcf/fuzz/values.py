"""Numbers, words and names to put into an MJCF file, from a seeded generator."""

import math
import random
import re
import xml.etree.ElementTree as ET
from functools import cache

import mujoco

WORDS = {  # values of the attributes that are no numbers and no names
    "integrator": "Euler RK4 implicit implicitfast discrete",
    "cone": "pyramidal elliptic",
    "jacobian": "dense sparse auto",
    "solver": "PGS CG Newton",
    "type": "free ball slide hinge sphere box capsule cylinder ellipsoid plane mesh",
    "dyntype": "none integrator filter filterexact",
    "gaintype": "fixed affine",
    "biastype": "none affine",
    "angle": "radian degree",
    "inertiafromgeom": "true false auto",
    "fluidshape": "none ellipsoid",
    "sleep": "auto never allowed init",
    "interp": "zoh linear cubic",
    "shellinertia": "true false",
    "eulerseq": "xyz XYZ zyx",
    "input": "pos vel",
}
SWITCHES = re.compile(
    r".*limited|autolimits|balanceinertia|fusestatic|discardvisual|actearly|actuatorgravcomp|"
    r"alignfree|align|active|mocap|castshadow|usethread|strippath|inheritrange"
)
REFERS = {"joint": "joint", "jointinparent": "joint", "site": "site", "refsite": "site",
          "body": "body", "cranksite": "site", "slidersite": "site", "class": "default",
          "childclass": "default", "body1": "body", "body2": "body", "joint1": "joint",
          "joint2": "joint", "geom": "geom", "geom1": "geom", "geom2": "geom"}  # fmt: skip
VECTORS = {"pos": 3, "axis": 3, "euler": 3, "quat": 4, "size": 3, "gravity": 3, "wind": 3,
           "magnetic": 3, "diaginertia": 3, "fullinertia": 6, "gear": 6, "range": 2, "solref": 2,
           "ctrlrange": 2, "actrange": 2, "forcerange": 2, "actuatorfrcrange": 2, "springdamper": 2,
           "damping": 3, "stiffness": 3, "friction": 3, "solreffriction": 2, "solimpfriction": 3,
           "surfacevel": 6, "fluidcoef": 5, "zaxis": 3, "rgba": 4, "gainprm": 3, "biasprm": 3,
           "dynprm": 2, "o_friction": 5, "o_solref": 2, "solreflimit": 2}  # fmt: skip


def number(rng: random.Random) -> str:
    kind = rng.random()
    if kind < 0.05:
        return rng.choice(("nan", "inf", "-inf", "1e400"))
    if kind < 0.2:
        return rng.choice(("0", "1", "-1", "2", "1e-9", "1e9", "0.5"))
    return f"{rng.choice((1, 1, 1, -1)) * 10 ** rng.uniform(-6, 3):.6g}"


def numbers(rng: random.Random, count: int) -> str:
    return " ".join(number(rng) for _ in range(count))


def gentle(rng: random.Random, low: float = 1e-3, high: float = 1.0) -> str:
    return f"{10 ** rng.uniform(math.log10(low), math.log10(high)):.6g}"


def value(attribute: str, root: ET.Element, rng: random.Random) -> str:
    """Something that the schema might take for this attribute."""
    if attribute in WORDS and rng.random() < 0.95:
        return rng.choice(WORDS[attribute].split())
    if SWITCHES.fullmatch(attribute):
        return rng.choice(("true", "false", "auto"))
    if attribute in REFERS:
        return name_of(root, REFERS[attribute], rng)
    if attribute == "name":
        return rng.choice(("bus", "wheel_x", "thing", "motor_x", "a b"))
    if attribute in ("group", "condim", "priority", "contype", "conaffinity", "nsample"):
        return str(rng.choice((0, 1, 2, 3, 5, 31, -1)))
    if attribute in VECTORS:
        return numbers(rng, rng.choice((1, VECTORS[attribute], VECTORS[attribute])))
    return number(rng)


def name_of(root: ET.Element, tag: str, rng: random.Random) -> str:
    attribute = "class" if tag == "default" else "name"
    tags = (tag, "freejoint") if tag == "joint" else (tag,)
    found = [e.attrib[attribute] for e in root.iter() if e.tag in tags and attribute in e.attrib]
    return rng.choice(found) if found else "nobody"


def bodies(root: ET.Element) -> list[ET.Element]:
    return list(root.iter("body"))


def world(root: ET.Element) -> ET.Element:
    found = root.find("worldbody")
    return root if found is None else found


def bus(root: ET.Element) -> ET.Element:
    return next((b for b in bodies(root) if b.find("freejoint") is not None), world(root))


def section(root: ET.Element, tag: str) -> ET.Element:
    return ET.SubElement(root, tag)


def put(parent: ET.Element, tag: str, **attributes: str) -> ET.Element:
    return ET.SubElement(parent, tag, {k: v for k, v in attributes.items() if v})


def inertial(parent: ET.Element, rng: random.Random) -> None:
    """The same about every axis, in place or anywhere."""
    put(parent, "inertial", pos=rng.choice(("0 0 0", numbers(rng, 3))), mass=gentle(rng, 0.1, 3),
        diaginertia=" ".join([gentle(rng, 1e-4, 1e-1)] * 3))  # fmt: skip


@cache
def schema() -> dict[str, list[str]]:
    """Attributes of every element, of all its places in MuJoCo's schema together."""
    attributes: dict[str, list[str]] = {}
    tag = ""
    for line in mujoco.mj_printSchema(False, False).splitlines():
        head = re.match(r"\s*(\S+) \(.\)\s*(.*)", line)
        tag, rest = (head[1].removeprefix("(world)"), head[2]) if head else (tag, line)
        attributes.setdefault(tag, []).extend(w for w in rest.split() if w not in attributes[tag])
    return {tag: names for tag, names in attributes.items() if names}
