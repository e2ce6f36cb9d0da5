"""FMUs with tables and with contact at run time: the element against the solver the tables came from, and the one against the other."""

import math

import gearmesh
import numpy as np
import pytest
from conftest import COARSE, FORMULATIONS, QUICK, tabulated_pairs
from host import Unit
from scipy.optimize import brentq

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
    """An instance at this mesh position with this torque on gear 1."""
    correction = 0.0
    # Pressing the teeth moves the mesh position by the slip: again from a corrected start.
    for _ in range(3):
        instance = make(pair)
        g = instance.unit.geometry
        phase = (position + correction) * math.tau / g.teeth[0]
        instance.initialize({"damping": 0.0, "loadedFlank": 1 if sign > 0 else 2, "meshPhase": phase, **parameters})

        def missing(angle):
            instance.set({"gear1.angles[3]": angle})
            return abs(instance.get("gear1.moment[3]")) - torque

        found = brentq(missing, 0.0, sign * 6e-5 / g.pitch_radii[0], xtol=1e-16)
        assert abs(missing(found)) < 1e-7 * torque
        correction += (position - instance.get("mesh.position") + 0.5) % 1.0 - 0.5
    return instance


@FORMULATIONS
@pytest.mark.parametrize("flank", ["drive", "coast"])
@pytest.mark.parametrize("pair", CYCLE)
def test_under_torque_it_stands_on_either_flank_as_the_contact_solver_says(mesh, pair, flank, formulation):
    sign, levers = 1 if flank == "drive" else -1, []
    file = tabulated_pairs()[pair.removesuffix("-cycle")]
    for static in gearmesh.solve_all(file, [45.0, TORQUE, 160.0], positions=8, flank=flank, **QUICK):
        for i, position in list(enumerate(static.mesh_position))[:: 1 if static.torque_nm == TORQUE else 3]:
            instance = under_torque(mesh, pair, position, static.torque_nm, sign, formulation=formulation, shuttlingEffect=1)
            away = instance.get("mesh.position") - position
            assert away - round(away) == pytest.approx(0.0, abs=1e-8)
            found = sign * instance.get("mesh.transmissionError") * math.cos(instance.unit.geometry.pressure_angle) * 1e6
            assert found == pytest.approx(static.ste_loa_um[i], rel=3e-3)
            z = 1e3 * instance.get("mesh.contactZ")
            assert z == pytest.approx(static.contact_z_mm[i], abs=0.03)
            levers.append(z - 0.5 * file["gear1"]["face_width_mm"])
    # The slope moves the contact to the same end on both flanks: no mirrored table would.
    assert pair != "external-cycle" or np.mean(levers) < -0.1, levers


@pytest.mark.parametrize("flank", [1, -1], ids=["drive", "coast"])
@pytest.mark.parametrize("pair", CYCLE)
def test_root_stress_is_that_of_the_static_solve(mesh, pair, flank):
    rng = np.random.default_rng(31)
    torque = rng.uniform(40.0, 120.0)
    positions = 11  # no divisor of the table's
    options = {"positions": positions, "flank": "drive" if flank > 0 else "coast", "root_stress": True}
    solved = gearmesh.solve(tabulated_pairs()[pair.removesuffix("-cycle")], torque, **options, **QUICK)
    for k in rng.choice(np.arange(1, positions), 3, replace=False):
        instance = under_torque(mesh, pair, k / positions, torque, flank, rootStress=1)
        # The torque holds the change of the elastic energy over the cycle, too: compared is stress over load.
        force = instance.get("mesh.tangentialForce") * instance.unit.geometry.pitch_radii[0] / torque
        for gear in (0, 1):
            known = 1e6 * solved.root_stress_mpa[gear, k] * force
            assert instance.get(f"mesh.rootStress{gear + 1}") == pytest.approx(known, rel=0.015), (gear, k)


def test_inspect_tells_the_root_stress_of_the_tables_and_its_error(fmus):
    rows = gearmesh.inspect(fmus["external-cycle"]).text.splitlines()
    told = [row for row in rows if row.strip().startswith("root stress")]
    assert len(told) == 1 and "48 mesh positions" in told[0] and "of the largest stress" in told[0]
    assert "root stress" not in gearmesh.inspect(fmus["external-all"]).text


