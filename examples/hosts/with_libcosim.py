"""libcosim of the Open Simulation Platform, by libcosimpy: a master that steps units and connects them.

libcosim sets neither enumerations nor the mode of FMI 2.0 parameters by name: `gearmesh pack --set` does. Its
times are whole nanoseconds.
"""

from importlib.metadata import version

import fmpy
import numpy as np
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

VERSION = version("libcosimpy")


def co_simulation(fmu, scenario, outputs):
    log_output_level(CosimLogLevel.ERROR)
    reference = {v.name: v.valueReference for v in fmpy.read_model_description(str(fmu)).modelVariables}
    execution = CosimExecution.from_step_size(int(1e9 * (scenario.times[1] - scenario.times[0])))
    mesh = execution.add_local_slave(CosimLocalSlave(fmu_path=str(fmu), instance_name="mesh"))
    override, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
    execution.add_manipulator(override)
    execution.add_observer(observer)
    inputs = [reference[name] for name in scenario.names]
    rows = []
    for name, value in zip(scenario.names, scenario.values[0]):
        execution.real_initial_value(mesh, reference[name], float(value))
    for row in scenario.values[:-1]:
        override.slave_real_values(mesh, inputs, [float(value) for value in row])
        execution.step()
        rows.append(observer.last_real_values(mesh, [reference[name] for name in outputs]))
    return np.array(rows)
