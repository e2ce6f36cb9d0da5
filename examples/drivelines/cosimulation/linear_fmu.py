"""A linear system as an FMU: what shafts and housing share."""

import json
from pathlib import Path

from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class LinearSlave(Fmi2Slave):
    """Steps `self.system` under the inputs `self.u` and the loads `self.drive`, which rise within `self.rise` s."""

    drive, rise = 0.0, 0.0

    def begin(self):
        """Start values that were packed, by name."""
        return json.loads(Path(self.resources, "start.json").read_text()) if self.resources else {}

    def add_inputs(self, names):
        for i, name in enumerate(names):
            put, get = (lambda value, k=i: self.u.__setitem__(k, value)), (lambda k=i: float(self.u[k]))
            self.register_variable(Real(name, causality=Fmi2Causality.input, start=get(), getter=get, setter=put))

    def add_output(self, name, value):
        self.register_variable(Real(name, causality=Fmi2Causality.output, getter=value))

    def do_step(self, current_time, step_size):
        middle = current_time + 0.5 * step_size
        loads = self.u + self.drive * (min(1.0, middle / self.rise) if self.rise else 1.0)
        self.system.x = self.system.step(loads, loads, step_size)
        return True
