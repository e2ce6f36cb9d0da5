"""A pair on flexible shafts and bearings in an elastic housing on mounts, in exudyn, and its run-up and run-down.

z runs along the shafts, gear 1's z = 0 face lies at the origin and the output shaft at x = C. Every body has a node
with Tait-Bryan angles x-y-z (spin last), which Runge-Kutta 4 integrates without constraints. A piece of
shaft is a spring between two bodies, taken at its middle, where the stiffness of a Timoshenko beam is diagonal.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path

import exudyn as exu
import exudyn.utilities as items
import numpy as np
from gearmesh import GearPair, History
from gearmesh.exudyn import attach, attach_stepped
from scipy.sparse import csr_matrix

from .files import local, opened, shipped
from .walls import housing

Output = exu.OutputVariableType
DENSITY, YOUNG, SHEAR = 7850.0, 206e9, 206e9 / 2.6  # steel
SHEAR_FACTOR = 0.9  # of a round section


@dataclass(frozen=True)
class Gears:
    """What the assembly needs of an external pair; SI units, z of both faces of each gear."""

    name: str
    teeth: tuple[int, int]
    center_distance: float
    faces: tuple[tuple[float, float], tuple[float, float]]

    @property
    def pitch_radii(self) -> tuple[float, float]:
        return tuple(self.center_distance * z / sum(self.teeth) for z in self.teeth)


HELICAL = Gears("helical-25-47", (25, 47), 98.0e-3, ((0.0, 24e-3), (1e-3, 23e-3)))
SPUR = Gears("spur-50-50", (50, 50), 150.0e-3, ((0.0, 20e-3), (0.0, 20e-3)))


@dataclass(frozen=True)
class Shaft:
    """A round shaft along z: stations, and which of them carry gear, fixed and floating bearing, coupling."""

    diameter: float
    stations: tuple[float, ...]
    gear: int
    bearings: tuple[int, int]
    coupling: int


GEAR = None  # mid-face of the gear
SHAFTS = (
    Shaft(30e-3, (-0.090, -0.040, GEAR, 0.056, 0.100), gear=2, bearings=(1, 4), coupling=0),
    Shaft(40e-3, (-0.040, GEAR, 0.056, 0.100, 0.150), gear=1, bearings=(0, 3), coupling=4),
)
BEARING_RADIAL, BEARING_AXIAL = 2e8, 1e8  # N/m; axial for the fixed bearing alone
BEARING_DAMPING = 300.0  # N s/m
MATERIAL_DAMPING = 4e-7  # s, times the shafts' stiffness
COUPLING, COUPLING_DAMPING = (1e4, 2e4), (1.0, 2.0)  # N m/rad, N m s/rad; input, output
INERTIAS = (0.01, 0.05)  # kg m^2, motor and load
RPM = math.pi / 30.0
STEP = 1e-5  # s; Runge-Kutta 4 stands 1.4e-5, the shafts' axial modes limit it
# zeta = 0.02: test rigs with spur gears on roller bearings show 0.01 to 0.03.
SPUR_DAMPING = 500.0
VARIANTS = {
    "variable load": {},
    "constant load": {"loadDependent": False},
    "constant stiffness": {"stiffnessModel": "constant"},
}


@dataclass(frozen=True)
class Body:
    """A rigid body; `reference` and `center` (of mass, from there) in m, inertia about the reference point."""

    node: int
    item: int
    reference: np.ndarray
    center: np.ndarray
    mass: float
    inertia: np.ndarray


@dataclass(frozen=True)
class Spring:
    """A connector of exudyn with its diagonals; `outputs` are its deflections and their rates."""

    item: int
    stiffness: np.ndarray
    damping: np.ndarray
    outputs: tuple[tuple, tuple] = ((Output.DisplacementLocal, Output.Rotation), (Output.VelocityLocal, Output.AngularVelocityLocal))


class Driveline:
    """The assembled system. `speed` is that of gear 1 at the start, rad/s; torques are functions of time, N m.

    `coupling` ("sequential" or "parallel"): `pair` is a co-simulation instance, and the loads are held over the integrator's steps.
    """

    def __init__(self, gears: Gears, pair: GearPair, *, damped=True, mounts=True, speed=0.0, motor=None, load=None, coupling=None):
        self.gears, self.pair, self.damped = gears, pair, damped
        self.mbs = exu.SystemContainer().AddSystem()
        self.bodies: dict[tuple[int, int], Body] = {}
        self.springs: dict[object, Spring] = {}
        self.spins = (speed, -speed * gears.teeth[0] / gears.teeth[1])
        self.housing = housing(gears.center_distance, mounts)
        for k, shaft in enumerate(SHAFTS):
            self._shaft(k, shaft)
        in_bearings = self._housing()
        self.blanks = [self.bodies[k, shaft.gear] for k, shaft in enumerate(SHAFTS)]
        place = self.mbs, pair, [b.node for b in self.blanks], [b.reference for b in self.blanks]
        self.step_gears = attach_stepped(*place) if coupling else None
        if not coupling:
            attach(*place)
        self.torques = (motor or (lambda _: 0.0), load or (lambda _: 0.0))
        rotors = [self._rotor(k, shaft) for k, shaft in enumerate(SHAFTS)]
        self.mbs.Assemble()
        self.rotors = [self.mbs.GetNodeODE2Index(node) for node in rotors]
        places = [[self.mbs.GetNodeODE2Index(b.node) + np.arange(6) for b in bodies] for bodies in (self.blanks, in_bearings)]
        self.gear_coordinates, in_bearings = map(np.concatenate, places)
        self.walls = self.mbs.GetNodeODE2Index(self.modes) + np.arange(len(self.housing.frequencies))
        self.elastic = np.concatenate([in_bearings, self.walls])

    def _housing(self):
        """Its modes, and the bearings between its seats and the shafts, in one object of the bodies' nodes and the modes."""
        found, count = self.housing, len(self.housing.frequencies)
        rest = dict.fromkeys(("referenceCoordinates", "initialCoordinates", "initialCoordinates_t"), [0.0] * count)
        self.modes = self.mbs.AddNode(items.NodeGenericODE2(numberOfODE2Coordinates=count, **rest))
        bodies = [self.bodies[k, i] for k, shaft in enumerate(SHAFTS) for i in shaft.bearings]
        # Displacements of the shafts in the bearings, from the coordinates of bodies and modes.
        self.slip = np.hstack([np.kron(np.eye(len(bodies)), np.eye(3, 6)), -found.seats])
        self.bearings = np.array([BEARING_RADIAL, BEARING_RADIAL, BEARING_AXIAL, BEARING_RADIAL, BEARING_RADIAL, 0.0] * len(SHAFTS))
        none = np.zeros(6 * len(bodies))
        self.stiffness = np.diag([*none, *found.frequencies**2]) + self.slip.T @ np.diag(self.bearings) @ self.slip
        losses = np.diag([*none, *found.damping]) + BEARING_DAMPING * self.slip.T @ np.diag(self.bearings > 0.0) @ self.slip
        self.damping = self.damped * losses
        mass = exu.MatrixContainer()
        mass.SetWithSparseMatrix(csr_matrix(np.diag([*none, *np.ones(count)])))
        nodes, matrices = [*(body.node for body in bodies), self.modes], {"stiffnessMatrix": self.stiffness, "dampingMatrix": self.damping}
        self.mbs.AddObject(items.ObjectGenericODE2(nodeNumbers=nodes, massMatrix=mass, **matrices))
        return bodies

    def _body(self, name, reference, mass, inertia, center=(0.0, 0.0, 0.0), spin=0.0):
        """Adds a body; `inertia` about its centre of mass."""
        center = np.array(center, dtype=float)
        about = inertia + mass * (center @ center * np.eye(3) - np.outer(center, center))
        start = {"referenceCoordinates": [*reference, 0, 0, 0], "initialVelocities": [0, 0, 0, 0, 0, spin]}
        node = self.mbs.AddNode(items.NodeRigidBodyRxyz(**start))
        six = [about[i][j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))]
        item = self.mbs.AddObject(items.ObjectRigidBody(mass=mass, inertia=six, centerOfMass=list(center), nodeNumber=node))
        self.bodies[name] = Body(node, item, np.array(reference, dtype=float), center, mass, about)

    def _shaft(self, k: int, shaft: Shaft):
        """Half of each adjacent piece goes to a station, and the gear's blank to the gear's."""
        middle = sum(self.gears.faces[k]) / 2
        z = np.array([middle if z is GEAR else z for z in shaft.stations])
        radius, x = 0.5 * shaft.diameter, k * self.gears.center_distance
        lengths = np.diff(z)
        area, second = math.pi * radius**2, math.pi * radius**4 / 4
        for i in range(len(z)):
            length = 0.5 * sum(lengths[max(i - 1, 0) : i + 1])
            reference, center = z[i], 0.0
            mass, inertia = cylinder(radius, length)
            if i == shaft.gear:
                reference, end = self.gears.faces[k]
                blank, about = cylinder(self.gears.pitch_radii[k], end - reference, bore=radius)
                mass, inertia, center = mass + blank, inertia + about, z[i] - reference
            place = (x, 0.0, reference)
            self._body((k, i), place, mass, inertia, (0.0, 0.0, center), self.spins[k])
        for i, length in enumerate(lengths):
            bending, shear = YOUNG * second / length, SHEAR * SHEAR_FACTOR * area / length
            lateral = 1.0 / (1.0 / shear + length**2 / (12.0 * bending))
            stiffness = np.array([lateral, lateral, YOUNG * area / length, bending, bending, 2.0 * SHEAR * second / length])
            ends = [self._marker((k, j), (x, 0.0, 0.5 * (z[i] + z[i + 1]))) for j in (i, i + 1)]
            damping = MATERIAL_DAMPING * self.damped * stiffness
            # With the rotation vector between the axes of both ends: by Cardan angles, torque in a bent shaft would do work in every
            # turn, T theta^2 pi at a bend of theta.
            matrices = {"stiffness": np.diag(stiffness), "damping": np.diag(damping), "useIntrinsicFormulation": True}
            item = self.mbs.AddObject(items.RigidBodySpringDamper(markerNumbers=ends, **matrices))
            self.springs["piece", k, i] = Spring(item, stiffness, damping)

    def _marker(self, body, point):
        local = np.subtract(point, self.bodies[body].reference)
        return self.mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=self.bodies[body].item, localPosition=list(local)))

    def _rotor(self, k: int, shaft: Shaft) -> int:
        """Motor or load: an inertia behind a torsional coupling at the shaft's end; its coordinate is the angle."""
        start = {"referenceCoordinates": [0.0], "initialCoordinates": [0.0], "initialVelocities": [self.spins[k]]}
        node = self.mbs.AddNode(items.Node1D(**start))
        self.mbs.AddObject(items.Mass1D(mass=INERTIAS[k], nodeNumber=node))
        rotor = self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=0))
        end = self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=self.bodies[k, shaft.coupling].node, coordinate=5))
        stiffness, damping = COUPLING[k], COUPLING_DAMPING[k] * self.damped
        item = self.mbs.AddObject(items.CoordinateSpringDamper(markerNumbers=[rotor, end], stiffness=stiffness, damping=damping))
        self.springs["coupling", k] = Spring(item, np.array([stiffness]), np.array([damping]), ((Output.Displacement,), (Output.Velocity,)))
        self.mbs.AddLoad(items.LoadCoordinate(markerNumber=rotor, load=1.0, loadUserFunction=lambda _m, t, _load: self.torques[k](t)))
        return node

    def deflections(self, spring: Spring, rates: bool = False) -> np.ndarray:
        """In the spring's axes, at the state that the system has; or their rates."""
        return np.concatenate([np.atleast_1d(self.mbs.GetObjectOutput(spring.item, output)) for output in spring.outputs[rates]])

    def run(self, duration: float, step: float, observe: Callable, every: int = 1) -> tuple[np.ndarray, np.ndarray]:
        """Integrates with Runge-Kutta 4: time, and of every `every`-th step a row of what `observe` makes of time, coordinates,
        rates and accelerations."""
        data, done, rows = self.mbs.systemData, 0, []

        def record(_mbs, time):
            nonlocal done
            q, q_t = data.GetODE2Coordinates(), data.GetODE2Coordinates_t()
            if self.step_gears:
                self.step_gears(q[self.gear_coordinates], q_t[self.gear_coordinates], step)
            if done % every == 0:
                rows.append(observe(done * step, q, q_t, data.GetODE2Coordinates_tt()))
            done += 1
            return True

        self.mbs.SetPreStepUserFunction(record)
        settings = exu.SimulationSettings()
        settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = round(duration / step), duration
        settings.timeIntegration.verboseMode = 0
        # Of the mass matrix, in every stage: a tenth of the time of the dense one.
        settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
        settings.linearSolver.reuseAnalyzedPattern = True
        settings.solution.file.write = False
        settings.solution.sensors.active = False
        self.mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.RK44)
        return step * every * np.arange(len(rows)), np.array(rows)


