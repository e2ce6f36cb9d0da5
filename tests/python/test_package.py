"""The functions of the Python package against closed forms, synthetic signals and the command's own output."""

import inspect
import json
import math
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import gearmesh
import matplotlib
import numpy as np
import pytest
from conftest import ALIGNED, GEARMESH, PAIRS, QUICK, TABLES, oscillator, pair_files
from gearmesh import History, plots
from gearmesh.analysis import _phasors
from gearmesh.energy import Ledger, mesh_energy, mesh_loss, wrench_residual
from gearmesh.poses import generalised, place
from gearmesh.sweep import grid, sweep
from scipy.spatial.transform import Rotation

matplotlib.use("Agg")
PAIR = PAIRS / "palermo2013.json"


def rotation(*angles):
    """Rx Ry Rz."""
    return Rotation.from_euler("XYZ", angles).as_matrix()


@pytest.fixture(scope="module")
def geometry(fmus):
    with gearmesh.GearPair(fmus["external"]) as pair:
        return pair.geometry


def test_every_public_function_is_annotated_and_documented():
    for name in gearmesh.__all__:
        thing = getattr(gearmesh, name)
        assert thing.__doc__, name
        if not isinstance(thing, type):
            assert set(inspect.signature(thing).parameters) | {"return"} == set(thing.__annotations__), name
            assert all(f"\n{part}\n---" in inspect.getdoc(thing) for part in ("Parameters", "Yields" if "Iterator" in thing.__annotations__["return"] else "Returns")), name


def test_solve_gives_what_the_command_prints():
    command = [GEARMESH, "solve", PAIR, "--json", "--torque-nm=40,100", "--misalignment-mrad=0.5", "--positions=8", "--speed-rpm=1000"]
    options = ["--refinement=coarse", "--stations=12", f"--cache-dir={QUICK['cache_dir']}", "-q"]
    printed = json.loads(subprocess.run(command + options, check=True, capture_output=True, text=True).stdout)["cases"]
    found = gearmesh.solve_all(PAIR, [40.0, 100.0], [0.5], positions=8, speed_rpm=[1000.0], **QUICK)
    one = gearmesh.solve(json.loads(PAIR.read_text()), 100.0, 0.5, positions=8, speed_rpm=[1000.0], **QUICK)
    for cycle, case in zip([*found, one], [*printed, printed[1]], strict=True):
        assert (cycle.torque_nm, cycle.misalignment_mrad) == (case["torque_nm"], 0.5)
        for name, value in vars(cycle).items():
            if isinstance(value, np.ndarray):
                assert value == pytest.approx(np.array(case[name], dtype=float), rel=1e-12, nan_ok=True), name
    assert one.load_share.shape == (8, len(one.tooth_pairs)) and one.load_share.sum(axis=1) == pytest.approx(np.ones(8))
    assert set(printed[0]) - {"center_distance_offset_um"} <= set(vars(one)), "a result without a field"
    assert one.root_stress_mpa is None and np.isnan(one.edge_z_mm).any()


@pytest.mark.parametrize("loads", [{"torque_nm": [50, 100]}, {"torque_nm": np.array([50.0])}, {"misalignment_mrad": (0.0, 0.1)}])
def test_several_loads_for_one_cycle_are_refused_with_the_function_that_takes_them(loads):
    (name,) = loads
    with pytest.raises(TypeError, match=rf"^{name} = .*: give one number; `solve_all` takes several loads"):
        gearmesh.solve(PAIR, **loads)


def test_study_reads_its_samples_and_statistics(tmp_path):
    vary = {"gear1.tip_relief.amount_um": 2.0, "misalignment_mrad": (-0.2, 0.2)}
    found = gearmesh.study(PAIR, tmp_path / "study", vary, samples=12, positions=8, **QUICK)
    spans = found.samples["peak_to_peak_ste_loa_um"]
    assert spans.shape == (13,) and found.errors == [""] * 13
    (stated,) = [row for row in found.statistics if row.result == "peak_to_peak_ste_loa_um"]
    assert (stated.point, stated.torque_nm, found.best) == (0, 100.0, None)
    assert (stated.nominal, stated.mean, stated.largest) == pytest.approx((spans[0], spans[1:].mean(), spans[1:].max()), rel=1e-6)
    amount = found.samples["gear1.tip_relief.amount_um"]
    assert amount[0] == 7.0 and np.all(np.abs(amount - 7.0) <= 2.0) and np.ptp(found.samples["misalignment_mrad"]) > 0.1
    correlation = np.corrcoef(amount[1:], spans[1:])[0, 1]
    assert stated.correlation["gear1.tip_relief.amount_um"] == pytest.approx(correlation, abs=1e-6)


