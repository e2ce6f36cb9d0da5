"""Short forms of examples/drivelines: the element in assemblies, against closed forms and balances."""

import re
from contextlib import closing
from dataclasses import replace
from functools import partial

import gearmesh
import numpy as np
import pytest
from gearmesh.exudyn import attach_stepped
from gearmesh.poses import generalised
from scipy.sparse import csc_matrix, hstack, identity
from scipy.sparse.linalg import spsolve
from examples.drivelines import holes, loss
from examples.drivelines.cosimulation import balance as cosimulation, masters, ssp
from examples.drivelines.housing import cases as housing
from examples.drivelines.planetary import cases as planetary, phase
from examples.drivelines.planetary.stage import IN_PHASE, PITCH, SEQUENTIAL
from examples.drivelines.rattle import idle, mujoco_joint
from examples.drivelines.response import jump, linear
from examples.drivelines.sweep import __main__ as study
from examples.drivelines.tutorial import __main__ as tutorial
from examples.shared import files, gearbox, walls
from examples.shared.gearbox import HELICAL, SPUR
from scripts.docs.check import cell
from validation import steps


def test_bricks_bend_as_a_free_plate_does():
    """Square, Poisson's ratio 0.3: omega a^2 sqrt(rho h / D) by Leissa, Vibration of Plates, NASA SP-160, 1969."""
    side, thickness, young, density = 0.4, 4e-3, 206e9, 7850.0
    edge = np.linspace(0.0, side, 11)
    mesh = walls.fem.MeshHex.init_tensor(edge, edge, np.array([0.0, thickness]))
    _, stiffness, mass = walls.elasticity(mesh, young, 0.3, density)
    found = 2.0 * np.pi * walls.frequencies(stiffness, mass, 11)[6:]
    rigidity = young * thickness**3 / 12.0 / (1.0 - 0.3**2)
    assert found * side**2 * np.sqrt(density * thickness / rigidity) == pytest.approx([13.489, 19.789, 24.432, 35.024, 35.024], rel=0.02)


@pytest.fixture(scope="module")
def box():
    return walls.Box(SPUR.center_distance)


def test_the_reduced_housing_has_the_statics_and_the_modes_of_its_elements(box):
    found = walls.housing(SPUR.center_distance)
    solid = seated(box)
    full = 2.0 * np.pi * walls.frequencies(solid.T @ box.mounted() @ solid, solid.T @ box.mass @ solid, 26)
    assert found.frequencies[:26] == pytest.approx(full, rel=0.015)
    load = np.zeros(solid.shape[1])
    load[:3], load[12:15] = (1000.0, 300.0, 200.0), (-1000.0, -300.0, -200.0)  # on a seat of each shaft
    exact = solid @ spsolve((solid.T @ box.mounted() @ solid).tocsc(), load)
    reduced = found.shapes @ (found.seats.T @ np.r_[load[:3], 0, 0, 0, load[12:15], 0, 0, 0] / found.frequencies**2)
    at_seats = np.any([box.patch(seat) for seat in box.seats], axis=0)
    assert np.abs(reduced - exact)[at_seats].max() < 1e-6 * np.abs(exact).max()


def seated(box):
    """From displacement and rotation of the rigid seats, then the other freedoms, to all freedoms."""
    patches = [box.patch(seat) for seat in box.seats]
    rigid = np.hstack([box.rigid(seat) * patch[:, None] for seat, patch in zip(box.seats, patches)])
    others = identity(len(rigid), format="csc")[:, ~np.any(patches, axis=0)]
    return hstack([csc_matrix(rigid), others]).tocsc()


def test_the_modes_of_the_box_have_converged_to_two_percent(box):
    coarse, fine = (walls.frequencies(b.mounted(), b.mass, 20) for b in (box, walls.Box(SPUR.center_distance, 0.6 * walls.ELEMENT)))
    assert coarse == pytest.approx(fine, rel=0.02)


