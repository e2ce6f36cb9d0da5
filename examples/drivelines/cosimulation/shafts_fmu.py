"""The shafts as an FMU: `pythonfmu build -f shafts_fmu.py subsystems.py linear_fmu.py`."""

import numpy as np
from linear_fmu import LinearSlave
from subsystems import bearing_forces, shafts

CENTER_DISTANCE = 98e-3
# Index in the state of those of gear 1; those of gear 2 are three further.
PLACES = {"position[1]": 0, "position[2]": 1, "angles[3]": 2, "velocity[1]": 6, "velocity[2]": 7, "angularVelocity[3]": 8}


class Shafts(LinearSlave):
    """Inputs: loads of the teeth, motion of the seats. Outputs: poses of the gears, forces on the seats."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        begin = self.begin()
        self.system = shafts(np.array(begin.get("shafts", [0.0] * 12)))
        self.drive = np.concatenate([begin.get("drive", [0.0] * 6), np.zeros(4)])
        self.rise = begin.get("rise", 0.0)
        self.u = np.array(begin.get("exchange", [0.0] * 10))
        loads = [f"{g}.{n}" for g in ("gear1", "gear2") for n in ("force[1]", "force[2]", "moment[3]")]
        self.add_inputs([*loads, "seat1.position", "seat2.position", "seat1.velocity", "seat2.velocity"])
        for g in (0, 1):
            for name, place in PLACES.items():
                offset = CENTER_DISTANCE if g == 1 and name == "position[1]" else 0.0
                self.add_output(f"gear{g + 1}.{name}", lambda k=place + 3 * g, c=offset: float(self.system.x[k]) + c)
        for i in (0, 1):
            self.add_output(f"seat{i + 1}.force", lambda k=i: float(bearing_forces(self.system.x, self.u[6:])[k]))