def test_study_of_a_grid_finds_its_best_point(tmp_path):
    vary = {"gear1.tip_relief.amount_um,gear2.tip_relief.amount_um": (1.0, 13.0, 3)}
    options = {"best": "peak_to_peak_ste_loa_um", "torques_nm": [50.0, 100.0], "weights": [1.0, 3.0], "positions": 8}
    found = gearmesh.study(PAIR, tmp_path / "grid", vary, **options, **QUICK)
    spans = found.samples["peak_to_peak_ste_loa_um"].reshape(-1, 2)
    assert len(spans) == 4 and found.samples["torque_nm"][:2].tolist() == [50.0, 100.0]
    # Two fields share the values, each with its own correlation.
    assert all(list(s.correlation) == next(iter(vary)).split(",") for s in found.statistics)
    measures = spans @ [0.25, 0.75]
    assert found.best["value"] == pytest.approx(measures[1:].min(), rel=1e-6)
    best = json.loads((tmp_path / "grid" / "best.json").read_text())
    amount = found.samples["gear1.tip_relief.amount_um"][2 * found.best["point"]]
    assert best["gear1"]["tip_relief"]["amount_um"] == best["gear2"]["tip_relief"]["amount_um"] == amount


def test_study_optimizes_within_its_requirements(tmp_path):
    vary = {"gear1.tip_relief.amount_um": (0.0, 20.0, "optimize")}
    options = {"best": "peak_to_peak_ste_loa_um", "points": 12, "positions": 8}
    found = gearmesh.study(PAIR, tmp_path / "free", vary, **options, **QUICK)
    pressures = found.samples["maximum_pressure_mpa"]
    assert pressures.shape == (13,) and found.violates == [""] * 13
    limit = 0.5 * (pressures[1:].min() + pressures[1:].max())
    held = gearmesh.study(PAIR, tmp_path / "held", vary, **options, require=[f"maximum_pressure_mpa<{limit}"], **QUICK)
    pressures = held.samples["maximum_pressure_mpa"]
    assert [bool(words) for words in held.violates] == (pressures >= limit).tolist()
    assert pressures[held.best["point"]] < limit
    with pytest.raises(gearmesh.CommandError, match="no point meets all requirements"):
        gearmesh.study(PAIR, tmp_path / "none", vary, **options, require=["maximum_pressure_mpa<1"], **QUICK)


def test_inspect_knows_every_kind_of_file(fmus):
    fmu, tables, pair = (gearmesh.inspect(file) for file in (fmus["fzg-c"], TABLES / "fzg-c.json", PAIR))
    assert (fmu.kind, tables.kind, pair.kind) == ("fmu", "tables", "pair")
    for shown in (fmu, tables):
        for name, value in shown.values["listing"].items():
            assert re.search(rf"^  {re.escape(name)} +{re.escape(value)}$", shown.text, re.MULTILINE), name
    start = fmu.values["start"]
    assert start["nominalTorque"] > 0 and start["shuttlingEffect"] is True and start["coupling"] == "automatic", start
    assert fmu.values["files"]["modelDescription.xml"] > 1000 and fmu.values["platforms"][0].startswith("linux64")
    assert fmu.values["tables"] == {"kind": "tables", **tables.values}
    assert pair.values["gear1"]["teeth"] == 20


def test_errors_of_the_command_are_exceptions_with_its_message(tmp_path):
    with pytest.raises(gearmesh.CommandError, match="normal_module_mm"):
        gearmesh.solve(json.loads(PAIR.read_text()) | {"normal_module_mm": -4.0})
    with pytest.raises(gearmesh.GearmeshError, match="nowhere.json"):
        gearmesh.build(tmp_path / "nowhere.json", tmp_path / "out.fmu", **ALIGNED)
    with pytest.raises(gearmesh.CommandError, match="stifness"):
        gearmesh.pack(PAIR, tmp_path / "out.fmu", set={"stifness": 3.0})
    assert not (tmp_path / "out.fmu").exists()


