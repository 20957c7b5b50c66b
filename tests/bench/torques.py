"""What each external torque amounts to over an orbit: python -m tests.bench.torques."""

import numpy as np

from simsat.control.ground.attitude import IDENTITY
from simsat.environment import EnvironmentSettings, OrbitSettings, build_environment
from simsat.mjcf import read_model
from simsat.mjcf.shipped import MODELS

ALTITUDES_KM = (400.0, 500.0, 600.0)
EVERYTHING = EnvironmentSettings(solar_pressure=True, magnetic=True)


def main() -> None:
    """Print mean and largest size of each torque on two_wheel, held at the identity attitude."""
    craft = read_model(MODELS / "two_wheel" / "two_wheel.xml").spacecraft
    print(f"| uNm, mean / max of an orbit | {' | '.join(f'{h:g} km' for h in ALTITUDES_KM)} |")
    print("| --- " * (1 + len(ALTITUDES_KM)) + "|")
    columns = []
    for altitude_km in ALTITUDES_KM:
        env = build_environment(craft, OrbitSettings(altitude_km=altitude_km), EVERYTHING)
        t = np.linspace(0.0, env.orbit.period, 1000)
        torques = env.torques(t, np.tile(IDENTITY, (len(t), 1)))
        columns.append({k: 1e6 * np.linalg.norm(v, axis=1) for k, v in torques.items()})
    for name in columns[0]:
        cells = [f"{c[name].mean():.3f} / {c[name].max():.3f}" for c in columns]
        print(f"| {name.replace('_', ' ')} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
