"""The housing as an FMU: `pythonfmu build -f housing_fmu.py subsystems.py linear_fmu.py`."""

import numpy as np
from linear_fmu import LinearSlave
from subsystems import MODES, SENSOR, housing, seat_motion, shape


class Housing(LinearSlave):
    """Inputs: forces on the seats. Outputs: motion of the seats, acceleration at the sensor."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        begin = self.begin()
        self.system = housing(np.array(begin.get("housing", [0.0] * (2 * MODES))))
        self.u = np.array(begin.get("forces", [0.0, 0.0]))
        self.add_inputs(["seat1.force", "seat2.force"])
        for i, name in enumerate(("seat1.position", "seat2.position", "seat1.velocity", "seat2.velocity")):
            self.add_output(name, lambda k=i: float(seat_motion(self.system.x)[k]))
        self.add_output("sensor.acceleration", self._acceleration)

    def _acceleration(self):
        rate = self.system.a @ self.system.x + self.system.b @ self.u
        return float((shape(SENSOR) @ rate[MODES:])[0])