def test_the_geometry_is_that_of_the_paper(geometry):
    """2660.4 N at 100 N m from its Table 1."""
    assert geometry.normal_force(100.0) == pytest.approx(2660.4, abs=0.1)
    assert geometry.ratio == -1.0 and sum(geometry.pitch_radii) == pytest.approx(82.104e-3)
    assert geometry.reduced_mass((math.inf, 4.213e-4)) == pytest.approx(0.25, rel=1e-3)


@pytest.mark.parametrize("misalignment", [-3e-3, -1e-6, 0.0, 2e-3])
def test_tilt_of_gear2_gives_the_misalignment_asked_for_and_none_across_the_plane(geometry, misalignment):
    alpha, beta = geometry.tilt_of_gear2(misalignment)
    difference = np.array([0.0, 0.0, 1.0]) - rotation(alpha, beta, 0.0)[:, 2]
    phi = geometry.pressure_angle
    assert [math.sin(phi), math.cos(phi), 0.0] @ difference == pytest.approx(misalignment, abs=1e-15)
    assert [math.cos(phi), -math.sin(phi), 0.0] @ difference == pytest.approx(0.0, abs=1e-15)


SWING, ZETA, INERTIAS, TORQUE = 0.002, 0.03, (3e-3, 5e-3), 100.0


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Through the resonance of two discs on a spring whose stiffness swings by a fifth of a percent."""
    unit = oscillator(tmp_path_factory.mktemp("oscillator"), SWING)
    return gearmesh.run_up(unit, INERTIAS, ZETA, TORQUE, (5000.0, 14000.0), sweep_s=2.0)


@pytest.mark.slow
def test_a_run_up_of_two_discs_is_that_of_the_linear_oscillator(run):
    """x'' + 2 zeta w x' + w^2 (1 + s cos) x = w^2 x0: for small s an amplitude of s x0 / |1 - r^2 + 2 i zeta r|."""
    base, pitch, mean = 38.4567147e-3, 41.052e-3, 4.9e8 * math.sqrt(1.0 - SWING**2)
    omega = base * math.sqrt(mean * sum(1.0 / i for i in INERTIAS))
    assert run.natural_frequency_hz == pytest.approx(omega / math.tau, rel=5e-3)
    static = 1e6 * TORQUE / base / mean * pitch / base  # um on the pitch circle
    for history in (run.up, run.down):
        found = gearmesh.orders(history, "transmission_error_um", [20], revolutions=1.0)
        ratio = found.speed_rpm / 60.0 * 20 * math.tau / omega
        expected = SWING * static / np.abs(1.0 - ratio**2 + 2j * ZETA * ratio)
        assert found.of(20) == pytest.approx(expected, abs=0.03 * expected.max())
        assert history["transmission_error_um"].mean() == pytest.approx(static, rel=5e-3)
        assert history["tangential_force_n"].mean() == pytest.approx(TORQUE / pitch, rel=2e-3)
        # Both discs are pushed by the same force: their accelerations are as one over the inertia.
        a1, a2 = (history[f"acceleration_gear{i}_rad_per_s2"] for i in (1, 2))
        assert a1 * INERTIAS[0] == pytest.approx(a2 * INERTIAS[1], abs=1e-5 * TORQUE)
    assert run.up.speed_rpm[[0, -1]] == pytest.approx([5000.0, 14000.0], rel=1e-2)
    assert run.down.speed_rpm[[0, -1]] == pytest.approx([14000.0, 5000.0], rel=1e-2)


@pytest.mark.parametrize("wrong", [{"damping": -0.1}, {"speeds": (9000.0, 4000.0)}, {"torque": 0.0}, {"inertias": (0.0, 1e-3)}])
def test_a_run_up_that_makes_no_sense_is_refused_by_name(fmus, wrong):
    arguments = {"inertias": (1e-3, 1e-3), "damping": 0.03, "torque": 100.0, "speeds": (4000.0, 9000.0)} | wrong
    with pytest.raises(gearmesh.CommandError, match=next(iter(wrong)).removesuffix("s")):
        gearmesh.run_up(fmus["external"], **arguments)