def test_bearings_carry_what_statics_asks_for():
    assert housing.deviation_from_statics(housing.torque_ramp(duration=0.1)) < 2e-3


def test_the_run_up_by_co_simulation_is_that_of_model_exchange():
    def run(coupling):
        (history,) = gearbox.sweep("variable load", duration=0.1, coupling=coupling)
        return history.time_s, history["tangential_force_n"], history["transmission_error_um"]

    time, force, error = run(None)
    for coupling in ("sequential", "parallel"):
        _, found_force, found_error = run(coupling)
        assert found_force.max() == pytest.approx(force.max(), rel=0.02)
        # Evenly accelerated: the share of the time is the share of the speed.
        assert time[found_force.argmax()] == pytest.approx(time[force.argmax()], rel=0.005)
        assert found_force.std() == pytest.approx(force.std(), rel=0.005)
        assert np.sqrt(np.mean((found_error - error) ** 2)) < 0.02 * error.std()


def test_vibration_of_the_mesh_comes_with_its_changing_stiffness_alone():
    swing = {}
    for variant in ("variable load", "constant stiffness"):
        (history,) = gearbox.sweep(variant, rpm=2100.0, duration=0.1)
        force = history["tangential_force_n"][history.time_s >= 0.08]
        swing[variant] = np.ptp(force) / force.mean()
    assert swing["variable load"] > 0.2
    assert swing["constant stiffness"] < 0.1 * swing["variable load"]


def test_the_run_down_keeps_to_the_upper_branch_where_teeth_part():
    up, down = gearbox.sweep("variable load", rpm=4800.0, duration=0.3, down=True)
    peaks = [(h["tangential_force_n"].max(), h.speed_rpm[h["tangential_force_n"].argmax()]) for h in
             (branch.cut((branch.speed_rpm > 3200.0) & (branch.speed_rpm < 4700.0)) for branch in (up, down))]  # fmt: skip
    assert peaks[1][0] > peaks[0][0] and peaks[1][1] < 0.95 * peaks[0][1]
    # The page's, whose speed changes a quarter as fast.
    for way, peak in zip(("up", "down"), peaks):
        stated = cell("drivelines/housing.csv", f"variable load, run-{way}", "largest tangential force")
        assert peak == pytest.approx([float(x) for x in re.findall(r"\d+", stated)], rel=0.03)
    # Up, the mesh resonates near the eigenfrequency of its mean stiffness.
    assert peaks[0][1] * SPUR.teeth[0] / 60.0 == pytest.approx(housing.mesh_resonance(2.33e8), rel=0.06)


def test_phase_between_sun_and_ring_mesh_is_that_of_the_tooth_thickness():
    assert planetary.measured_phase() == pytest.approx(phase.at_pitch_points(), abs=2e-4)


def test_the_published_phase_counts_from_the_tips_and_leaves_the_tooth_thickness_out():
    found = phase.conventions(phase.STANDARD)
    near = [point for point, value in found.items() if abs(value - phase.PUBLISHED) < 5e-5]
    assert near == ["the same, thickness of the planet's teeth left out"]


def test_the_published_phase_needs_a_tip_that_nobody_published_where_the_tooth_thickness_counts():
    for teeth in (phase.STANDARD, phase.FITTED):
        ring = phase.ring_tip_for(phase.PUBLISHED, teeth)
        found = phase.conventions(replace(teeth, tips=(*teeth.tips[:2], ring)))
        assert found["end of contact, ring drives"] == pytest.approx(phase.PUBLISHED, abs=1e-12)
        assert 0.3e-3 < teeth.tips[2] - ring < 2e-3


@pytest.fixture(scope="module")
def mesh_cycles():
    """Of planets that tilt, in phase and not."""
    return [planetary.cycle(places) for places in (IN_PHASE, SEQUENTIAL)]


