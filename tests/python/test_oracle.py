"""The loads of packed FMUs against two helicoids of the tests' own (`oracle.py`), in arbitrary poses."""

import json
from pathlib import Path

import numpy as np
import pytest
from conftest import pair_files
from oracle import Flank, Mesh
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

POSES = 20
LOADS = ("gear1.force", "gear1.moment", "gear2.force", "gear2.moment")


def body(name, p, turn, v, w):
    values = {}
    quaternion = turn.as_quat(scalar_first=True)
    for quantity, vector in (("position", p), ("quaternion", quaternion), ("velocity", v), ("angularVelocity", w)):
        values |= {f"{name}.{quantity}[{i + 1}]": x for i, x in enumerate(vector)}
    return values


class Poses:
    """Poses of both gears (position, rotation) anywhere in the world."""

    def __init__(self, mesh, rng):
        self.mesh, self.rng = mesh, rng
        self.world = Rotation.random(rng=rng)
        self.origin = rng.uniform(-0.5, 0.5, 3)
        self.tilt, self.shift = rng.uniform(-2e-3, 2e-3, (2, 2)), rng.uniform(-5e-5, 5e-5, (2, 3))

    def at(self, turn, slip, off=1.0):
        """Rolled by `turn`, gear 1 turned on by `slip`; `off`: how much of tilt and shift."""
        mesh, out = self.mesh, []
        spins = turn + slip, -mesh.e * turn * mesh.z[0] / mesh.z[1]
        for i, spin in enumerate(spins):
            turned = self.world * Rotation.from_rotvec([*(off * self.tilt[i]), 0.0]) * Rotation.from_rotvec([0.0, 0.0, spin])
            p = np.array([i * mesh.c, 0.0, i * mesh.face_offset]) + off * self.shift[i]
            out.append((self.world.apply(p) + self.origin, turned))
        return out


def matrices(poses):
    return [(p, turn.as_matrix()) for p, turn in poses]


def inputs(poses, velocities=np.zeros((2, 2, 3))):
    gear1, gear2 = (body(f"gear{i + 1}", *poses[i], *velocities[i]) for i in (0, 1))
    return gear1 | gear2


