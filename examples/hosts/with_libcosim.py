"""libcosim of the Open Simulation Platform, by libcosimpy: a master that steps units and connects them.

libcosim sets neither enumerations nor the mode of FMI 2.0 parameters by name: `gearmesh pack --set` does. Its
times are whole nanoseconds.
"""

from contextlib import contextmanager
from importlib.metadata import version

import fmpy
import numpy as np
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

VERSION = version("libcosimpy")


def started(fmu, step):
    """An execution with the FMU alone, in communication steps of `step` s, what sets its inputs, and its index."""
    log_output_level(CosimLogLevel.ERROR)
    execution = CosimExecution.from_step_size(round(1e9 * step))
    mesh = execution.add_local_slave(CosimLocalSlave(fmu_path=str(fmu), instance_name="mesh"))
    override = CosimManipulator.create_override()
    execution.add_manipulator(override)
    return execution, override, mesh


def references(fmu):
    return {v.name: v.valueReference for v in fmpy.read_model_description(str(fmu)).modelVariables}


@contextmanager
def resting(fmu, values, step):
    """A function that makes one step with the inputs at rest, those in `values` not at their start."""
    execution, override, mesh = started(fmu, step)
    reference = references(fmu)
    execution.step()
    override.slave_real_values(mesh, [reference[name] for name in values], list(values.values()))
    yield execution.step


def co_simulation(fmu, scenario, outputs):
    reference = references(fmu)
    execution, override, mesh = started(fmu, scenario.times[1] - scenario.times[0])
    observer = CosimObserver.create_last_value()
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