@pytest.mark.slow
def test_a_run_up_that_leaves_the_tables_says_so_and_shows_where(fmus, tmp_path):
    unit = gearmesh.build(PAIR, tmp_path / "pair.fmu", **ALIGNED)
    with pytest.warns(UserWarning, match="down: .* % of the time"):
        run = gearmesh.run_up(unit, (4e-3, 4e-3), 0.03, 195.0, (6000.0, 9000.0), sweep_s=0.1)
    assert run.down["out_of_range"].max() == 1.0
    labels = gearmesh.plot_run_up(run).get_legend_handles_labels()[1]
    assert "run-down, outside the tables" in labels
    with pytest.raises(gearmesh.GearmeshError, match="'force'.*tangential_force_n"):
        gearmesh.orders(run.up, "force", [20], revolutions=1.0)


def test_a_run_up_with_shafts_has_the_forces_of_their_bearings(fmus, tmp_path):
    shaft = {"start_mm": -80, "torque_end": "lower", "sections": [{"diameter_mm": 30, "length_mm": 200}], "bearings": [
        {"z_mm": z, "radial_stiffness_n_per_um": 300, "axial_stiffness_n_per_um": 100} for z in (-70, 100)
    ]}  # fmt: skip
    pair = pair_files()["external"]
    path = tmp_path / "on shafts.json"
    path.write_text(json.dumps(pair | {"gear2": pair["gear2"] | {"shaft": shaft}}))
    sweep = {"inertias": (4e-3, 4e-3), "damping": 0.03, "torque": 100.0, "speeds": (1000.0, 1100.0), "sweep_s": 0.02}
    run = gearmesh.run_up(fmus["external"], **sweep, shafts=path)
    forces = [run.up[f"gear2_bearing{k}_radial_force_n"].mean() for k in (1, 2)]
    # Each bears its part of the radial force, and one more, one less for the axial force.
    assert "gear1_bearing1_radial_force_n" not in run.up.signals
    whole = 100.0 / 38.4567147e-3
    assert sum(forces) == pytest.approx(whole, rel=0.05) and min(forces) > 0.2 * whole
    with pytest.raises(gearmesh.CommandError, match="no gear has a shaft on bearings"):
        gearmesh.run_up(fmus["external"], **sweep, shafts=PAIR)


@pytest.fixture(scope="module")
def chirp():
    """Orders 3 and 7.5 of a shaft that runs up evenly to 6000 rpm in a second, the second one rising with speed."""
    time = np.arange(0.0, 1.0, 2e-5)
    angle = math.pi * 100.0 * time**2
    signal = 2.0 + 3.0 * np.sin(3.0 * angle + 0.4) + 0.5 * time * np.cos(7.5 * angle)
    return History(time, angle, 6000.0 * time, {"chirp_um": signal})


def test_orders_of_a_chirp_are_its_amplitudes(chirp):
    found = gearmesh.orders(chirp, "chirp_um", [3.0, 5.0, 7.5], revolutions=2.0)
    late = found.speed_rpm > 1500.0
    assert found.of(3)[late] == pytest.approx(np.full(late.sum(), 3.0), rel=2e-3)
    assert found.of(7.5)[late] == pytest.approx(0.5 * found.time_s[late], rel=2e-2)
    assert found.of(5)[late].max() < 0.01
    assert found.level_db(1e-6)[:, 0] == pytest.approx(20.0 * np.log10(found.of(3) / 1e-6))
    down = History(chirp.time_s, chirp.angle_rad[-1] - chirp.angle_rad[::-1], chirp.speed_rpm[::-1], {"chirp_um": chirp["chirp_um"][::-1]})
    assert gearmesh.orders(down, "chirp_um", [3.0], revolutions=2.0).of(3)[:20] == pytest.approx(np.full(20, 3.0), rel=2e-3)
    with pytest.raises(gearmesh.GearmeshError, match="order 4 was not analysed"):
        found.of(4)
    for revolutions in (1000.0, 0.0):
        with pytest.raises(gearmesh.GearmeshError, match="revolutions"):
            gearmesh.orders(chirp, "chirp_um", [3.0], revolutions=revolutions)
    back = History(chirp.time_s, np.sin(chirp.angle_rad), chirp.speed_rpm, {"chirp_um": chirp["chirp_um"]})
    with pytest.raises(gearmesh.GearmeshError, match="turns back by"):
        gearmesh.orders(back, "chirp_um", [3.0], revolutions=0.1)