def test_sequential_planets_leave_of_each_harmonic_what_their_phases_add_up_to(mesh_cycles):
    spectra = [np.abs(np.fft.rfft(cycle.error)) for cycle in mesh_cycles]
    for harmonic in (1, 2):
        ratio = spectra[1][harmonic] / spectra[0][harmonic]
        assert ratio == pytest.approx(planetary.vanishing(SEQUENTIAL, harmonic), rel=0.03)


def test_the_page_has_the_figures_of_the_stage(mesh_cycles):
    def stated(table, row, column):
        return float(re.search(r"[\d.]+", cell(f"drivelines/planetary-{table}.csv", row, column))[0])

    in_phase, sequential = mesh_cycles
    spectra = [2e6 * PITCH[0] * np.abs(np.fft.rfft(cycle.error)) / 32 for cycle in mesh_cycles]
    for n in (1, 2, 3):
        for column, spectrum in zip(("in phase (0/40/80)", "0/42/84"), spectra):
            assert spectrum[n] == pytest.approx(stated("harmonics", str(n), column), rel=5e-3, abs=5e-4)
    assert np.linalg.norm(sequential.lateral.mean(axis=0)) == pytest.approx(
        stated("harmonics", "steady", "lateral force on the sun at 0/42/84, N"), rel=1e-3
    )
    column = "bearings 160 mm apart"
    moment = stated("tilt", "moment on a pin, mean over the mesh cycle, N m", column)
    assert in_phase.tilting[:, 1].mean() == pytest.approx(moment, rel=1e-3)
    assert 1e6 * abs(in_phase.tilt.mean()) == pytest.approx(stated("tilt", "tilt of a planet, µrad", column), rel=3e-3)


def test_no_lateral_force_on_the_sun_where_even_planets_mesh_in_phase(mesh_cycles):
    in_phase, sequential = (np.abs(np.fft.rfft(cycle.lateral, axis=0)) / 32 for cycle in mesh_cycles)
    assert in_phase.max() < 1e-5 * sequential[1].max()
    assert np.linalg.norm(sequential[0]) == pytest.approx(planetary.steady_lateral(SEQUENTIAL), rel=0.02)


def test_the_axial_forces_overturn_a_helical_planet_and_push_the_sun_as_in_closed_form(mesh_cycles):
    moment, thrust = planetary.overturning()
    stiff, tilting = planetary.cycle(positions=8, span=planetary.STIFF), mesh_cycles[0]
    for cycle in (stiff, tilting):
        assert -cycle.thrust.mean() == pytest.approx(thrust, rel=0.01)
    assert stiff.tilting[:, 1].mean() == pytest.approx(moment, rel=0.01)
    # Where planets tilt, their load moves along the face and takes a share of the moment.
    assert 0.6 * moment < tilting.tilting[:, 1].mean() < 0.9 * moment


def test_planets_share_the_load_as_springs_do_and_equally_with_a_floating_sun():
    stiffness = planetary.path_stiffness()
    for floating in (False, True):
        found = planetary.load_sharing(50e-6, floating, positions=1)
        expected = planetary.shares_in_closed_form(50e-6, floating, stiffness)
        assert found == pytest.approx(expected, abs=2e-3)


BALANCES = {
    "one freedom": lambda damped: linear.balance(linear.ONE, damped, duration=2e-3),
    "six freedoms": lambda damped: linear.balance(linear.SIX, damped, duration=2e-3),
    "teeth that part": lambda damped: jump.balance(damped, duration=0.01),
    "rattling gearbox": lambda damped: idle.balance(damped, duration=0.02, step=5e-6),
    "shafts and housing": lambda damped: cosimulation.balance(damped, duration=1e-3),
    "planetary stage": lambda damped: planetary.balance(damped, duration=5e-3),
    "tilted gears": lambda damped: study.balance(damped, duration=5e-3),
    "friction": lambda damped: loss.balance(damped, duration=5e-3),
    "free spur gearbox": lambda damped: housing.balance(SPUR, damped, duration=0.003),
    "free helical gearbox": lambda damped: housing.balance(HELICAL, damped, duration=0.003),
    "gearbox on mounts, rising torque": lambda damped: housing.balance_of_ramp(damped, duration=0.02),
} | {
    f"gearbox on mounts, rising speed, {variant}": partial(housing.balance_of_sweep, variant, rpm=300.0, duration=0.04, step=5e-6)
    for variant in gearbox.VARIANTS
}


