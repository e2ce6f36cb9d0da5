"""Exudyn: both gears are rigid bodies, the mesh a load on each, evaluated by Model Exchange at every stage.

A user function is called whenever the solver wants forces, several times a step and for steps that it rejects; Model
Exchange may be asked in any order. `NodeType.RotationRxyz` has the FMU's own angles and runs in explicit solvers, too.
"""

import exudyn as exu
import numpy as np
from exudyn.utilities import InertiaCuboid
from gearmesh import GearPair
from gearmesh.exudyn import attach
from gearmesh.poses import cardan_axes, place

VERSION = exu.__version__
CURRENT = exu.ConfigurationType.Current
QUANTITIES = ("position", "angles", "velocity", "angularVelocity")


def model_exchange(fmu, scenario, outputs):
    """The FMU's outputs inside Exudyn's evaluation of forces at the imposed poses."""
    with GearPair(fmu, interface="model-exchange") as pair:
        mbs = exu.SystemContainer().AddSystem()
        starts = np.array([[pair.u[pair.input[f"gear{gear}.position[{i}]"]] for i in (1, 2, 3)] for gear in (1, 2)])
        inertia = InertiaCuboid(density=7850.0, sideLengths=[0.06, 0.06, 0.025])
        bodies = [
            mbs.CreateRigidBody(referencePosition=start, inertia=inertia, nodeType=exu.NodeType.RotationRxyz, returnDict=True)
            for start in starts
        ]
        attach(mbs, pair, [body["nodeNumber"] for body in bodies], starts)
        mbs.Assemble()
        solver, settings = exu.MainSolverExplicit(), exu.SimulationSettings()
        settings.timeIntegration.solverType = exu.DynamicSolverType.RK44
        settings.timeIntegration.verboseMode = 0
        settings.solution.file.write = False
        initial = {f"gear2.position[{i + 1}]": value for i, value in enumerate(starts[1])}
        rows = []
        for time, row in zip(scenario.times, scenario.values):
            imposed = initial | dict(zip(scenario.names, row))
            position, angles, velocity, spin = (
                np.array([[imposed.get(f"gear{gear}.{name}[{i}]", 0.0) for i in (1, 2, 3)] for gear in (1, 2)]) for name in QUANTITIES
            )
            q = np.hstack([position - starts, angles]).ravel()
            q_t = np.hstack([velocity, np.linalg.solve(cardan_axes(angles), spin[..., None])[..., 0]]).ravel()
            if not rows:
                place(pair, q, q_t, starts)
                pair.initialize()
                solver.InitializeSolver(mbs, settings)
            mbs.systemData.SetODE2Coordinates(q, CURRENT)
            mbs.systemData.SetODE2Coordinates_t(q_t, CURRENT)
            mbs.systemData.SetTime(time, CURRENT)
            solver.ComputeODE2RHS(mbs)
            rows.append([pair[name] for name in outputs])
    return np.array(rows)
