"""A helical pair on flexible shafts and bearings in a housing on mounts, in exudyn.

z runs along the shafts, gear 1's z = 0 face lies at the origin and the output shaft at x = C. Every body has a node
with Tait-Bryan angles x-y-z (spin last), which Runge-Kutta 4 integrates without constraints. A piece of
shaft is a spring between two bodies, taken at its middle, where the stiffness of a Timoshenko beam is diagonal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import exudyn as exu
import numpy as np
from exudyn.utilities import (
    CoordinateSpringDamper,
    LoadCoordinate,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    Mass1D,
    Node1D,
    NodeRigidBodyRxyz,
    ObjectGround,
    ObjectRigidBody,
    RigidBodySpringDamper,
)
from gearmesh import GearPair
from gearmesh.exudyn import attach, attach_stepped
from gearmesh.poses import cardan_axes
from scipy.spatial.transform import Rotation

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
HOUSING_MASS, HOUSING_INERTIA = 25.0, (0.30, 0.35, 0.45)  # kg, kg m^2
HOUSING_CENTER = (0.06, -0.03, 0.03)
MOUNT, MOUNT_DAMPING = 3e6, 600.0  # N/m and N s/m, each direction
MOUNTS = tuple((x, -0.12, z) for x in (-0.12, 0.24) for z in (-0.07, 0.13))
SENSOR = (0.20, 0.06, 0.10)  # accelerometer on the housing wall


@dataclass(frozen=True)
class Body:
    """A rigid body; `reference` and `center` (of mass, body axes) in m, inertia about the reference point."""

    node: int
    item: int
    first: int  # of its six coordinates
    reference: np.ndarray
    center: np.ndarray
    mass: float
    inertia: np.ndarray


@dataclass(frozen=True)
class Spring:
    """Spring and damper between points of two bodies (None: ground), diagonal in the axes of the first or, `midway`, between.

    Rotations are then the rotation vector instead of Cardan angles. Pieces of shaft need that: torque in bent shafts
    would do work in every turn by Cardan angles, T theta^2 pi at a bend of theta.
    """

    bodies: tuple[object, object]
    point: np.ndarray  # where both ends lie at the start, world
    stiffness: np.ndarray
    damping: np.ndarray
    midway: bool = False


class Driveline:
    """The assembled system. `speed` is that of gear 1 at the start, rad/s; torques are functions of time, N m.

    `coupling` ("sequential" or "parallel"): `pair` is a co-simulation instance, and the loads are held over the integrator's steps.
    """

    def __init__(
        self, gears: Gears, pair: GearPair, *, damped=True, free_housing=False, speed=0.0, motor=None, load=None, coupling=None
    ):
        self.gears, self.pair, self.damped = gears, pair, damped
        self.mbs = exu.SystemContainer().AddSystem()
        self.bodies: dict[object, Body] = {}
        self.springs: dict[object, Spring] = {}
        self.spins = (speed, -speed * gears.teeth[0] / gears.teeth[1])
        self._body("housing", HOUSING_CENTER, HOUSING_MASS, np.diag(HOUSING_INERTIA))
        for k, shaft in enumerate(SHAFTS):
            self._shaft(k, shaft)
        if not free_housing:
            for i, point in enumerate(MOUNTS):
                self._spring(("mount", i), None, "housing", point, [MOUNT] * 3 + [0.0] * 3, MOUNT_DAMPING)
        blanks = [self.bodies[k, shaft.gear] for k, shaft in enumerate(SHAFTS)]
        place = self.mbs, pair, [b.node for b in blanks], [b.reference for b in blanks]
        self.step_gears = attach_stepped(*place) if coupling else None
        if not coupling:
            attach(*place)
        self.torques = (motor or (lambda _: 0.0), load or (lambda _: 0.0))
        self.rotors = [self._rotor(k, shaft) for k, shaft in enumerate(SHAFTS)]
        self.mbs.Assemble()

    def _body(self, name, reference, mass, inertia, center=(0.0, 0.0, 0.0), spin=0.0):
        """Adds a body; `inertia` about its centre of mass."""
        center = np.array(center, dtype=float)
        about = inertia + mass * (center @ center * np.eye(3) - np.outer(center, center))
        node = self.mbs.AddNode(
            NodeRigidBodyRxyz(referenceCoordinates=[*reference, 0, 0, 0], initialVelocities=[0, 0, 0, 0, 0, spin])
        )
        six = [about[i][j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))]
        item = self.mbs.AddObject(ObjectRigidBody(mass=mass, inertia=six, centerOfMass=list(center), nodeNumber=node))
        first = 6 * len(self.bodies)
        self.bodies[name] = Body(node, item, first, np.array(reference, dtype=float), center, mass, about)

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
            stiffness = [lateral, lateral, YOUNG * area / length, bending, bending, 2.0 * SHEAR * second / length]
            middle = (x, 0.0, 0.5 * (z[i] + z[i + 1]))
            self._spring(("piece", k, i), (k, i), (k, i + 1), middle, stiffness, MATERIAL_DAMPING * np.array(stiffness), midway=True)
        for i, axial in zip(shaft.bearings, (BEARING_AXIAL, 0.0)):
            stiffness = np.array([BEARING_RADIAL, BEARING_RADIAL, axial, 0.0, 0.0, 0.0])
            place = (x, 0.0, z[i])
            damping = BEARING_DAMPING * (stiffness > 0.0)
            self._spring(("bearing", k, i), "housing", (k, i), place, stiffness, damping)

    def _spring(self, name, first, second, point, stiffness, damping, midway=False):
        point, stiffness = np.array(point, dtype=float), np.array(stiffness, dtype=float)
        damping = np.broadcast_to(damping, 6) * (stiffness > 0.0) * self.damped
        self.springs[name] = Spring((first, second), point, stiffness, damping, midway)
        self.mbs.AddObject(
            RigidBodySpringDamper(
                markerNumbers=[self._marker(first, point), self._marker(second, point)],
                stiffness=np.diag(stiffness),
                damping=np.diag(damping),
                useIntrinsicFormulation=midway,
            )
        )

    def _marker(self, body, point):
        if body is None:
            item, local = self.mbs.AddObject(ObjectGround()), point
        else:
            item, local = self.bodies[body].item, point - self.bodies[body].reference
        return self.mbs.AddMarker(MarkerBodyRigid(bodyNumber=item, localPosition=list(local)))

    def _rotor(self, k: int, shaft: Shaft) -> int:
        """Motor or load: an inertia behind a torsional coupling at the shaft's end; its coordinate is the angle."""
        node = self.mbs.AddNode(
            Node1D(referenceCoordinates=[0.0], initialCoordinates=[0.0], initialVelocities=[self.spins[k]])
        )
        self.mbs.AddObject(Mass1D(mass=INERTIAS[k], nodeNumber=node))
        rotor = self.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=0))
        end = self.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=self.bodies[k, shaft.coupling].node, coordinate=5))
        self.mbs.AddObject(
            CoordinateSpringDamper(
                markerNumbers=[rotor, end], stiffness=COUPLING[k], damping=COUPLING_DAMPING[k] * self.damped
            )
        )
        self.mbs.AddLoad(
            LoadCoordinate(markerNumber=rotor, load=1.0, loadUserFunction=lambda _m, t, _load: self.torques[k](t))
        )
        return 6 * len(self.bodies) + k

    def run(self, duration: float, step: float, every: int, diagnostics=()) -> Motion:
        """Integrates with Runge-Kutta 4 and keeps every `every`-th step."""
        steps = round(duration / step)
        count = steps // every
        data = self.mbs.systemData
        size = len(data.GetODE2Coordinates())
        rows = np.zeros((3, count, size))
        more = np.zeros((count, len(diagnostics)))
        done = [0]

        blanks = np.r_[tuple(slice(b.first, b.first + 6) for b in (self.bodies[k, s.gear] for k, s in enumerate(SHAFTS)))]

        def record(_mbs, _time):
            if self.step_gears:
                self.step_gears(data.GetODE2Coordinates()[blanks], data.GetODE2Coordinates_t()[blanks], step)
            n, rest = divmod(done[0], every)
            done[0] += 1
            if rest == 0 and n < count:
                rows[0, n] = data.GetODE2Coordinates()
                rows[1, n] = data.GetODE2Coordinates_t()
                rows[2, n] = data.GetODE2Coordinates_tt()
                if diagnostics:
                    more[n] = [self.pair[name] for name in diagnostics]
            return True

        self.mbs.SetPreStepUserFunction(record)
        settings = exu.SimulationSettings()
        settings.timeIntegration.numberOfSteps = steps
        settings.timeIntegration.endTime = duration
        settings.timeIntegration.verboseMode = 0
        settings.solution.file.write = False
        settings.solution.sensors.active = False
        self.mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.RK44)
        return Motion(step * every * np.arange(count), *rows, dict(zip(diagnostics, more.T)))

    def gear_coordinates(self, q: np.ndarray) -> np.ndarray:
        """Position and Cardan angles of gear 1, then of gear 2, from the system's coordinates."""
        blanks = [self.bodies[k, shaft.gear] for k, shaft in enumerate(SHAFTS)]
        return np.concatenate([q[b.first : b.first + 6] + np.r_[b.reference, 0, 0, 0] for b in blanks])

    def deflections(self, spring: Spring, q: np.ndarray) -> np.ndarray:
        """Displacement and rotation of a spring's second end against the first, in the spring's axes.

        `q` is one row of coordinates or one for each instant.
        """
        (p, _), (r, _) = (self._end(name, spring.point, q) for name in spring.bodies)
        back, turn = self._axes(spring, q)
        # Of Cardan angles the third is the spin where one side turns, and has no stiffness there.
        turned = Rotation.from_matrix(turn)
        return np.concatenate([apply(back, r - p), turned.as_rotvec() if spring.midway else turned.as_euler("XYZ")], axis=-1)

    def slip(self, spring: Spring, q: np.ndarray, q_t: np.ndarray) -> np.ndarray:
        """Velocity and angular velocity of a spring's second end against the first, in the spring's axes."""
        first, second = (self._end_rates(name, spring.point, q, q_t) for name in spring.bodies)
        back = self._axes(spring, q)[0]
        return np.concatenate([apply(back, b - a) for a, b in zip(first, second)], axis=-1)

    def _axes(self, spring: Spring, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rotation from the world into the spring's axes, and that of the second body against the first."""
        a, b = (self._end(name, spring.point, q)[1] for name in spring.bodies)
        turn = np.swapaxes(a, -1, -2) @ b
        axes = a @ Rotation.from_rotvec(0.5 * Rotation.from_matrix(turn).as_rotvec()).as_matrix() if spring.midway else a
        return np.swapaxes(axes, -1, -2), turn

    def couplings(self, x: np.ndarray) -> np.ndarray:
        """Of motor and load against their shafts' ends: twist from coordinates, rad, or its rate from their rates."""
        ends = [self.bodies[k, shaft.coupling].first + 5 for k, shaft in enumerate(SHAFTS)]
        return x[..., self.rotors] - x[..., ends]

    def _end(self, name, point, q):
        if name is None:
            return point, np.eye(3)
        body = self.bodies[name]
        axes = rotation(q[..., body.first + 3 : body.first + 6])
        return body.reference + q[..., body.first : body.first + 3] + axes @ (point - body.reference), axes

    def _end_rates(self, name, point, q, q_t):
        if name is None:
            return np.zeros(3), np.zeros(3)
        body = self.bodies[name]
        angles = slice(body.first + 3, body.first + 6)
        omega = apply(cardan_axes(q[..., angles]), q_t[..., angles])
        arm = rotation(q[..., angles]) @ (point - body.reference)
        return q_t[..., body.first : body.first + 3] + np.cross(omega, arm), omega


@dataclass
class Motion:
    """Coordinates, rates and accelerations over time; further outputs of the unit by name."""

    time: np.ndarray
    q: np.ndarray
    q_t: np.ndarray
    q_tt: np.ndarray
    mesh: dict[str, np.ndarray]

    def after(self, start: float) -> Motion:
        keep = self.time >= start
        more = {name: column[keep] for name, column in self.mesh.items()}
        return Motion(self.time[keep], self.q[keep], self.q_t[keep], self.q_tt[keep], more)


def cylinder(radius: float, length: float, bore: float = 0.0):
    """Mass and inertia about the centre of a steel cylinder along z."""
    mass = DENSITY * math.pi * (radius**2 - bore**2) * length
    across = mass * (3.0 * (radius**2 + bore**2) + length**2) / 12.0
    return mass, np.diag([across, across, 0.5 * mass * (radius**2 + bore**2)])


def apply(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Matrix times vector, for one or for each of a row."""
    return (matrices @ vectors[..., None])[..., 0]


def rotation(angles: np.ndarray) -> np.ndarray:
    """Rx Ry Rz, for one row of angles or for each."""
    return Rotation.from_euler("XYZ", angles).as_matrix()
