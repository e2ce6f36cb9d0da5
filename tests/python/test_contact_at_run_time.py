"""Static contact solved at every evaluation: against the tables of the same pair, and against itself."""

import numpy as np
import pytest
from conftest import FORMULATIONS
from test_tables import press

TABLE, CONTACT, TEETH = 2, 3, 4


def started(make, model, **parameters):
    instance = make("external-cycle")
    instance.initialize({"stiffnessModel": model, "damping": 0.0, **parameters})
    return instance


@FORMULATIONS
@pytest.mark.parametrize("flank", [1, 2], ids=["drive", "coast"])
def test_contact_at_run_time_is_that_of_the_tables(table_mesh, formulation, flank):
    sign = 1 if flank == 1 else -1
    for phase in np.linspace(0.0, 0.3, 7):
        both = [
            started(table_mesh, model, formulation=formulation, loadedFlank=flank, meshPhase=phase)
            for model in (TABLE, CONTACT)
        ]
        for instance in both:
            press(instance, 1.5e-5, sign)
        table, contact = (np.array([m.get("mesh.tangentialForce"), m.get("gear1.moment[3]")]) for m in both)
        # A phase is taken where the teeth just touch, which the table knows to a few hundredths of a micrometre.
        assert contact == pytest.approx(table, rel=1e-2)
        z = [1e3 * m.get("mesh.contactZ") for m in both]
        assert z[1] == pytest.approx(z[0], abs=0.1)


def test_contact_at_run_time_has_no_axes_and_no_range(table_mesh):
    instance = started(table_mesh, CONTACT, centerDistanceEffect=1, misalignmentEffect=1, shuttlingEffect=1)
    press(instance, 1.5e-5)
    before = instance.get("mesh.contactZ")
    c = instance.get("gear2.position[1]")
    # Beyond the pair file's range of misalignment and centre distance: still a mesh.
    instance.set({"gear2.angles[1]": 5e-3, "gear2.position[1]": c + 2e-4})
    press(instance, 6e-5)
    assert instance.get("mesh.tangentialForce") > 100.0
    assert abs(instance.get("mesh.contactZ") - before) > 1e-3


@pytest.mark.parametrize("model, remedy", [(CONTACT, "gearmesh build --contact"), (TEETH, "gearmesh tables --teeth")])
def test_a_level_that_a_unit_does_not_hold_is_refused_with_what_to_do(table_mesh, model, remedy):
    assert remedy in table_mesh("external-all").refused({"stiffnessModel": model})