TABLE, CONTACT, TEETH = 2, 3, 4


def started(make, model, **parameters):
    instance = make("external-cycle")
    instance.initialize({"stiffnessModel": model, "damping": 0.0, **parameters})
    return instance


@FORMULATIONS
@pytest.mark.parametrize("flank", [1, 2], ids=["drive", "coast"])
def test_contact_at_run_time_is_that_of_the_tables(mesh, formulation, flank):
    sign = 1 if flank == 1 else -1
    for phase in np.linspace(0.0, 0.3, 7):
        both = [
            started(mesh, model, formulation=formulation, loadedFlank=flank, meshPhase=phase)
            for model in (TABLE, CONTACT)
        ]
        for instance in both:
            press(instance, 1.5e-5, sign)
        table, contact = (np.array([m.get("mesh.tangentialForce"), m.get("gear1.moment[3]")]) for m in both)
        # A phase is taken where the teeth just touch, which the table knows to a few hundredths of a micrometre.
        assert contact == pytest.approx(table, rel=1e-2)
        z = [1e3 * m.get("mesh.contactZ") for m in both]
        assert z[1] == pytest.approx(z[0], abs=0.1)


def test_contact_at_run_time_has_no_axes_and_no_range(mesh):
    instance = started(mesh, CONTACT, centerDistanceEffect=1, misalignmentEffect=1, shuttlingEffect=1)
    press(instance, 1.5e-5)
    before = instance.get("mesh.contactZ")
    c = instance.get("gear2.position[1]")
    # Beyond the pair file's range of misalignment and centre distance: still a mesh.
    instance.set({"gear2.angles[1]": 5e-3, "gear2.position[1]": c + 2e-4})
    press(instance, 6e-5)
    assert instance.get("mesh.tangentialForce") > 100.0
    assert abs(instance.get("mesh.contactZ") - before) > 1e-3


@pytest.mark.parametrize("model, remedy", [(CONTACT, "gearmesh build --contact"), (TEETH, "gearmesh tables --teeth")])
def test_a_level_that_a_unit_does_not_hold_is_refused_with_what_to_do(mesh, model, remedy):
    assert remedy in mesh("external-all").refused({"stiffnessModel": model})


def test_a_body_with_holes_has_a_balance_at_every_pose_of_flanks_without_crowning(tmp_path):
    """Their tables have misalignments a microradian apart at parallel axes, and the body turns the noise of the moment there into tilt."""
    gear = {"teeth": 25, "profile_shift": 0.1, "face_width_mm": 25.0, "bore_diameter_mm": 40.0}
    web = {"rim_thickness_mm": 8.0, "web_thickness_mm": 8.0, "hub_diameter_mm": 80.0, "bore_diameter_mm": 60.0}
    holes = {"count": 5, "circle_diameter_mm": 102.0, "diameter_mm": 14.0}
    pair = {
        "name": "holes", "meshing": "external", "normal_module_mm": 3.0, "normal_pressure_angle_deg": 20.0, "helix_angle_deg": 20.0,
        "backlash_um": 150.0, "gear1": gear, "gear2": gear | web | {"teeth": 47, "profile_shift": -0.1, "web_holes": holes},
        "operating": {
            "nominal_torque_nm": 300.0, "maximum_torque_nm": 450.0, "center_distance_offset_um": [0.0, 0.0], "misalignment_mrad": [-1.0, 1.0],
        },
    }  # fmt: skip
    unit = Unit(gearmesh.build(pair, tmp_path / "holes.fmu", **COARSE))
    instance = unit.instance()
    instance.initialize({"damping": 0.0, "coupling": 1})
    rng = np.random.default_rng(7)
    for turn, closed in zip(rng.uniform(0.0, 47 * math.tau / 25, 3000), 10.0 ** rng.uniform(-6.0, -3.1, 3000)):
        instance.set({"gear1.angles[3]": turn, "gear2.angles[3]": closed - turn * 25 / 47})
        assert math.isfinite(instance.get("gear1.moment[3]"))
    instance.close()
    unit.close()