@pytest.mark.parametrize("name", BALANCES)
@pytest.mark.parametrize("damped", [False, True], ids=["undamped", "damped"])
def test_what_goes_in_is_stored_or_lost_and_loads_cancel(name, damped):
    found = BALANCES[name](damped=damped)
    assert found["energy over mesh"] < 1e-4
    assert found["loads"] < 1e-13
    assert found.get("momentum", 0.0) < (1e-11 if name.startswith("free") else 1e-13)
    # Teeth part where an example is about that.
    assert name.startswith(("free", "gearbox")) or found.get("share of time apart", 1.0) > 0.0


@pytest.mark.parametrize("support", [linear.ONE, linear.SIX], ids=["one freedom", "six freedoms"])
def test_small_swings_follow_the_linear_frequency_response(support):
    for frequency in (500.0, 5000.0):
        assert linear.measured(support, frequency) == pytest.approx(linear.closed_form(support, [frequency])[0], rel=2e-3)


def test_run_up_jumps_at_a_higher_speed_than_run_down_and_both_leave_the_linear_line_where_teeth_part():
    run = jump.sweep(1600.0, 2600.0, sweep_s=0.6)
    (up, apart), (down, _) = jump.jump(run.up), jump.jump(run.down)
    assert up > 1.1 * down
    speeds = np.linspace(1600.0, 2600.0, 201)
    linear_line = jump.linear_swing(run.natural_frequency_hz, speeds)
    ends = speeds[np.isnan(linear_line)]
    assert ends.min() < run.resonance_rpm < ends.max()
    assert apart.min() == pytest.approx(ends.min(), rel=0.04)
    at, swing = gearmesh.swing(run.up, "transmission_error_um")
    touching = (at > 1700.0) & (at < 2200.0)
    assert swing[touching] == pytest.approx(np.interp(at[touching], speeds, linear_line), rel=0.15)


@pytest.mark.slow
def test_holes_in_a_web_make_sidebands_of_the_mesh_in_the_velocity_of_the_walls():
    with_holes, mean_wheel = (holes.levels(body_effect, turns=3) for body_effect in (True, False))
    z, n = holes.SPUR.teeth[1], holes.HOLES
    assert with_holes[z] == pytest.approx(mean_wheel[z], abs=1.0)  # dB
    assert with_holes[n] > mean_wheel[n] + 30.0
    assert with_holes[z - n] > mean_wheel[z - n] + 10.0


@pytest.mark.parametrize("law", loss.LAWS)
def test_the_unit_loses_over_a_mesh_cycle_what_solve_says(law):
    expected = loss.solved("C14", law, relief=False).loss_w[loss.SPEEDS.index(1500.0)]
    assert loss.through_the_fmu("C14", law, 1500.0) == pytest.approx(expected, rel=5e-3)
    if law == "schlenk":
        assert expected == pytest.approx(loss.PUBLISHED, rel=0.035)


@pytest.fixture(scope="module")
def on_bearings():
    with closing(masters.Gears(steps.TOUCHING)) as gears:
        return steps.exact(gears, 2.5e-7), steps.hosts(gears)


@pytest.mark.parametrize("name", ["loop, the FMU first", "loop, all at once", *ssp.HOSTS])
def test_a_host_that_says_nothing_may_take_more_than_ten_times_the_step_of_held_loads(on_bearings, name):
    reference, hosts = on_bearings
    host, _ = hosts[name]
    found, held = host("automatic", 4e-6), host("held", 2.5e-7)
    assert masters.distance(found[0], reference, found[1]) < masters.distance(held[0], reference, held[1]) < 2e-3


