"""The mechanics of the element through the unit, against formulas of their own."""

import json
from pathlib import Path

import numpy as np
import pytest
from conftest import EXTERNAL_AND_INTERNAL, FORMULATIONS
from differences import check_derivatives, values_of, variables
from host import OK
from scipy.spatial.transform import Rotation

RNG_SEED = 20130411
INPUTS_PER_BODY = 16
PAIRS = ["external", "external-left", "ring2", "ring2-left", "ring1", "ring1-left"]
# One flank: the pairs have no backlash, so that the other one would carry, too, as soon as gears approach.
CONSTANT = {"stiffnessModel": 1, "damping": 0.0, "loadedFlank": 1}


class Geometry:
    """Operating values from the macrogeometry, by the textbook."""

    def __init__(self, unit):
        data = json.loads((Path(unit.folder) / "resources" / "unit.json").read_text())["geometry"]
        g1, g2 = data["gears"]
        self.z = [g1["teeth"], g2["teeth"]]
        self.e = -1 if "ring" in (g1["kind"], g2["kind"]) else 1
        self.sc = np.sign(self.z[0] + self.e * self.z[1])
        self.hand = g1["hand"]
        beta, alpha_n = g1["helix_angle_rad"], g1["normal_pressure_angle_rad"]
        alpha_t = np.arctan(np.tan(alpha_n) / np.cos(beta))
        r = [0.5 * z * g1["normal_module_m"] / np.cos(beta) for z in self.z]
        self.c = data["center_distance"]
        self.phi = np.arccos(abs(r[0] + self.e * r[1]) * np.cos(alpha_t) / self.c)
        self.rw = [z * self.c / abs(self.z[0] + self.e * self.z[1]) for z in self.z]
        self.tan_beta_w = np.tan(beta) * self.rw[0] / r[0]
        self.beta_b = np.arctan(np.tan(beta) * np.cos(alpha_t))

    def rolled(self, turn, slip):
        """Angles of both gears after rolling by `turn` of gear 1, and `slip` of gear 1 on top."""
        return turn + slip, -self.e * turn * self.z[0] / self.z[1]


def pressed(mesh, pair, flank, sense, formulation, turn=0.0):
    """An instance whose loaded flank is pressed by 20 um while gear 1 turns in `sense`."""
    instance = mesh(pair)
    geometry = Geometry(instance.unit)
    s = 1 if flank == 1 else -1
    speed = 100.0 * sense
    instance.initialize({**CONSTANT, "loadedFlank": flank, "formulation": formulation})
    spins = geometry.rolled(sense * turn, s * 2e-5 / geometry.rw[0])
    rates = geometry.rolled(speed, 0.0)
    for gear, spin, rate in zip(("gear1", "gear2"), spins, rates):
        instance.set({f"{gear}.angles[3]": spin, f"{gear}.angularVelocity[3]": rate})
    assert instance.step(0.0, 1e-6) == OK, instance.log()
    return instance, geometry, s


@FORMULATIONS
@pytest.mark.parametrize("sense", [1, -1], ids=["forward", "backward"])
@pytest.mark.parametrize("flank", [1, 2], ids=["drive", "coast"])
@pytest.mark.parametrize("pair", PAIRS)
def test_moments_go_by_teeth_and_the_force_along_the_flank_normal(
    mesh, pair, flank, sense, formulation
):
    instance, g, s = pressed(mesh, pair, flank, sense, formulation, turn=0.37)
    tangential = instance.get("mesh.tangentialForce")
    k = instance.get("mesh.stiffness")
    assert tangential == pytest.approx(k * 2e-5, rel=1e-9)
    assert s * instance.get("mesh.transmissionError") == pytest.approx(2e-5, rel=1e-9)
    force = tangential * np.array([g.e * np.tan(g.phi), s * g.sc, -s * g.hand * g.tan_beta_w])
    f1, f2 = (np.array(instance.vector(f"gear{i}.force")) for i in (1, 2))
    # Rounding of the sixth decimal of a picometre times the stiffness, over the force.
    assert f2 == pytest.approx(force, rel=1e-10, abs=1e-10 * np.linalg.norm(force))
    assert np.array_equal(f1, -f2)
    m1, m2 = (instance.vector(f"gear{i}.moment") for i in (1, 2))
    assert m1[2] == pytest.approx(-s * tangential * g.rw[0], rel=1e-10)
    assert m2[2] / m1[2] == pytest.approx(g.e * g.z[1] / g.z[0], rel=1e-10)
    # Both moments are those of the one force at the contact point.
    point = np.array(instance.vector("contact.point"))
    origin2 = np.array([g.c, 0.0, instance.get("gear2.position[3]")])
    assert m1 == pytest.approx(np.cross(point, f1), rel=1e-9, abs=1e-9 * abs(m1[2]))
    assert m2 == pytest.approx(np.cross(point - origin2, f2), rel=1e-9, abs=1e-9 * abs(m2[2]))
    normal = tangential / np.cos(g.phi) / np.cos(g.beta_b)
    assert instance.get("mesh.normalForce") == pytest.approx(normal, rel=1e-10)
    assert np.linalg.norm(force) == pytest.approx(normal, rel=1e-10)
    assert instance.get("mesh.flank") == s


def rotation(rng):
    """A random unit quaternion and its matrix."""
    q = rng.normal(size=4)
    q /= np.linalg.norm(q)
    return q, Rotation.from_quat(q, scalar_first=True).as_matrix()


def product(p, q):
    a, u, b, v = p[0], p[1:], q[0], q[1:]
    return np.r_[a * b - u @ v, a * v + b * u + np.cross(u, v)]


def body(name, p, q, v, w):
    values = {}
    for quantity, vector in (("position", p), ("quaternion", q), ("velocity", v), ("angularVelocity", w)):
        values |= {f"{name}.{quantity}[{i + 1}]": x for i, x in enumerate(vector)}
    return values


@pytest.mark.parametrize("orientation", [1, 2], ids=["angles", "quaternion"])
@FORMULATIONS
@EXTERNAL_AND_INTERNAL
def test_directional_derivatives_are_those_of_differences(mesh, pair, formulation, orientation):
    rng = np.random.default_rng(RNG_SEED)
    instance = mesh(pair)
    geometry = Geometry(instance.unit)
    inputs, outputs = variables(instance)
    instance.initialize(
        {**CONSTANT, "damping": 1e3, "orientationInput": orientation, "formulation": formulation}
    )
    values = values_of(instance, inputs)
    for n in inputs:
        if "quaternion" not in n:
            values[n] += rng.uniform(-1, 1) * (1e-2 if "elocity" in n else 1e-5)
    slip = 4e-5 / geometry.rw[0]
    values["gear1.angles[3]"] += slip
    values["gear1.quaternion[4]"] += slip / 2
    instance.set(values)
    assert instance.get("mesh.flank") == 1
    check_derivatives(instance, values, outputs, rng)
