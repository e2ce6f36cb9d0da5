"""The housing as an FMU: `pythonfmu build -f housing_fmu.py subsystems.py`."""

import json
from pathlib import Path

import numpy as np
from pythonfmu import Fmi2Causality, Fmi2Slave, Real
from subsystems import MODES, SENSOR, housing, seat_motion, shape


class Housing(Fmi2Slave):
    """Inputs: forces on the seats. Outputs: motion of the seats, acceleration at the sensor."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        begin = json.loads(Path(self.resources, "start.json").read_text()) if self.resources else {}
        self.system = housing(np.array(begin.get("housing", [0.0] * (2 * MODES))))
        self.u = np.array(begin.get("forces", [0.0, 0.0]))
        for i in (0, 1):
            self._input(f"seat{i + 1}.force", i)
        for i, name in enumerate(("seat1.position", "seat2.position", "seat1.velocity", "seat2.velocity")):
            self._output(name, lambda k=i: float(seat_motion(self.system.x)[k]))
        self._output("sensor.acceleration", self._acceleration)

    def _input(self, name, i):
        def put(value):
            self.u[i] = value

        self.register_variable(Real(name, causality=Fmi2Causality.input, start=float(self.u[i]), getter=lambda: float(self.u[i]), setter=put))

    def _output(self, name, value):
        self.register_variable(Real(name, causality=Fmi2Causality.output, getter=value))

    def _acceleration(self):
        rate = self.system.a @ self.system.x + self.system.b @ self.u
        return float((shape(SENSOR) @ rate[MODES:])[0])

    def do_step(self, current_time, step_size):
        self.system.x = self.system.step(self.u, self.u, step_size)
        return True