def test_an_order_keeps_amplitude_and_phase_beside_its_neighbour_while_the_speed_rises_by_a_quarter():
    """From 100 to 128 rad/s within a turn."""
    rise = (128.0**2 - 100.0**2) / 2.0 / math.tau
    time = np.arange(0.0, 0.056, 5e-5)
    angle = 100.0 * time + 0.5 * rise * time**2
    signal = 7.0 + 3.0 * np.cos(20.0 * angle + 1.0) + np.sin(22.0 * angle)
    history = History(time, angle, (100.0 + rise * time) * 30.0 / math.pi, {"x_um": signal})
    wanted = np.array([18.0, 20.0, 22.0, 24.0])
    _, found = _phasors(history, "x_um", wanted, 1.0)
    expected = np.array([[0.0, 3.0 * np.exp(1j), -1j, 0.0]])
    assert found.shape == expected.shape and np.abs(found - expected).max() < 1e-6
    found = gearmesh.orders(history, "x_um", wanted, revolutions=1.0)
    assert found.amplitude == pytest.approx(np.abs(expected), abs=1e-6)
    # Half of the turn is over at that speed, whatever the time.
    assert found.speed_rpm == pytest.approx([math.sqrt(0.5 * (100.0**2 + 128.0**2)) * 30.0 / math.pi], rel=1e-3)


def test_the_spectra_of_a_chirp_peak_where_its_order_is(chirp):
    found = gearmesh.campbell(chirp, "chirp_um", window_s=0.02)
    fast = found.speed_rpm > 1500.0
    peaks = found.frequency_hz[found.amplitude.argmax(axis=1)]
    assert peaks[fast] == pytest.approx(3.0 * found.speed_rpm[fast] / 60.0, abs=found.frequency_hz[1])
    # The order sweeps through a bin and a half in a window.
    assert found.amplitude.max(axis=1)[fast] == pytest.approx(np.full(fast.sum(), 3.0), rel=0.35)
    with pytest.raises(gearmesh.GearmeshError, match="window_s"):
        gearmesh.campbell(chirp, "chirp_um", window_s=2.0)
    steady = History(chirp.time_s, 100.0 * chirp.time_s, np.full(50_000, 955.0), {"x_um": 1.5 * np.sin(math.tau * 250.0 * chirp.time_s)})
    tone = gearmesh.campbell(steady, "x_um", window_s=0.04)
    assert tone.amplitude.max(axis=1) == pytest.approx(np.full(len(tone.time_s), 1.5), rel=1e-3)
    assert tone.level_db(1.5).max() == pytest.approx(0.0, abs=0.01)
    assert gearmesh.swing(steady, "x_um")[1] == pytest.approx(np.full(100, 1.5), rel=1e-3)


def test_levels_state_their_reference():
    assert gearmesh.decibels(np.array([1.0, 10.0, 0.0]), 0.1) == pytest.approx([20.0, 40.0, -math.inf])
    with pytest.raises(gearmesh.GearmeshError, match="reference = 0"):
        gearmesh.decibels(1.0, 0.0)


def test_integrate_is_of_fourth_order_and_keeps_the_books():
    def error(step):
        rows = list(gearmesh.integrate(lambda _, z: np.array([z[1], -z[0]]), np.array([1.0, 0.0]), step, round(1.0 / step), every=2,
                                       accounts=lambda _, z: [z[1]]))  # fmt: skip
        assert len(rows) == round(0.5 / step) + 1
        time, z, (way,) = rows[-1]
        assert way == pytest.approx(z[0] - 1.0, abs=1e-9)  # the integral of the rate
        return abs(z[0] - math.cos(time))

    assert math.log2(error(0.05) / error(0.025)) == pytest.approx(4.0, abs=0.1)
    z = gearmesh.runge_kutta(lambda time, _: np.array([time**3]), 1.0, np.array([0.0]), 1.0)
    assert z[0] == pytest.approx(15.0 / 4.0)