@pytest.mark.parametrize("host", ssp.HOSTS)
def test_hosts_run_the_ssp_and_converge_to_the_monolithic_run(host):
    with closing(masters.Gears()) as gears:
        begin, duration = masters.start(gears), 2.56e-4
        reference = masters.monolithic(gears, begin, duration, 2.5e-7)
        file = ssp.build(gears, begin)
    coarse, fine = (masters.distance(ssp.HOSTS[host](file, duration, size), reference, ssp.COLUMNS) for size in (5e-7, 2.5e-7))
    assert fine < 1e-4
    assert np.log2(coarse / fine) == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("coupling, order", [("held", 1.0), ("extrapolated", 2.0), ("iterated", 2.0)])
def test_cosimulation_converges_to_the_monolithic_run_with_the_order_of_its_coupling(coupling, order):
    with closing(masters.Gears()) as gears:
        begin, duration = masters.start(gears), 5.12e-4
        reference = masters.monolithic(gears, begin, duration, 2.5e-7)
        coarse, fine = (
            masters.distance(masters.cosimulate(gears, begin, duration, size, coupling), reference)
            for size in (5e-7, 2.5e-7)
        )
    assert fine < 1e-4
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.15)


def test_the_error_of_a_coupling_is_the_largest_of_the_run_at_the_points_of_both():
    times = np.linspace(1.0 / 64, 1.0, 64)
    reference = np.outer(times, np.ones(6))
    for every in (1, 4):
        found = reference[every - 1 :: every].copy()
        found[:, 0] += 1.5e-6 * np.sin(np.pi * times[every - 1 :: every])  # zero at the end
        assert masters.distance(found, reference) == pytest.approx(0.1) == masters.distance(found[:, [0]], reference, [0])
        assert masters.distance(reference, found) == pytest.approx(0.1)


@pytest.mark.parametrize(
    "coupling, orders",
    [
        ("parallel", (1.0, 1.0)),
        ("held", (1.0, 1.0)),
        ("predicted parallel", (2.0, 1.0)),  # momentum: the seats' forces are held
        ("predicted sequential", (2.0, 1.0)),
        ("extrapolated", (2.0, 2.0)),
        ("iterated", (2.0, 2.0)),
    ],
)
def test_a_coupling_creates_energy_and_momentum_with_its_order(coupling, orders):
    coarse, fine = (cosimulation.coupling_balance(size, coupling, duration=2.56e-4) for size in (2e-6, 1e-6))
    for name, order in zip(("energy over mesh", "momentum"), orders):
        assert np.log2(coarse[name] / fine[name]) == pytest.approx(order, abs=0.15)
    assert fine["loads"] < 1e-13


@pytest.mark.parametrize("coupling", ["predicted parallel", "predicted sequential"])
def test_predicted_loads_bear_twice_the_packed_step_and_err_by_less_than_a_percent_at_it(coupling):
    with closing(masters.Gears()) as gears:
        begin, packed, duration = masters.start(gears), masters.packed_step(), 1.024e-3
        assert masters.stands(gears, begin, 2.0 * packed, coupling, duration=4e-3)
        assert not masters.stands(gears, begin, packed, "held", duration=4e-3)
        steps = round(duration / packed)
        reference = masters.monolithic(gears, begin, steps * packed, packed / 32)
        found = masters.cosimulate(gears, begin, steps * packed, packed, coupling)
    assert masters.distance(found, reference) < 0.01


