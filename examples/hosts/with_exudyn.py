"""Exudyn: both gears are rigid bodies, the mesh a load on each, evaluated by Model Exchange at every stage.

A user function is called whenever the solver wants forces, several times a step and for steps that it rejects; Model
Exchange may be asked in any order. `NodeType.RotationRxyz` has the unit's own angles and runs in explicit solvers, too.
"""

import exudyn as exu
import numpy as np
from exudyn.utilities import InertiaCuboid
from gearmesh import GearPair

VERSION = exu.__version__
CURRENT = exu.ConfigurationType.Current
QUANTITIES = exu.OutputVariableType


class Mesh:
    """Two free gears and the unit between them, in `mbs`; the rest of the machine is added to it."""

    def __init__(self, fmu, inertia=None):
        self.pair = GearPair(fmu, interface="model-exchange")
        self.mbs = exu.SystemContainer().AddSystem()
        self.nodes = []
        self._time = None
        inertia = inertia or InertiaCuboid(density=7850.0, sideLengths=[0.06, 0.06, 0.025])
        for gear in ("gear1", "gear2"):
            start = [self.pair.u[self.pair.input[f"{gear}.position[{i}]"]] for i in (1, 2, 3)]
            created = self.mbs.CreateRigidBody(
                referencePosition=start, inertia=inertia, nodeType=exu.NodeType.RotationRxyz, returnDict=True
            )
            self.nodes.append(created["nodeNumber"])
            for create, quantity in ((self.mbs.CreateForce, "force"), (self.mbs.CreateTorque, "moment")):
                create(itemNumber=created["bodyNumber"], loadVectorUserFunction=self._load(gear, quantity))

    def _load(self, gear, quantity):
        # The first of the four loads of a stage evaluates for all of them.
        def user_function(mbs, t, load):
            if (gear, quantity) == ("gear1", "force"):
                self.evaluate(t)
            return [self.pair[f"{gear}.{quantity}[{i}]"] for i in (1, 2, 3)]

        return user_function

    def hand_over(self):
        """Poses and velocities of the current stage."""
        for gear, node in zip(("gear1", "gear2"), self.nodes):
            # Displacements from the reference position, and the angles.
            angles = self.mbs.GetNodeOutput(node, QUANTITIES.Coordinates, CURRENT)[3:]
            for name, values in (
                ("position", self.mbs.GetNodeOutput(node, QUANTITIES.Position, CURRENT)),
                ("angles", angles),
                ("velocity", self.mbs.GetNodeOutput(node, QUANTITIES.Velocity, CURRENT)),
                ("angularVelocity", self.mbs.GetNodeOutput(node, QUANTITIES.AngularVelocity, CURRENT)),
            ):
                for i, value in enumerate(values):
                    self.pair[f"{gear}.{name}[{i + 1}]"] = value

    def evaluate(self, time):
        self.hand_over()
        self.pair.evaluate(time)


def _rates(angles, turning):
    """Rates of the angles of Rx(a) Ry(b) Rz(c) for an angular velocity in world axes."""
    a, b, _ = angles
    columns = [[1, 0, 0], [0, np.cos(a), np.sin(a)], [np.sin(b), -np.sin(a) * np.cos(b), np.cos(a) * np.cos(b)]]
    return np.linalg.solve(np.array(columns).T, turning)


def model_exchange(fmu, scenario, outputs):
    """The unit's outputs inside Exudyn's evaluation of forces at the imposed poses."""
    mesh = Mesh(fmu)
    mbs, pair = mesh.mbs, mesh.pair
    mbs.Assemble()
    solver = exu.MainSolverExplicit()
    settings = exu.SimulationSettings()
    settings.timeIntegration.solverType = exu.DynamicSolverType.RK44
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    start = [pair.u[pair.input[f"gear2.position[{i}]"]] for i in (1, 2, 3)]
    rows = []
    for i, (time, row) in enumerate(zip(scenario.times, scenario.values)):
        imposed = dict(zip(scenario.names, row))

        def value(name, imposed=imposed):
            return imposed.get(name, 0.0)

        q, qt = np.zeros(12), np.zeros(12)
        for gear, at in (("gear1", 0), ("gear2", 6)):
            angles = [value(f"{gear}.angles[{k}]") for k in (1, 2, 3)]
            q[at + 3 : at + 6] = angles
            qt[at : at + 3] = [value(f"{gear}.velocity[{k}]") for k in (1, 2, 3)]
            qt[at + 3 : at + 6] = _rates(angles, [value(f"{gear}.angularVelocity[{k}]") for k in (1, 2, 3)])
        q[6] = imposed["gear2.position[1]"] - start[0]
        mbs.systemData.SetODE2Coordinates(q, CURRENT)
        mbs.systemData.SetODE2Coordinates_t(qt, CURRENT)
        if i == 0:
            mesh.hand_over()
            pair.initialize()
            solver.InitializeSolver(mbs, settings)
            mbs.systemData.SetODE2Coordinates(q, CURRENT)
            mbs.systemData.SetODE2Coordinates_t(qt, CURRENT)
        mbs.systemData.SetTime(time, CURRENT)
        solver.ComputeODE2RHS(mbs)
        rows.append([pair[name] for name in outputs])
    pair.close()
    return np.array(rows)
