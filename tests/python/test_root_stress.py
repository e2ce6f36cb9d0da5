"""Root stress in a packed unit: against `gearmesh solve`, derivatives, states and refusal."""

import gearmesh
import numpy as np
import pytest
from conftest import QUICK, pair_files
from test_mechanics import Geometry
from test_tables import CYCLE, under_torque

OUTPUTS = ["mesh.rootStress1", "mesh.rootStress2"]
ON = {"rootStress": 1}
# No divisor of the table's mesh positions.
POSITIONS = 11


@pytest.mark.parametrize("flank", [1, -1], ids=["drive", "coast"])
@pytest.mark.parametrize("pair", CYCLE)
def test_root_stress_is_that_of_the_static_solve(table_mesh, pair, flank):
    rng = np.random.default_rng(31)
    torque = rng.uniform(40.0, 120.0)
    options = {"positions": POSITIONS, "flank": "drive" if flank > 0 else "coast", "root_stress": True}
    solved = gearmesh.solve(pair_files()[pair.removesuffix("-cycle")], torque, **options, **QUICK)
    for k in rng.choice(np.arange(1, POSITIONS), 3, replace=False):
        instance = under_torque(table_mesh, pair, k / POSITIONS, torque, flank, **ON)
        g = Geometry(instance.unit)
        # The torque holds the change of the elastic energy over the cycle, too: compared is stress over load.
        force = instance.get("mesh.tangentialForce") * g.rw[0] / torque
        for gear, name in enumerate(OUTPUTS):
            known = 1e6 * solved.root_stress_mpa[gear, k] * force
            assert instance.get(name) == pytest.approx(known, rel=0.015), (gear, k)


def test_tables_without_root_stress_are_refused_by_name(table_mesh):
    log = table_mesh("external-all").refused(ON)
    assert "rootStress = true" in log and "--root-stress" in log


def test_inspect_tells_the_root_stress_of_the_tables_and_its_error(table_fmus):
    rows = gearmesh.inspect(table_fmus["external-cycle"]).text.splitlines()
    told = [row for row in rows if row.strip().startswith("root stress")]
    assert len(told) == 1 and "48 mesh positions" in told[0] and "of the largest stress" in told[0]
    assert "root stress" not in gearmesh.inspect(table_fmus["external-all"]).text