def test_poses_and_loads_go_by_virtual_power(fmus):
    rng = np.random.default_rng(5)
    q, q_t = rng.normal(size=12) * 0.3, rng.normal(size=12)
    with gearmesh.GearPair(fmus["external"], interface="model-exchange") as pair:
        place(pair, q.tolist(), q_t.tolist(), [[0.0] * 3] * 2)
        y = rng.normal(size=12)
        power = sum(y[3 * i : 3 * i + 3] @ np.array(pair.u[at : at + 3]) for i, at in enumerate((10, 13, 26, 29)))
    assert generalised(y, q) @ q_t == pytest.approx(power, rel=1e-12)
    moved = rotation(*(q + 1e-7 * q_t)[3:6]) - rotation(*(q - 1e-7 * q_t)[3:6])
    spin = moved @ rotation(*q[3:6]).T / 2e-7
    assert pair.u[13:16] == pytest.approx([spin[2, 1], spin[0, 2], spin[1, 0]], rel=1e-6)


def test_a_mesh_stores_and_loses_what_spring_and_damper_do(fmus):
    choices = {"constantStiffness": 4e8, "damping": 1e3, "dampingOnset": 1e-3, "loadedFlank": "drive"}
    with gearmesh.GearPair(fmus["external"], choices, "model-exchange") as pair:
        pair.initialize()
        gearmesh.Turning(pair)(0.0, 0.0, 2e-4, 0.1)
        approach, rate = 41.052e-3 * 2e-4, 41.052e-3 * 0.1
        assert mesh_loss(pair) == pytest.approx(1e3 * rate**2, rel=1e-9)
        assert wrench_residual(pair) < 1e-13
        assert mesh_energy(pair) == pytest.approx(0.5 * 4e8 * approach**2, rel=1e-9)
        ledger = Ledger(1.0)
        ledger.enter([pair], 1.0, 0.0, 0.0, 0.0)
        ledger.enter([pair], 1.0 + 1e-3, 0.0, 0.0, 0.0, stray=0.0)
        assert ledger.found()["energy over mesh"] == pytest.approx(1e-3 / mesh_energy(pair))


def squares(cases):
    return [{"square": case["x_um"] ** 2} for case in cases]


def test_a_sweep_goes_on_where_it_was(tmp_path):
    cases, done = grid(x_um=[1.0, 2.0, 3.0], torque_nm=[5.0, 6.0]), []
    with ThreadPoolExecutor(2) as pool:
        options = {"batch": 2, "progress": lambda *counts: done.append(counts)}
        first = sweep(squares, cases[:3], tmp_path, pool, **options)
        both = sweep(squares, cases, tmp_path, pool, **options)
        sweep(squares, cases, tmp_path, pool, **options, identity="another unit")
    # Two batches of three cases, then two of the other three, then all anew.
    assert done == [(0, 3), *done[1:3], (3, 6), *done[4:6], (0, 6), (2, 6), (4, 6), (6, 6)] and done[2] == (3, 3) and done[5] == (6, 6)
    assert first["square"].tolist() == [1.0, 1.0, 4.0] and both["square"].tolist() == [1.0, 1.0, 4.0, 4.0, 9.0, 9.0]
    assert both["torque_nm"].tolist() == [5.0, 6.0] * 3


def test_plots_show_speeds_orders_and_levels(run, tmp_path):
    found = gearmesh.orders(run.up, "tangential_force_n", [20, 40], revolutions=1.0)
    axes = gearmesh.plot_orders(found, reference=1.0)
    assert axes.get_ylabel() == "tangential force (dB re 1 N)" and len(axes.lines) == 2
    assert gearmesh.plot_orders(found).get_yscale() == "log"
    assert gearmesh.plot_run_up(run).get_ylabel() == "transmission error (µm), half of peak to peak"
    spectra = gearmesh.campbell(run.down, "tangential_force_n", window_s=0.02)
    figure = gearmesh.plot_campbell(spectra, reference=1.0).figure
    assert plots.save(figure, tmp_path / "folder" / "campbell.png").stat().st_size > 1000
    cycle = gearmesh.solve(PAIR, 100.0, positions=8, **QUICK)
    assert gearmesh.plot_cycle(cycle).lines[0].get_label() == "100 N m"


def test_plots_without_matplotlib_say_so(run, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(gearmesh.GearmeshError, match="pip install matplotlib"):
        gearmesh.plot_run_up(run)
