"""A planetary stage: sun, planets that tilt on the pins of a turning carrier, ring held; one unit for each mesh.

Coordinates q: displacement and Cardan angles x-y-z of the sun, then of each planet, all at mid-face, then the angle of the carrier;
SI, fixed axes. All units run with `phaseReference = absolute`: the phases between the meshes follow from teeth and places alone.
The gyroscopic moments of the tilt, a millionth here, are left out.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from gearmesh import GearPair, integrate
from gearmesh.energy import mesh_loss
from gearmesh.poses import POSES, generalised, place
from scipy.linalg import block_diag

from examples.shared.files import local

TEETH = (21, 39, 99)  # sun, planet, ring
CENTER_DISTANCE = 0.3079208  # m
MIDDLE, FACES = 113.75e-3, (3.75e-3, 0.0, -1.25e-3)  # m over the planets' z = 0 face: the middle of all faces, z = 0 faces
IN, OUT = (
    [f"gear{gear}.{kind}[{axis}]" for gear in (1, 2) for kind in kinds for axis in (1, 2, 3)]
    for kinds in (("position", "angles"), ("force", "moment"))
)

# Body x axes pass through teeth at each gear's own z = 0 face; these turns put the teeth of sun and ring on +x in the plane of
# the planets' z = 0 face: z tan(helix angle) / reference radius.
PITCH = np.array(TEETH) * 10e-3 / np.cos(np.radians(7.5)) / 2.0  # reference radii, m
SUN_TURN, _, RING_TURN = np.abs(FACES) * np.tan(np.radians(7.5)) / PITCH
RING = np.array([0.0, 0.0, 0.0, 0.0, 0.0, RING_TURN])

IN_PHASE, SEQUENTIAL = (0, 40, 80), (0, 42, 84)  # places of the planets, in steps of 360 / (21 + 99) deg


def to_face(face: float) -> np.ndarray:
    """Coordinates of a point on a body's axis in its z = 0 face from those at mid-face."""
    out = np.eye(6)
    out[0, 4], out[1, 3] = face - MIDDLE, MIDDLE - face
    return out


TO_FACE = [to_face(face) for face in FACES]