def cylinder(radius: float, length: float, bore: float = 0.0):
    """Mass and inertia about the centre of a steel cylinder along z."""
    mass = DENSITY * math.pi * (radius**2 - bore**2) * length
    across = mass * (3.0 * (radius**2 + bore**2) + length**2) / 12.0
    return mass, np.diag([across, across, 0.5 * mass * (radius**2 + bore**2)])


def unit(gears: Gears, parameters: dict, fmu: Path | str | None = None, interface: str = "model-exchange") -> AbstractContextManager[GearPair]:
    """An instance of `fmu` or else of the tables at hand: the teeth touch at the start."""
    return opened(fmu or (shipped if gears == HELICAL else local)(gears.name), parameters, interface)


def rise(time: float, duration: float = 0.02) -> float:
    """From 0 to 1 with continuous slope."""
    share = min(max(time / duration, 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share)


@contextmanager
def sweep_line(
    variant: str, torque: float, rpm: float, duration: float, fmu: Path | str | None = None, damped: bool = True, coupling=None
):
    """The assembly of run-up and run-down, before them."""
    choices = {"damping": SPUR_DAMPING * damped} | VARIANTS[variant] | ({"coupling": coupling} if coupling else {})
    with unit(SPUR, choices, fmu, "co-simulation" if coupling else "model-exchange") as pair:
        line = Driveline(SPUR, pair, damped=damped, coupling=coupling)
        # Each side's own inertia; the shafts without the gears add less than 1 %.
        sides = [inertia + blank.inertia[2, 2] for inertia, blank in zip(INERTIAS, line.blanks)]
        ahead, behind = (inertia * rpm * RPM / duration for inertia in sides)
        way = lambda t: rise(t) - 2.0 * rise(t - duration)  # noqa: E731
        line.torques = (lambda t: torque * rise(t) + ahead * way(t), lambda t: torque * rise(t) - behind * way(t))
        yield line


def sweep(
    variant: str, torque: float = 150.0, rpm: float = 6000.0, duration: float = 0.8, fmu: Path | str | None = None, coupling=None,
    down: bool = False,
) -> tuple[History, ...]:  # fmt: skip
    """The spur pair from rest to `rpm`, evenly, and `down` again; the teeth carry `torque`: the load brakes with less, the motor
    drives with more. `coupling`: by co-simulation, with communication steps of `STEP`.

    Signals of each history: `wall_m_per_s2`, the acceleration of the top wall at the sensor; `wave 0` and on, m/s, whose squares
    add up to the mean square of the normal velocity over all walls; and `tangential_force_n`, `transmission_error_um` and
    `stiffness_n_per_m` of the mesh.
    """
    with sweep_line(variant, torque, rpm, duration, fmu, coupling=coupling) as line:
        walls, (spin, *_) = line.housing, line.gear_coordinates[5:]

        def observe(_, q, q_t, q_tt):
            mesh = [line.pair[f"mesh.{name}"] for name in ("tangentialForce", "transmissionError", "stiffness")]
            return np.concatenate([[q[spin], q_t[spin] / RPM, walls.sensor @ q_tt[line.walls]], mesh, walls.waves @ q_t[line.walls]])

        time, rows = line.run(duration * (1 + down), STEP, observe, 2)
    names = ["wall_m_per_s2", "tangential_force_n", "transmission_error_um", "stiffness_n_per_m"]
    rows[:, 4] *= 1e6
    signals = dict(zip([*names, *(f"wave {i}" for i in range(len(walls.waves)))], rows[:, 2:].T))
    run = History(time, rows[:, 0], rows[:, 1], signals)
    return tuple(run.cut(slice(half * len(time) // (1 + down), (half + 1) * len(time) // (1 + down))) for half in range(1 + down))
