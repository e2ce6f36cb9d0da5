"""Friction in a packed unit: power, derivatives, states and refusal."""

import numpy as np
import pytest
from test_mechanics import Geometry
from conftest import FORMULATIONS
from test_tables import CYCLE, press

OUTPUTS = ["mesh.frictionPower", "mesh.frictionCoefficient", "mesh.lossFactor"]


def turning(make, pair, spin, **parameters):
    """A loaded instance whose gears turn in their ratio."""
    instance = make(pair)
    g = Geometry(instance.unit)
    instance.initialize({"damping": 0.0, **parameters})
    press(instance, 1.5e-5)
    speeds = {"gear1.angularVelocity[3]": spin, "gear2.angularVelocity[3]": -g.e * spin * g.z[0] / g.z[1]}
    instance.set(speeds)
    return instance


def shaft_power(instance):
    return sum(
        np.dot(instance.vector(f"gear{i}.moment"), instance.vector(f"gear{i}.angularVelocity"))
        for i in (1, 2)
    )


@FORMULATIONS
@pytest.mark.parametrize("pair", CYCLE)
def test_friction_takes_from_the_shafts_what_it_says(table_mesh, pair, formulation):
    for spin in (-200.0, 0.01, 200.0):
        free = turning(table_mesh, pair, spin, formulation=formulation)
        rubbed = turning(table_mesh, pair, spin, formulation=formulation, friction=1)
        assert [free.get(name) for name in OUTPUTS] == [0.0, 0.0, 0.0]
        power, coefficient, loss_factor = (rubbed.get(name) for name in OUTPUTS)
        assert coefficient == pytest.approx(0.05) and 0.0 < loss_factor < 0.5
        taken = shaft_power(rubbed) - shaft_power(free)
        assert power < 0.0 and taken == pytest.approx(power, rel=1e-6)
        g = Geometry(free.unit)
        transmitted = abs(free.get("gear1.moment[3]") * spin)
        if abs(spin) > 1.0:
            # The base circle's force, to the part of the torque that the mesh keeps as energy.
            assert -power == pytest.approx(coefficient * loss_factor * transmitted, rel=0.03)
        assert g.z[0] > 0


def test_friction_without_sliding_in_the_tables_is_refused_by_name(table_mesh):
    assert "friction = true" in table_mesh("external-all").refused({"friction": 1})