def loaded(mesh, pair, case, rng, damping=0.0, room=0.0):
    """An instance under 10 to 40 um on one flank, its oracle, poses, touching pose and which flank it is.

    `room`: backlash (m) beside the pair's own; without any, poses with both flanks pressed are among them.
    """
    instance = mesh(pair)
    unit = instance.unit
    geometry = json.loads((Path(unit.folder) / "resources" / "unit.json").read_text())["geometry"]
    stiffness = float(unit.variables["constantStiffness"].start)
    backlash = float(unit.variables["backlash"].start) + room + 1e-4 * (case % 3)
    oracle = Mesh(geometry, stiffness, backlash)
    poses, radius = Poses(oracle, rng), oracle.flanks[1][0].rb
    absolute, s = case % 2, (1, -1)[case // 2 % 2]
    # Absolute phases must start with teeth in gaps: the drive flank 1 um from its partner.
    start = poses.at(0.0, 0.0, off=0.0)
    if absolute:
        gap = oracle.elongation(1, matrices(start)).real + 1e-6
        start = poses.at(0.0, -gap / radius, off=0.0)
    touching = None if absolute else matrices(start)
    parameters = {"stiffnessModel": 1, "damping": damping, "orientationInput": 2, "formulation": 2}
    parameters |= {"loadedFlank": 3, "phaseReference": 1 + absolute, "backlash": backlash}
    instance.initialize(parameters | inputs(start))
    turn = rng.uniform(-3.0, 3.0)
    _, elongation = oracle.wrench(matrices(poses.at(turn, 0.0)), touching)
    slip = s * (rng.uniform(1e-5, 4e-5) - elongation[s]) / radius
    return instance, oracle, poses.at(turn, slip), touching, s


def assert_same_wrench(instance, expected, bar):
    found = np.concatenate([instance.vector(name) for name in LOADS]).reshape(4, 3)
    expected = expected.reshape(4, 3)
    # Of each force and moment its own size.
    assert np.all(np.abs(found - expected).max(axis=1) <= bar * np.linalg.norm(expected, axis=1))


@pytest.mark.parametrize("damping, room", [(0.0, 0.0), (2e3, 1e-4)], ids=["elastic", "damped"])
@pytest.mark.parametrize("pair", pair_files())
def test_the_wrench_is_the_gradient_of_the_distance_of_two_helicoids_and_the_damper_acts_along_it(mesh, pair, damping, room):
    rng = np.random.default_rng(20130411)
    for case in range(POSES):
        instance, oracle, poses, touching, s = loaded(mesh, pair, case, rng, damping, room)
        # The damper is whole from dampingOnset (0.1) of the nominal force on, and these do not lift the teeth.
        velocities = rng.uniform(-1.0, 1.0, (2, 2, 3)) * np.array([5e-3, 0.1])[:, None]
        instance.set(inputs(poses, velocities))
        expected, _ = oracle.wrench(matrices(poses), touching)
        assert np.linalg.norm(expected[:3]) > 1000.0 and instance.get("mesh.flank") == s
        gradient, cos_phi = oracle.gradient(s, matrices(poses)), oracle.base_sum / oracle.c
        expected -= damping / cos_phi**2 * (gradient @ velocities.ravel()) * gradient
        assert_same_wrench(instance, expected, 1e-9)
        point, distance = oracle.pitch_point(matrices(poses))
        assert np.abs(np.array(instance.vector("contact.point")) - point).max() <= 1e-12
        assert instance.get("mesh.centerDistance") == pytest.approx(distance, abs=1e-15)


def foot(flank, x):
    """Signed distance of `x` from its closest point on the flank's surface."""
    start = np.sqrt((x[0] ** 2 + x[1] ** 2) / flank.rb**2 - 1), x[2]
    closest = least_squares(lambda at: flank.surface(*at) - x, start, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    at = flank.surface(*closest.x)
    outside = flank.sigma * np.sign((x - at) @ np.array([-at[1], at[0], 0.0]))
    return outside * np.linalg.norm(x - at)


@pytest.mark.parametrize("helix", [0.0, 0.4])
@pytest.mark.parametrize("kind", ["external", "ring"])
def test_the_oracles_distance_is_that_of_the_closest_point_on_the_surface(kind, helix):
    rng = np.random.default_rng(1842)
    gear = {"kind": kind, "teeth": 30, "helix_angle_rad": helix, "normal_pressure_angle_rad": np.radians(20.0)}
    gear |= {"normal_module_m": 4e-3, "profile_shift": 0.3}
    module = gear["normal_module_m"] / np.cos(helix)
    for hand in (1, -1):
        flanks = {sigma: Flank(gear, sigma, hand, 2e-5) for sigma in (1, -1)}
        # On the reference circle a tooth (ring: a space) is as thick as the rack that cuts it says.
        reference = np.sqrt((0.5 * 30 * module / flanks[1].rb) ** 2 - 1)
        ends = [np.arctan2(*flanks[s].surface(reference, 0.0)[1::-1]) for s in (1, -1)]
        rack = 0.5 * np.pi * module + 2 * 0.3 * module * np.tan(gear["normal_pressure_angle_rad"])
        thinned = (1 if kind == "external" else -1) * 2e-5 / flanks[1].rb
        thickness = abs(ends[0] - ends[1]) + thinned
        assert thickness == pytest.approx(rack / (0.5 * 30 * module), abs=1e-15)
        for sigma, flank in flanks.items():
            for _ in range(10):
                on = flank.surface(rng.uniform(0.25, 0.6), rng.uniform(0.0, 0.03))
                x = on + rng.uniform(-2e-4, 2e-4, 3)
                assert flank.distance(x).real == pytest.approx(foot(flank, x), abs=1e-15)