@dataclass
class Stage:
    """The stage; `errors` are tangential errors of the pins, m, positive in the carrier's positive sense."""

    places: tuple[int, ...] = IN_PHASE
    errors: tuple[float, ...] = (0.0, 0.0, 0.0)
    sun_support: float = 1e11  # N/m; 0: floating
    pin: float = 3e9  # N/m, planet bearings and pins
    span: float = 80e-3  # m, from mid-face to each of a planet's two bearings, which resist its tilt; as good as infinite: planar
    axial: float = 1e9  # N/m, sun and planets
    damping: float | None = None  # N s/m at each mesh; None: as packed
    masses: tuple[float, float, float] = (60.0, 150.0, 2.2)  # sun and planet, kg; carrier's inertia with rotor, 1e3 kg m^2
    inertias: tuple[tuple[float, float], ...] = ((0.42, 0.35), (2.7, 4.1))  # sun and planet, across and about the axis, kg m^2
    angles: np.ndarray = field(init=False)

    def __post_init__(self):
        choices = {"phaseReference": "absolute"} | ({} if self.damping is None else {"damping": self.damping})
        kinds = [local(name) for name in ("grc-sun-planet", "grc-planet-ring")]
        self.meshes = [[GearPair(fmu, choices, "model-exchange") for fmu in kinds] for _ in self.places]
        self.angles = 2.0 * np.pi * np.array(self.places) / (TEETH[0] + TEETH[2])
        start = self.rolled(0.0)
        for n in range(len(self.places)):
            for pair in self._placed(n, start, np.zeros(len(start))):
                pair.initialize()

    def close(self) -> None:
        for pair in (pair for pairs in self.meshes for pair in pairs):
            pair.close()

    def __enter__(self) -> Stage:
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def pins(self, carrier: float) -> np.ndarray:
        """Where the pins are, m, one row each."""
        angle = self.angles + carrier
        radial = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return CENTER_DISTANCE * radial + np.array(self.errors)[:, None] * radial[:, ::-1] * [-1.0, 1.0]

    def rolled(self, carrier: float) -> np.ndarray:
        """Coordinates after rolling without load: at angle zero a tooth of sun and planet lies on +x, and a space of the ring."""
        sun, planet, ring = TEETH
        out = np.zeros((1 + len(self.places), 6))
        out[1:, :2], out[1:, 5] = self.pins(carrier), (self.angles + carrier) * (1.0 - ring / planet)
        out[0, 5] = carrier * (1.0 + ring / sun)
        return np.append(out, carrier)

    def stiffness(self) -> np.ndarray:
        """Of the supports of sun and planets, one row each: the planets' are on their pins."""
        lateral, spans = [self.sun_support, self.pin, self.pin, self.pin], [1.0, self.span, self.span, self.span]
        return np.array([[k, k, self.axial, k * span**2, k * span**2, 0.0] for k, span in zip(lateral, spans)])

    def shift(self, q: np.ndarray) -> np.ndarray:
        """Of sun and planets in their supports, one row each."""
        shift = q[:-1].reshape(-1, 6).copy()
        shift[1:, :2] -= self.pins(q[-1])
        return shift

    def _placed(self, n: int, q: np.ndarray, q_t: np.ndarray):
        """Yields planet n's units for sun and ring with their inputs written."""
        sun, planet, at = TO_FACE[0], TO_FACE[1], slice(6 + 6 * n, 12 + 6 * n)
        turned = sun @ q[:6] + [0.0, 0.0, 0.0, 0.0, 0.0, SUN_TURN]
        bodies = [(turned, planet @ q[at], FACES[:2]), (planet @ q[at], RING, FACES[1:])]
        rates = [(sun @ q_t[:6], planet @ q_t[at]), (planet @ q_t[at], np.zeros(6))]
        for pair, (first, second, faces), motion in zip(self.meshes[n], bodies, rates):
            poses, speeds = np.concatenate([first, second]).tolist(), np.concatenate(motion).tolist()
            place(pair, poses, speeds, [(0.0, 0.0, face) for face in faces])
            yield pair

    def forces(self, q: np.ndarray, q_t: np.ndarray, jacobian: bool = False):
        """Forces of meshes, pins and sun support on the coordinates; with `jacobian` their derivatives by q, too."""
        force, slope = np.zeros(len(q)), np.zeros((len(q), len(q)))
        for n in range(len(self.places)):
            planet = np.arange(6 + 6 * n, 12 + 6 * n)
            # The ring's loads go to the ground.
            for pair, rows, faces in zip(self._placed(n, q, q_t), (np.r_[:6, planet], planet), (TO_FACE[:2], TO_FACE[1:2])):
                pair.evaluate(0.0)
                poses = [*pair.u[POSES[0]], *pair.u[POSES[1]]]
                back = block_diag(*faces)
                force[rows] += generalised(pair.y[:12], poses)[: len(rows)] @ back
                if jacobian:
                    part = np.array(pair.derivatives(OUT, IN))[: len(rows), : len(rows)]
                    slope[np.ix_(rows, rows)] += back.T @ part @ back
        stiffness = self.stiffness()
        pull, pins = -stiffness * self.shift(q), self.pins(q[-1])
        force[:-1] += pull.ravel()
        force[-1] += np.sum(pins[:, 1] * pull[1:, 0] - pins[:, 0] * pull[1:, 1])
        slope[range(len(q) - 1), range(len(q) - 1)] -= stiffness.ravel()
        return (force, slope) if jacobian else force

    def equilibrium(self, carrier: float, torque: float, guess: np.ndarray | None = None) -> np.ndarray:
        """Coordinates at rest with the carrier held and `torque`, N m, on the sun, by Newton's method."""
        if guess is None and self.span < 0.2:
            # Newton's method starts with planets that hardly tilt.
            span, self.span = self.span, 0.2
            guess = self.equilibrium(carrier, torque) - self.rolled(carrier)
            self.span = span
        sense = -np.sign(torque)
        q = self.rolled(carrier)
        if guess is not None:
            q = q + guess
        else:
            # Through half of the backlash of both meshes and a little further, so that teeth touch.
            q[11:-1:6] += -sense * 5e-4
            q[5] -= sense * 3.2e-3
        rest, free = np.zeros(len(q)), slice(0, len(q) - 1)
        for _ in range(60):
            force, slope = self.forces(q, rest, jacobian=True)
            force[5] += torque
            residual = force[free]
            # Forces over a tenth of a metre, so that they compare with moments.
            if np.linalg.norm(residual.reshape(-1, 6) * [0.1, 0.1, 0.1, 1.0, 1.0, 1.0]) < 1e-9 * abs(torque):
                return q
            step = np.linalg.solve(slope[free, free], -residual)
            q[free] += step * min(1.0, 2e-4 / np.abs(step).max())
        raise RuntimeError(f"no equilibrium at a carrier angle of {carrier} rad: residual {np.abs(residual).max()}")

    def shares(self) -> np.ndarray:
        """Shares of the planets in the tangential force at the sun, at the last evaluation."""
        forces = np.array([pairs[0]["mesh.tangentialForce"] for pairs in self.meshes])
        return forces / forces.sum()

    def mass(self) -> np.ndarray:
        """Diagonal of the mass matrix."""
        bodies = [[mass] * 3 + [across, across, about] for mass, (across, about) in zip(self.masses, self.inertias)]
        return np.array(bodies[0] + bodies[1] * len(self.places) + [1e3 * self.masses[2]])

    def energy(self, q: np.ndarray, q_t: np.ndarray) -> tuple[float, float]:
        """Kinetic energy, and elastic energy of pins and sun support, J."""
        return 0.5 * float(self.mass() @ q_t**2), 0.5 * float(np.sum(self.stiffness() * self.shift(q) ** 2))

    def run(self, q, q_t, torques: tuple[float, float], duration: float, step: float, every: int):
        """Runge-Kutta 4 under constant torques on sun and carrier, every `every`-th step: time, coordinates, rates, and integrals.

        Those are the work of the torques, what the meshes lose, and the impulse that sun and planets get from ring, pins and
        sun support.
        """
        inverse, load, half = 1.0 / self.mass(), np.zeros(len(q)), len(q)
        load[5], load[-1] = torques

        def rate(_, z):
            q, q_t = z[:half], z[half:]
            return np.concatenate([q_t, (self.forces(q, q_t) + load) * inverse])

        def accounts(_, z):
            q, q_t = z[:half], z[half:]
            # The ring's own loads, not those on the planets, so that the sum is a check.
            push = -sum(np.array(pairs[1].y[6:9]) for pairs in self.meshes) - (self.stiffness() * self.shift(q))[:, :3].sum(axis=0)
            return [load @ q_t, sum(mesh_loss(pair) for pairs in self.meshes for pair in pairs), *push]

        run = integrate(rate, np.concatenate([q, q_t]), step, round(duration / step), every=every, accounts=accounts)
        for time, z, integrals in run:
            yield time, z[:half], z[half:], integrals

    def momentum(self, q_t: np.ndarray) -> np.ndarray:
        """Linear momentum of sun and planets, N s."""
        return (self.mass()[:-1] * q_t[:-1]).reshape(-1, 6)[:, :3].sum(axis=0)
