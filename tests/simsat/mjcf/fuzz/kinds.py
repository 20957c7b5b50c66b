"""Things that someone might want of MuJoCo, put into a spacecraft's file with random numbers."""

import random
import xml.etree.ElementTree as ET

from tests.simsat.mjcf.fuzz.values import (
    bodies,
    bus,
    gentle,
    inertial,
    name_of,
    number,
    numbers,
    put,
    schema,
    section,
    value,
    world,
)


def weld(root: ET.Element, rng: random.Random) -> None:
    tag = rng.choice(("weld", "connect"))
    anchor = "0 0 0" if tag == "connect" else ""
    put(section(root, "equality"), tag, body1=name_of(root, "body", rng), anchor=anchor,
        body2=rng.choice(("", name_of(root, "body", rng))),
        active=rng.choice(("", "true", "false")))  # fmt: skip


def joint_equality(root: ET.Element, rng: random.Random) -> None:
    put(section(root, "equality"), "joint", joint1=name_of(root, "joint", rng),
        joint2=rng.choice(("", name_of(root, "joint", rng))), polycoef=numbers(rng, 5),
        active=rng.choice(("", "false")))  # fmt: skip


def tendon(root: ET.Element, rng: random.Random) -> None:
    what = rng.choice(("stiffness", "damping", "frictionloss", "armature", "range", "width",
                       "springlength", "springyield", "actuatorfrcrange"))  # fmt: skip
    setting = {what: "-0.1 0.1" if "range" in what else gentle(rng)}
    if rng.random() < 0.5:
        t = put(section(root, "tendon"), "fixed", name="t", **setting)
        for _ in range(rng.choice((1, 2))):
            put(t, "joint", joint=name_of(root, "joint", rng), coef=number(rng))
    else:
        put(world(root), "site", name="ws", pos="1 0 0")
        put(rng.choice(bodies(root)), "site", name="bs", pos="0.2 0.1 0")
        t = put(section(root, "tendon"), "spatial", name="t", **setting)
        put(t, "site", site="ws")
        put(t, "site", site="bs")
    if rng.random() < 0.2:
        put(section(root, "actuator"), "motor", tendon="t")


def flag(root: ET.Element, rng: random.Random) -> None:
    names = schema()["flag"]
    state = {rng.choice(names): rng.choice(("enable", "disable"))}
    put(section(root, "option"), "flag", **state)


def option(root: ET.Element, rng: random.Random) -> None:
    attribute = rng.choice(schema()["option"])
    section(root, "option").set(attribute, value(attribute, root, rng))


def timestep(root: ET.Element, rng: random.Random) -> None:
    steps = ("0.05", "0.025", "0.02", "0.001", "0", "-0.01", "1e-12")
    step = rng.choice((number(rng), gentle(rng, 1e-5, 0.1), *steps))
    section(root, "option").set("timestep", step)


def thruster(root: ET.Element, rng: random.Random) -> None:
    put(rng.choice(bodies(root)), "site", name="nozzle", pos=numbers(rng, 3))
    actuator = put(section(root, "actuator"), rng.choice(("motor", "general", "position")),
                   name="thruster", site="nozzle", gear=numbers(rng, 6))  # fmt: skip
    if rng.random() < 0.3:
        actuator.set("ctrlrange", "0 1")
    if rng.random() < 0.6:
        unused(root, rng, "thruster")


def servo(root: ET.Element, rng: random.Random) -> None:
    tag = rng.choice(
        ("position", "velocity", "intvelocity", "damper", "motor", "muscle", "general")
    )
    joint = name_of(root, "joint", rng)
    actuator = put(section(root, "actuator"), tag, name="servo", joint=joint)
    if tag == "damper":
        actuator.set("ctrlrange", "0 1")
    for attribute in rng.sample(schema()[tag], rng.choice((0, 1))):
        actuator.set(attribute, value(attribute, root, rng))
    if rng.random() < 0.6:
        unused(root, rng, "servo")


def unused(root: ET.Element, rng: random.Random, name: str = "") -> None:
    name = name or name_of(root, "general", rng)
    key = rng.choice(("unused_actuators",) * 6 + ("unused_actuator", "Unused_Actuators", "unused"))
    data = rng.choice((name,) * 5 + (name[:-1] or "x",))
    for entry in list(root.iter("text")):
        if entry.attrib["name"] == key:
            entry.set("data", f"{entry.attrib['data']} {data}")
            return
    put(section(root, "custom"), "text", name=key, data=data)


def numeric(root: ET.Element, rng: random.Random) -> None:
    wheel = name_of(root, "joint", rng)
    key = rng.choice(("speed_limit_rpm", "speed_limit_rad_s", f"{wheel}.speed_limit_rpm",
                      "speed_limit_rmp", "drag_coefficient", "dragcoefficient", "reflectivity",
                      "nominal_inertia_factors", "anything",
                      "wheel_q.speed_limit_rpm"))  # fmt: skip
    data = rng.choice((number(rng), numbers(rng, 3)))
    for entry in list(root.iter("numeric")):
        if entry.attrib.get("name") == key:
            entry.set("data", data)
            return
    put(section(root, "custom"), "numeric", name=key, data=data)


def scenery(root: ET.Element, rng: random.Random) -> None:
    here = world(root)
    if rng.random() < 0.4:
        put(here, "geom", name="earth", type="sphere", size=gentle(rng), pos=numbers(rng, 3))
        return
    body = put(here, "body", name="pillar", pos=numbers(rng, 3),
               mocap=rng.choice(("", "", "true")))  # fmt: skip
    put(body, "geom", size=gentle(rng), group=rng.choice("0123"))
    if rng.random() < 0.3:
        put(body, rng.choice(("joint", "freejoint")), name="extra")


