"""Which of the surroundings reach out to an orbit, and why the others do not."""

from collections.abc import Iterator

import numpy as np

from simsat.control.ground.arrays import Matrix3
from simsat.environment import earth
from simsat.environment.orbit import Centre, Orbit

AIR_TOP_KM = 2000.0
"""Where the density table ends being of use: the torque on a small satellite is below 1e-11 Nm."""


def out_of_reach(orbit: Orbit, J: Matrix3) -> Iterator[tuple[str, str]]:
    """(name of a torque, why it is none here) of each that an orbit is too far out for."""
    radius = float(orbit.radius_at(0.0))
    altitude_km = (radius - earth.RADIUS) / 1e3
    if orbit.centre is Centre.SUN:
        moments = np.linalg.eigvalsh(J)
        most = 1.5 * earth.MU_SUN / radius**3 * float(moments[-1] - moments[0])
        yield "gravity_gradient", f"the Sun's is {most:.1g} Nm at most"
        yield "drag", "there is no air"
        yield "magnetic", "the Earth's field is far away"
        return
    if altitude_km > AIR_TOP_KM:
        yield "drag", f"there is no air above {AIR_TOP_KM:g} km"
    if radius > earth.MAGNETOSPHERE:
        radii = earth.MAGNETOSPHERE / earth.RADIUS
        yield "magnetic", f"the Earth's field ends {radii:g} Earth radii from its centre"
