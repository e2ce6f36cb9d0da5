"""Static contact, FMUs (FMI 2.0) and dynamics of gear pairs from Python, as arrays with the units in their names.

    import gearmesh

    cycle = gearmesh.solve("pair.json", torque_nm=120.0, refinement="coarse")  # one mesh cycle
    print(cycle.peak_to_peak_ste_loa_um, cycle.maximum_pressure_mpa.max())
    unit = gearmesh.build("pair.json", "pair.fmu", refinement="coarse")
    # Two discs of 4e-3 kg m^2 under 120 N m, 3 % damping: up and down through resonance.
    run = gearmesh.run_up(unit, (4e-3, 4e-3), 0.03, 120.0, (8000.0, 13000.0))
    found = gearmesh.orders(run.up, "tangential_force_n", [23, 46], revolutions=1)
    print(found.of(23).max(), found.level_db(reference=1.0).max())

`build`, `pack`, `solve`, `solve_all`, `study` and `inspect` run the command `gearmesh`; its errors are `CommandError`. `plot_cycle`,
`plot_run_up`, `plot_orders` and `plot_campbell` need matplotlib. An FMU in a loop of your own:

    from gearmesh import GearPair

    with GearPair("pair.fmu", {"interpolation": "shepard", "damping": 500.0}) as pair:
        pair.initialize()
        pair["gear2.angles[3]"] = 1e-4
        pair.step(5e-7)
        moment = pair["gear2.moment[3]"]

For assemblies there are `integrate` and `cosimulate`, `gearmesh.poses`, `gearmesh.energy`, `gearmesh.exudyn`, `gearmesh.ssp` and `gearmesh.sweep`.
"""

from .analysis import Campbell, Orders, campbell, decibels, orders, swing
from .command import Inspection, MeshCycle, Statistics, StudyResult, build, inspect, pack, solve, solve_all, study
from .dynamics import History, Turning, cosimulate, integrate, runge_kutta
from .errors import CommandError, GearmeshError, GearPairError
from .geometry import Geometry
from .pair import GearPair
from .plots import plot_campbell, plot_cycle, plot_orders, plot_run_up
from .speed_sweep import RunUp, run_up

__version__ = "0.2.0"
__all__ = [
    "Campbell", "CommandError", "GearPair", "GearPairError", "GearmeshError", "Geometry", "History", "Inspection", "MeshCycle", "Orders",
    "RunUp", "Statistics", "StudyResult", "Turning", "build", "campbell", "cosimulate", "decibels", "inspect", "integrate", "orders", "pack",
    "plot_campbell", "plot_cycle", "plot_orders", "plot_run_up", "run_up", "runge_kutta", "solve", "solve_all", "study", "swing",
]  # fmt: skip
