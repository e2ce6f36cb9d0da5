"""FMUs with tables: the element against the solver the tables came from."""

import math

import gearmesh
import numpy as np
import pytest
from conftest import FORMULATIONS, QUICK, tabulated_pairs
from test_state import goes_on_elsewhere

FULL = ["external-all", "ring2-all"]
CYCLE = ["external-cycle", "ring2-cycle"]
TORQUE = 100.0


def press(instance, tangential, sign=1):
    """Turns gear 1 until the elongation along the pitch circle is `tangential`."""
    radius = instance.unit.geometry.pitch_radii[0]
    for _ in range(4):
        missing = sign * tangential - instance.get("mesh.transmissionError")
        instance.set({"gear1.angles[3]": instance.get("gear1.angles[3]") + missing / radius})
    return instance


def under_torque(make, pair, position, torque=TORQUE, sign=1, **parameters):
    """An instance at this mesh position with this torque on gear 1, found by secants."""
    correction = 0.0
    # Pressing the teeth moves the mesh position by the slip: again from a corrected start.
    for _ in range(3):
        instance = make(pair)
        g = instance.unit.geometry
        pitch = 2 * math.pi / g.teeth[0]
        phase = (position + correction) * pitch
        start = {"damping": 0.0, "loadedFlank": 1 if sign > 0 else 2, "meshPhase": phase}
        instance.initialize({**start, **parameters})

        def missing(angle):
            instance.set({"gear1.angles[3]": angle})
            return abs(instance.get("gear1.moment[3]")) - torque

        a, b = sign * 5e-6 / g.pitch_radii[0], sign * 3e-5 / g.pitch_radii[0]
        at_a, at_b = missing(a), missing(b)
        for _ in range(40):
            if abs(at_b) < 1e-9 * torque or at_a == at_b:
                break
            a, b, at_a = b, b - at_b * (b - a) / (at_b - at_a), at_b
            at_b = missing(b)
        assert abs(at_b) < 1e-7 * torque
        correction += (position - instance.get("mesh.position") + 0.5) % 1.0 - 0.5
    return instance


@FORMULATIONS
@pytest.mark.parametrize("flank", ["drive", "coast"])
@pytest.mark.parametrize("pair", CYCLE)
def test_under_torque_it_stands_on_either_flank_as_the_contact_solver_says(table_mesh, pair, flank, formulation):
    sign, levers = 1 if flank == "drive" else -1, []
    file = tabulated_pairs()[pair.removesuffix("-cycle")]
    for static in gearmesh.solve_all(file, [45.0, TORQUE, 160.0], positions=8, flank=flank, **QUICK):
        for i, position in list(enumerate(static.mesh_position))[:: 1 if static.torque_nm == TORQUE else 3]:
            instance = under_torque(table_mesh, pair, position, static.torque_nm, sign, formulation=formulation, shuttlingEffect=1)
            away = instance.get("mesh.position") - position
            assert away - round(away) == pytest.approx(0.0, abs=1e-8)
            found = sign * instance.get("mesh.transmissionError") * math.cos(instance.unit.geometry.pressure_angle) * 1e6
            assert found == pytest.approx(static.ste_loa_um[i], rel=3e-3)
            z = 1e3 * instance.get("mesh.contactZ")
            assert z == pytest.approx(static.contact_z_mm[i], abs=0.03)
            levers.append(z - 0.5 * file["gear1"]["face_width_mm"])
    # The slope moves the contact to the same end on both flanks: no mirrored table would.
    assert pair != "external-cycle" or np.mean(levers) < -0.1, levers


@pytest.mark.parametrize("pair", FULL)
def test_a_state_on_tables_goes_on_in_another_process(table_mesh, table_fmus, tmp_path, pair):
    instance = table_mesh(pair).initialize({"meshPhase": 0.02, "loadDependent": 0})
    goes_on_elsewhere(instance, table_fmus[pair], tmp_path)


@pytest.mark.parametrize("flank", [1, -1], ids=["drive", "coast"])
@pytest.mark.parametrize("pair", CYCLE)
def test_root_stress_is_that_of_the_static_solve(table_mesh, pair, flank):
    rng = np.random.default_rng(31)
    torque = rng.uniform(40.0, 120.0)
    positions = 11  # no divisor of the table's
    options = {"positions": positions, "flank": "drive" if flank > 0 else "coast", "root_stress": True}
    solved = gearmesh.solve(tabulated_pairs()[pair.removesuffix("-cycle")], torque, **options, **QUICK)
    for k in rng.choice(np.arange(1, positions), 3, replace=False):
        instance = under_torque(table_mesh, pair, k / positions, torque, flank, rootStress=1)
        # The torque holds the change of the elastic energy over the cycle, too: compared is stress over load.
        force = instance.get("mesh.tangentialForce") * instance.unit.geometry.pitch_radii[0] / torque
        for gear in (0, 1):
            known = 1e6 * solved.root_stress_mpa[gear, k] * force
            assert instance.get(f"mesh.rootStress{gear + 1}") == pytest.approx(known, rel=0.015), (gear, k)


def test_inspect_tells_the_root_stress_of_the_tables_and_its_error(table_fmus):
    rows = gearmesh.inspect(table_fmus["external-cycle"]).text.splitlines()
    told = [row for row in rows if row.strip().startswith("root stress")]
    assert len(told) == 1 and "48 mesh positions" in told[0] and "of the largest stress" in told[0]
    assert "root stress" not in gearmesh.inspect(table_fmus["external-all"]).text
