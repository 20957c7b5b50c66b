"""The magnetic field as the craft knows it, added to what is sensed."""

from dataclasses import dataclass, replace

import numpy as np

from simsat.control.ground import attitude
from simsat.control.ground.arrays import WheelVector
from simsat.control.interface.measurement import Measurement
from simsat.environment.fields.field import MagneticField
from simsat.flight.loop import Sense
from simsat.plant.plant import Plant


@dataclass(frozen=True)
class WithFieldModel:
    """Adds the field of a model on board, turned into body axes by the attitude as sensed.

    The craft knows its orbit and the time; its attitude only as well as it is sensed.
    """

    sense: Sense
    model: MagneticField

    def __call__(self, plant: Plant, samples: int, torque: WheelVector) -> Measurement:
        """The measurement with the field."""
        sensed = self.sense(plant, samples, torque)
        R = attitude.rotation_matrix(sensed.q)
        return replace(sensed, field_B=R.T @ np.array(self.model(float(sensed.t))))