def test_the_first_loads_of_a_parallel_unit_act_at_once_in_exudyn():
    class Bodies:
        def AddObject(self, item):
            self.forces = item.forceUserFunction

    bodies, q, rest = Bodies(), np.zeros(12), np.zeros(12)
    with files.opened(files.shipped("fzg-c"), {"coupling": "parallel"}, "co-simulation") as pair:
        step = attach_stepped(bodies, pair, [0, 1], [[0.0, 0.0, 0.0], [pair.geometry.center_distance, 0.0, 0.0]])
        loads = []
        for turn in (1e-3, 2e-3):
            q[5] = turn
            step(q, rest, 1e-6)
            loads.append(pair.y[:12])
            # Of the first step, in that step and in the next one.
            assert any(loads[0]) and bodies.forces(None, 0.0, 0, q, rest) == pytest.approx(generalised(loads[0], q))
        assert loads[1] != loads[0]


def test_an_idle_gear_bounces_once_a_period_where_its_restitution_lets_it():
    low, high = idle.period_one(idle.restitution())
    assert low < 1.0 < high
    below, within = idle.shaken(0.9 * low, periods=30), idle.shaken(1.0, periods=30)
    assert np.abs(below).max() < 2e-6
    assert within.min() > 3e-5 and np.ptp(within) < 4e-6


def test_an_idle_gear_rattles_by_co_simulation_as_by_model_exchange_once_loads_are_predicted():
    flight = {c: idle.shaken(1.0, periods=30, coupling=c).mean() for c in (None, "sequential", "parallel", "held")}
    for coupling in ("sequential", "parallel"):
        assert flight[coupling] == pytest.approx(flight[None], rel=5e-3)
    assert flight["held"] > 1.015 * flight[None]


def test_an_idle_gear_in_a_gearbox_rattles_once_its_drag_cannot_follow():
    assert idle.gearbox(0.9, periods=14)[1] == 0.0
    loaded, unloaded = idle.gearbox(1.2, periods=14)
    assert loaded == 0.0 and unloaded > 0.1


def test_a_reversing_joint_in_mujoco_loses_the_gap_and_the_deflection_of_the_teeth():
    lost = mujoco_joint.lost_motion(*mujoco_joint.run(True))
    assert mujoco_joint.GAP < lost < 1.05 * mujoco_joint.GAP


def test_the_element_in_mujoco_keeps_its_energy_while_it_hits_on_both_flanks():
    found = mujoco_joint.balance("RK4", 2.5e-6)
    assert found["energy over mesh"] < 1e-4
    assert found["loads"] < 1e-13
    assert found["share of time apart"] > 0.0 and found["share of time on the second flank"] > 0.0


def test_what_a_first_order_integrator_strays_in_mujoco_falls_with_its_step():
    coarse, fine = (mujoco_joint.balance("implicitfast", step)["energy over mesh"] for step in (5e-6, 2.5e-6))
    assert np.log2(coarse / fine) == pytest.approx(1.0, abs=0.3)


def test_the_figures_of_the_tutorial_are_those_found():
    """To the last digit given; `make report` writes them anew."""
    pairs = tutorial.pair_files()
    head, *rows = tutorial.table(pairs, tutorial.run_ups(pairs))
    for name, *values in rows:
        for column, value in zip(head[1:], values):
            stated = cell("drivelines/tutorial.csv", f"quantity={name}", column)
            unit = 10.0 ** -len(stated.partition(".")[2])
            assert stated == value or float(stated) == pytest.approx(float(value), rel=0.01, abs=unit), (name, column)


def test_the_relief_of_the_tutorial_takes_the_first_harmonic_at_its_torque_alone():
    first = {
        (pair.stem, cycle.torque_nm): cycle.harmonics_loa_um[0]
        for pair in (tutorial.PAIRS / "spur-50-50.json", tutorial.relieved())
        for cycle in tutorial.static(pair, tutorial.TORQUE, 2.0 * tutorial.TORQUE)
    }
    before, after = ({t: first[name, t] for t in (150.0, 300.0)} for name in ("spur-50-50", "spur-50-50-relieved"))
    assert after[150.0] < 0.15 * before[150.0]
    assert after[300.0] > before[300.0]
