"""The shafts as an FMU: `pythonfmu build -f shafts_fmu.py subsystems.py`."""

import json
from pathlib import Path

import numpy as np
from pythonfmu import Fmi2Causality, Fmi2Slave, Real
from subsystems import bearing_forces, shafts

CENTER_DISTANCE = 98e-3
QUANTITIES = ("position[1]", "position[2]", "angles[3]", "velocity[1]", "velocity[2]", "angularVelocity[3]")
# Index in the state of those of gear 1; those of gear 2 are three further.
PLACES = (0, 1, 2, 6, 7, 8)


class Shafts(Fmi2Slave):
    """Inputs: loads of the teeth, motion of the seats. Outputs: poses of the gears, forces on the seats."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        begin = json.loads(Path(self.resources, "start.json").read_text()) if self.resources else {}
        self.system = shafts(np.array(begin.get("shafts", [0.0] * 12)))
        self.drive = np.concatenate([begin.get("drive", [0.0] * 6), np.zeros(4)])
        self.u = np.array(begin.get("exchange", [0.0] * 10))
        names = [f"{g}.{n}" for g in ("gear1", "gear2") for n in ("force[1]", "force[2]", "moment[3]")]
        names += ["seat1.position", "seat2.position", "seat1.velocity", "seat2.velocity"]
        for i, name in enumerate(names):
            self._input(name, i)
        for g in (0, 1):
            for name, place in zip(QUANTITIES, PLACES):
                offset = CENTER_DISTANCE if g == 1 and name == "position[1]" else 0.0
                self._output(f"gear{g + 1}.{name}", lambda k=place + 3 * g, c=offset: float(self.system.x[k]) + c)
        for i in (0, 1):
            self._output(f"seat{i + 1}.force", lambda k=i: float(bearing_forces(self.system.x, self.u[6:])[k]))

    def _input(self, name, i):
        def put(value):
            self.u[i] = value

        self.register_variable(Real(name, causality=Fmi2Causality.input, start=float(self.u[i]), getter=lambda: float(self.u[i]), setter=put))

    def _output(self, name, value):
        self.register_variable(Real(name, causality=Fmi2Causality.output, getter=value))

    def do_step(self, current_time, step_size):
        u = self.u + self.drive
        self.system.x = self.system.step(u, u, step_size)
        return True