def child_body(root: ET.Element, rng: random.Random) -> None:
    body = put(rng.choice(bodies(root)), "body", name="extra_body",
               pos=rng.choice(("0 0 0", numbers(rng, 3))))  # fmt: skip
    if rng.random() < 0.7:
        joint = put(body, "joint", name="extra_joint", axis="0 0 1",
                    type=rng.choice(("hinge", "hinge", "slide", "ball")))  # fmt: skip
        for attribute in rng.sample(schema()["joint"], rng.choice((0, 1, 2))):
            if attribute not in ("name", "type"):
                joint.set(attribute, value(attribute, root, rng))
        if rng.random() < 0.5:
            joint.set("stiffness", gentle(rng))
            joint.set("damping", gentle(rng, 1e-4, 1e-1))
        if rng.random() < 0.4:
            put(section(root, "actuator"), "motor", name="extra_motor", joint="extra_joint")
            if rng.random() < 0.3:
                unused(root, rng, "extra_motor")
    inertial(body, rng)
    put(body, "geom", size=gentle(rng), mass="0", group=rng.choice("012"))


def rotor_moved(root: ET.Element, rng: random.Random) -> None:
    """A rotor hung on the world, on another rotor, on a panel."""
    parents = {child: parent for parent in root.iter() for child in parent}
    rotors = [b for b in bodies(root) if b.find("joint") is not None]
    if not rotors:
        return
    rotor = rng.choice(rotors)
    others = [b for b in [world(root), *bodies(root)]
              if b is not None and b not in set(rotor.iter())]  # fmt: skip
    parents[rotor].remove(rotor)
    rng.choice(others).append(rotor)


def imbalance(root: ET.Element, rng: random.Random) -> None:
    rotors = [b for b in bodies(root) if b.find("joint") is not None]
    if rotors and (mass := rng.choice(rotors).find("inertial")) is not None:
        off = [rng.choice((0.0, 10 ** rng.uniform(-9, -1))) for _ in range(3)]
        mass.set("pos", " ".join(map(str, off)))


def tilted_axis(root: ET.Element, rng: random.Random) -> None:
    joints = [j for j in root.iter("joint") if "axis" in j.attrib]
    if joints:
        rng.choice(joints).set("axis", numbers(rng, 3))


def friction(root: ET.Element, rng: random.Random) -> None:
    joints = list(root.iter("joint"))
    if joints:
        what = rng.choice(("damping", "frictionloss", "stiffness", "armature"))
        sign = rng.choice(("", "", "", "-"))
        rng.choice(joints).set(what, sign + gentle(rng, 1e-7, 1e2))


def sensor(root: ET.Element, rng: random.Random) -> None:
    put(bus(root), "site", name="imu")
    put(section(root, "sensor"), rng.choice(("gyro", "accelerometer", "torque", "magnetometer")),
        name="s", site="imu", noise=gentle(rng))  # fmt: skip


def key(root: ET.Element, rng: random.Random) -> None:
    put(section(root, "keyframe"), "key", name="home", time=number(rng))


def camera(root: ET.Element, rng: random.Random) -> None:
    put(rng.choice(bodies(root)), rng.choice(("camera", "light")), pos=numbers(rng, 3))


def contact(root: ET.Element, rng: random.Random) -> None:
    put(section(root, "contact"), "pair", geom1=name_of(root, "geom", rng),
        geom2=name_of(root, "geom", rng))  # fmt: skip


def bus_moved(root: ET.Element, rng: random.Random) -> None:
    bus(root).set("pos", rng.choice((numbers(rng, 3), "7e6 0 0", "0 0 1e4", "0.1 0.2 0.3")))
    bus(root).set("euler", "0.3 0.2 0.1")


def scaled(root: ET.Element, rng: random.Random) -> None:
    """The whole spacecraft's masses and torques, by powers of ten."""
    factor = 10 ** rng.uniform(-6, 6)
    for e in root.iter():
        for name in ("mass", "diaginertia", "fullinertia", "actrange", "ctrlrange", "stiffness",
                     "damping", "frictionloss"):  # fmt: skip
            if name in e.attrib:
                larger = [repr(float(v) * factor) for v in e.attrib[name].split()]
                e.set(name, " ".join(larger))


def mesh(root: ET.Element, rng: random.Random) -> None:
    put(section(root, "asset"), "mesh", name="tetra", vertex="0 0 0 1 0 0 0 1 0 0 0 1")
    put(rng.choice(bodies(root)), "geom", type="mesh", mesh="tetra", mass=rng.choice(("0", "0.1")))


def compiler(root: ET.Element, rng: random.Random) -> None:
    attribute = rng.choice([a for a in schema()["compiler"] if not a.endswith("dir")])
    section(root, "compiler").set(attribute, value(attribute, root, rng))


def size(root: ET.Element, rng: random.Random) -> None:
    attribute = rng.choice(("njmax", "nconmax", "memory", "nuser_body", "nuserdata", "nkey"))
    section(root, "size").set(attribute, rng.choice(("1", "0", "5", "1000", "1M", "-1", "64K")))


ALL = (
    weld, joint_equality, tendon, flag, option, timestep, thruster, servo, unused, numeric, scenery,
    child_body, rotor_moved, imbalance, tilted_axis, friction, sensor, key, camera, contact,
    bus_moved, scaled, mesh, compiler, size,
)  # fmt: skip
