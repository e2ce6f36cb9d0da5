"""fmpy: whole simulations with input signals, both interfaces."""

import fmpy
import numpy as np

VERSION = fmpy.__version__


def _run(fmu, scenario, outputs, kind):
    step = float(scenario.times[1] - scenario.times[0])
    result = fmpy.simulate_fmu(
        str(fmu),
        fmi_type=kind,
        solver="Euler",  # of Model Exchange; there are no states
        step_size=step if kind == "ModelExchange" else None,
        output_interval=step,
        stop_time=float(scenario.times[-1]),
        input=scenario.record(),
        output=outputs,
    )
    # fmpy puts outputs into the order of modelDescription.xml.
    return np.column_stack([result[name] for name in outputs])


def co_simulation(fmu, scenario, outputs):
    """The row of a time belongs to the inputs of the row before."""
    return _run(fmu, scenario, outputs, "CoSimulation")[1:]


def model_exchange(fmu, scenario, outputs):
    """The row of a time belongs to the inputs of that time."""
    return _run(fmu, scenario, outputs, "ModelExchange")
