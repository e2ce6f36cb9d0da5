"""The command `gearmesh` from Python: FMUs, static contact and tolerance studies, as arrays with units in their names.

`pair` is a pair file or, as a mapping, what would stand in one. Keyword options are those of the command line:
`refinement="coarse"` is `--refinement coarse`, `no_center_distance=True` is `--no-center-distance`. What the command refuses is
a CommandError with its message.
"""

from __future__ import annotations

import csv
import json
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import Field, dataclass, fields
from pathlib import Path
from typing import Any, Literal, TypedDict, Unpack

import numpy as np
from numpy.typing import NDArray

from .errors import CommandError

Array = NDArray[np.float64]
Pair = str | Path | Mapping[str, Any]
Value = float | bool | str
# Of a varied field: an interval, a grid, a range for the optimizer, or a tolerance.
Interval = tuple[float, float] | tuple[float, float, int] | tuple[float, float, Literal["optimize"]] | float


class ModelOptions(TypedDict, total=False):
    """How teeth are modelled; as the pair file says where an option is left out."""

    refinement: Literal["coarse", "normal", "fine"]
    tip_corner_contact: Literal["on", "off"]
    plane_strain: bool
    stations: int
    no_cache: bool
    cache_dir: str | Path
    threads: int


class ContactOptions(ModelOptions, total=False):
    """Options of static contact: also whether the shafts on bearings of the pair file bend, which they do by default."""

    shafts: Literal["on", "off"]


class TableOptions(ModelOptions, total=False):
    """Which dimensions tables have, and how fine they are."""

    max_error: float
    no_center_distance: bool
    no_misalignment: bool
    no_body: bool
    friction: bool
    root_stress: bool
    teeth: bool
    contact: bool


@dataclass(frozen=True)
class MeshCycle:
    """One quasi-static mesh cycle under one load.

    With n positions, p tooth pairs and s stations along the face. The transmission error is the approach of unmodified
    involutes on the line of action at mid-face, positive under load. NaN stands where there is no value.

    Attributes
    ----------
    torque_nm, misalignment_mrad
        The load; the torque acts on gear 1, a misalignment > 0 closes the large-z side.
    mesh_position : (n,)
        0 with contact at the pitch point at mid-face, 1 one base pitch later.
    ste_loa_um, mean_ste_loa_um, peak_to_peak_ste_loa_um : (n,) and scalars
        Static transmission error.
    harmonics_loa_um, harmonics_phase_rad : (10,)
        Its Fourier amplitudes and phases, from the first harmonic of the mesh frequency on.
    mesh_stiffness_loa_n_per_m, mean_mesh_stiffness_loa_n_per_m : (n,) and scalar
        Tangent stiffness on the line of action; `mesh_stiffness_harmonics_*` as for the transmission error.
    contact_z_mm : (n,)
        Where the resultant crosses the pitch plane, from the z = 0 face of gear 1.
    maximum_pressure_mpa : (n,)
        Of the flanks.
    edge_line_load_n_per_mm, edge_z_mm, edge_gear : (n,)
        Largest line load at a tip edge (0 without contact there), its place, and whose edge it is.
    cycle_maximum_pressure_mpa, cycle_edge_line_load_n_per_mm, cycle_edge_z_mm, cycle_edge_gear : scalars
        The same over the mesh cycle; place and gear are None where no edge bears.
    tooth_pairs, load_share : (p,), (n, p)
        Numbers of the tooth pairs and their shares of the force.
    face_z_mm, face_load_n_per_mm, face_load_factor : (s,), (s,) and scalar
        Load along the face, mean over the cycle, and K_Hbeta.
    loss_factor, loss_factor_ohlendorf
        Share of the transmitted power that is lost at a coefficient of friction of 1, and that of Ohlendorf's formula.
    bent_teeth_mean_ste_percent, bent_teeth_peak_to_peak_ste_percent
        Change of the transmission error by contact that moves as teeth bend.
    transverse_contact_ratio, overlap_ratio, solve_seconds
        Scalars.
    notes
        What the results leave out, one sentence each.
    root_stress_mpa, root_stress_at_tangent_mpa : (2, n) or None
        Largest principal stress in the fillets of both gears, and at the 30 degree tangent, with `root_stress`.
    largest_root_stress, iso_6336_3 : [gear 1, gear 2] or None
        The largest with its place, and the nominal stress of the standard with its factors.
    speed_rpm, loss_w, efficiency, friction_coefficient : (number of speeds,) or None
        Losses at the speeds of gear 1 in `speed_rpm`.
    shaft_misalignment_mrad, shaft_bow_um, shaft_torsion_um, shaft_approach_loa_um : scalars or None
        With shafts on bearings: misalignment of the axes at mid-face under load, how much less bending closes both ends of the
        face, how much more torsion closes that of large z, and the deflection of shafts and bearings, which is not in the STE.
    shaft_closing_z_mm, shaft_closing_um : (41,) or None
        Closing of the flanks along the face over mid-face.
    bearings : list of dict or None
        Gear, number, place and load of every bearing.
    """

    torque_nm: float
    misalignment_mrad: float
    mesh_position: Array
    ste_loa_um: Array
    mean_ste_loa_um: float
    peak_to_peak_ste_loa_um: float
    harmonics_loa_um: Array
    harmonics_phase_rad: Array
    mesh_stiffness_loa_n_per_m: Array
    mean_mesh_stiffness_loa_n_per_m: float
    mesh_stiffness_harmonics_loa_n_per_m: Array
    mesh_stiffness_harmonics_phase_rad: Array
    contact_z_mm: Array
    maximum_pressure_mpa: Array
    edge_line_load_n_per_mm: Array
    edge_z_mm: Array
    edge_gear: Array
    cycle_maximum_pressure_mpa: float
    cycle_edge_line_load_n_per_mm: float
    cycle_edge_z_mm: float | None
    cycle_edge_gear: int | None
    tooth_pairs: Array
    load_share: Array
    face_z_mm: Array
    face_load_n_per_mm: Array
    face_load_factor: float
    loss_factor: float
    loss_factor_ohlendorf: float
    bent_teeth_mean_ste_percent: float
    bent_teeth_peak_to_peak_ste_percent: float
    transverse_contact_ratio: float
    overlap_ratio: float
    solve_seconds: float
    notes: list[str]
    root_stress_mpa: Array | None = None
    root_stress_at_tangent_mpa: Array | None = None
    largest_root_stress: list[dict[str, Any] | None] | None = None
    iso_6336_3: list[dict[str, Any] | None] | None = None
    speed_rpm: Array | None = None
    loss_w: Array | None = None
    efficiency: Array | None = None
    friction_coefficient: Array | None = None
    shaft_misalignment_mrad: float | None = None
    shaft_bow_um: float | None = None
    shaft_torsion_um: float | None = None
    shaft_approach_loa_um: float | None = None
    shaft_closing_z_mm: Array | None = None
    shaft_closing_um: Array | None = None
    bearings: list[dict[str, Any]] | None = None


@dataclass(frozen=True)
class Statistics:
    """What the samples of a study say about one result at one torque, in its unit; correlations by varied field, -1 to 1.

    `point` is 0 for the pair as drawn, otherwise the best point of a grid.

    `correlation_of_distance` is that with how far each field is from its value as drawn: what acts alike in both
    directions shows there alone.
    """

    point: int
    torque_nm: float
    result: str
    nominal: float
    mean: float
    least: float
    percentile_5: float
    median: float
    percentile_95: float
    largest: float
    correlation: dict[str, float]
    correlation_of_distance: dict[str, float]


@dataclass(frozen=True)
class StudyResult:
    """Samples of a pair within its tolerances.

    Attributes
    ----------
    samples : dict of (rows,)
        Varied fields and results by name, with the units of the names; the first rows are the pair as drawn, one for
        each torque. NaN where a sample was refused.
    violates : list of str
        Requirements that a sample violates, with semicolons between them, row by row.
    errors : list of str
        Why a sample was refused, or an empty text, row by row.
    statistics : list of Statistics
        By point, torque and result.
    best : dict or None
        Of a grid or the optimizer the point whose measure is least: `point`, `measure` (in words), its `value`, that of the pair
        `as_drawn`, and the `fields`. The folder holds it as the pair file best.json.
    notes
        What the results leave out, one sentence each.
    """

    samples: dict[str, Array]
    violates: list[str]
    errors: list[str]
    statistics: list[Statistics]
    best: dict[str, Any] | None
    notes: list[str]


@dataclass(frozen=True)
class Inspection:
    """What a file holds.

    `kind` is "pair", "tables" or "fmu"; `text` is what `gearmesh inspect` prints. `values` has

    * of a pair file its fields with the quantities of a drawing;
    * of tables the `name` and the `listing`: rows of the text by their names;
    * of an FMU the `name`, `platforms`, `step_size_s`, the `start` values (numbers in SI units, truth values, names of items), the
      sizes of its `files` in bytes, the `listing`, and its `tables` as above or None.
    """

    kind: Literal["pair", "tables", "fmu"]
    values: dict[str, Any]
    text: str


def executable() -> Path:
    """The command: where pip put it beside this Python, in target/release of the sources, or on PATH.

    Raises
    ------
    CommandError
        There is none.
    """
    name = "gearmesh.exe" if sys.platform == "win32" else "gearmesh"
    beside = Path(sysconfig.get_path("scripts"), name), Path(__file__).parents[2] / "target" / "release" / name
    found = next((path for path in beside if path.is_file()), None) or shutil.which(name)
    if not found:
        raise CommandError(f"the command {name} is neither beside the package nor on PATH: install the wheel, or `make build`")
    return Path(found)


def run(*arguments: object) -> str:
    """Runs the command and returns what it prints.

    Parameters
    ----------
    *arguments
        As on the command line, such as `"solve", "pair.json", "--json"`.

    Raises
    ------
    CommandError
        The command failed; with its message, which names field, value and remedy.
    """
    done = subprocess.run([executable(), *map(str, arguments)], capture_output=True, encoding="utf-8")
    if done.returncode != 0:
        message = done.stderr.strip().removeprefix("gearmesh: error: ")
        raise CommandError(message or f"gearmesh {arguments[0]} ended with status {done.returncode}")
    return done.stdout


def build(pair: Pair, out: str | Path, *, set: Mapping[str, Value] | None = None, **options: Unpack[TableOptions]) -> Path:
    """Computes the tables of a pair and packs them into an FMU.

    Parameters
    ----------
    pair
        Pair file or its content.
    out
        FMU to write.
    set
        Start values of parameters and inputs by name, SI, such as `{"damping": 500.0, "interpolation": "shepard"}`.
    **options
        Of the tables and of the model: `TableOptions`.

    Returns
    -------
    Path
        Of the FMU.
    """
    with _file(pair) as file:
        run("build", file, "-o", out, "-q", *settings(set), *_options(options))
    return Path(out)


def pack(source: Pair, out: str | Path, *, set: Mapping[str, Value] | None = None) -> Path:
    """Packs tables, or a pair with constant stiffness, into an FMU.

    Parameters
    ----------
    source
        Tables that the command wrote; or a pair file or its content, for an FMU without tables.
    out, set
        As in `build`.

    Returns
    -------
    Path
        Of the FMU.
    """
    with _file(source) as file:
        kind = "--tables" if _inspected(file).get("kind") == "tables" else "--pair"
        run("pack", kind, file, "-o", out, *settings(set))
    return Path(out)


def solve(
    pair: Pair,
    torque_nm: float | None = None,
    misalignment_mrad: float = 0.0,
    *,
    positions: int | None = None,
    center_distance_offset_um: float = 0.0,
    flank: Literal["drive", "coast"] = "drive",
    root_stress: bool = False,
    speed_rpm: Sequence[float] = (),
    **options: Unpack[ContactOptions],
) -> MeshCycle:
    """Solves the static contact over a mesh cycle.

    Parameters
    ----------
    pair
        Pair file or its content.
    torque_nm
        On gear 1, > 0 on either flank; the pair's nominal torque where it is left out.
    misalignment_mrad
        In the plane of action; > 0 closes the large-z side.
    positions
        Number of positions over the cycle.
    center_distance_offset_um
        Actual minus nominal centre distance.
    flank
        Of gear 1: drive, in contact when gear 1 turns in its + sense and drives, or coast.
    root_stress
        Stress in the fillets, too.
    speed_rpm
        Speeds of gear 1 at which losses are wanted.
    **options
        Of the model: `ContactOptions`.

    Returns
    -------
    MeshCycle

    Raises
    ------
    TypeError
        Several loads or misalignments: `solve_all` takes them.
    """
    for name, value in (("torque_nm", torque_nm), ("misalignment_mrad", misalignment_mrad)):
        if np.ndim(value) > 0:
            raise TypeError(f"{name} = {value!r}: give one number; `solve_all` takes several loads")
    torques = [] if torque_nm is None else [torque_nm]
    more = {"positions": positions, "center_distance_offset_um": center_distance_offset_um, "flank": flank, "root_stress": root_stress}
    return _solve(pair, torques, [misalignment_mrad], {**more, "speed_rpm": speed_rpm, **options})[0]


def solve_all(
    pair: Pair, torques_nm: Sequence[float], misalignments_mrad: Sequence[float] = (0.0,), **options: Any
) -> list[MeshCycle]:
    """Solves a cycle for every torque with every misalignment, on one elastic model.

    Parameters
    ----------
    pair, torques_nm, misalignments_mrad
        As in `solve`, several of each.
    **options
        Of `solve`.

    Returns
    -------
    list of MeshCycle
        The misalignments of the first torque, then those of the next.
    """
    return _solve(pair, torques_nm, misalignments_mrad, options)


def _solve(pair: Pair, torques: Sequence[float], misalignments: Sequence[float], options: Mapping[str, Any]) -> list[MeshCycle]:
    loads = {"torque_nm": torques, "misalignment_mrad": misalignments}
    with _file(pair) as file:
        found = json.loads(run("solve", file, "--json", "-q", *_options({**loads, **options})))
    cases = found.get("cases", [found])
    return [MeshCycle(**{f.name: _value(f, case[f.name]) for f in fields(MeshCycle) if f.name in case}) for case in cases]


def study(
    pair: Pair,
    output: str | Path,
    vary: Mapping[str, Interval],
    *,
    iso_1328_class: int | None = None,
    samples: int | None = None,
    seed: int = 1,
    torques_nm: Sequence[float] | None = None,
    best: str | None = None,
    weights: Sequence[float] | None = None,
    judged_by: Literal["drawn", "mean", "worst"] | None = None,
    require: Sequence[str] = (),
    points: int | None = None,
    positions: int | None = None,
    root_stress: bool = False,
    restart: bool = False,
    **options: Unpack[ContactOptions],
) -> StudyResult:
    """Draws samples of a pair within its tolerances and solves the mesh cycle of each.

    A study that was stopped goes on where it was.

    Parameters
    ----------
    pair
        Pair file or its content.
    output
        Folder for samples.csv, study.json and study.html.
    vary
        By field of the pair file (`gear1.tip_relief.amount_um`), or `torque_nm`, `misalignment_mrad`,
        `center_distance_offset_um`: the interval (low, high), the tolerance about the value in the file, the grid
        (low, high, points), or the range (low, high, "optimize") for the optimizer. Fields joined by commas share a value.
    iso_1328_class
        Draws the slopes of profile and helix of both gears within this class, 1 to 11, too.
    samples, seed
        Number of samples (500; on a grid 20 for each point); another seed draws others.
    torques_nm
        On gear 1; the nominal torque if None.
    best, weights, judged_by
        Of a grid or the optimizer: the result that shall be least (a column of samples.csv), the weights of the torques in
        its mean, and which samples of a point count.
    require
        Results with their limits, such as "maximum_pressure_mpa<1200"; that no point meets them is a `CommandError`.
    points
        Most points that the optimizer tries.
    positions, root_stress
        As in `solve`.
    restart
        Leaves out what the folder holds of an earlier run.
    **options
        Of the model: `ContactOptions`.

    Returns
    -------
    StudyResult
    """
    intervals = [f"--vary={name}={_interval(interval)}" for name, interval in vary.items()]
    more = {"iso_1328_class": iso_1328_class, "samples": samples, "seed": seed, "torques_nm": torques_nm}
    more |= {"best": best, "weights": weights, "judged_by": judged_by, "points": points}
    limits = [f"--require={limit}" for limit in require]
    more |= {"positions": positions, "root_stress": root_stress, "restart": restart}
    with _file(pair) as file:
        run("study", file, "-o", output, "-q", *intervals, *limits, *_options({**more, **options}))
    summary = json.loads(Path(output, "study.json").read_text(encoding="utf-8"))
    with open(Path(output, "samples.csv"), encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    # Several fields may share a variation; correlations are by field.
    varied = summary["fields"]
    statistics = []
    for row in summary["statistics"]:
        correlations = {key: dict(zip(varied, row[key], strict=True)) for key in ("correlation", "correlation_of_distance")}
        statistics.append(Statistics(**{**row, **correlations}))
    columns = [name for name in rows[0] if name not in ("sample", "violates", "error")]
    numbers = {name: np.array([float(row[name] or "nan") for row in rows]) for name in columns}
    words = [[row[name] or "" for row in rows] for name in ("violates", "error")]
    return StudyResult(numbers, *words, statistics, summary["best"], summary["notes"])


def inspect(file: str | Path) -> Inspection:
    """Shows what is in a pair file, in tables or in an FMU.

    Parameters
    ----------
    file
        One that the command reads or writes.

    Returns
    -------
    Inspection
    """
    values = _inspected(file)
    return Inspection(values.pop("kind", "pair"), values, run("inspect", file))


def _inspected(file: str | Path) -> dict[str, Any]:
    return json.loads(run("inspect", file, "--json"))


@contextmanager
def _file(pair: Pair) -> Iterator[str | Path]:
    """The pair as a file."""
    if not isinstance(pair, Mapping):
        yield pair
        return
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "pair.json")
        file.write_text(json.dumps(pair), encoding="utf-8")
        yield file


def _options(options: Mapping[str, Any]) -> list[str]:
    """As on the command line; what is None, False or empty is left out."""
    out = []
    for name, value in options.items():
        option = f"--{name.replace('_', '-')}"
        if value is True:
            out.append(option)
        elif isinstance(value, Sequence) and not isinstance(value, str):
            out += [f"{option}={','.join(map(repr, map(float, value)))}"] if len(value) else []
        elif value is not None and value is not False:
            out.append(f"{option}={value}")
    return out


def settings(values: Mapping[str, Value] | None) -> list[str]:
    """Parameters of an FMU as on the command line."""
    return [f"--set={name}={str(value).lower() if isinstance(value, bool) else value}" for name, value in (values or {}).items()]


def _interval(interval: Interval) -> str:
    if isinstance(interval, (int, float)):
        return f"+-{interval}"
    points = "/".join(map(str, interval[2:]))
    return "..".join(map(str, interval[:2])) + (points and f"/{points}")


def _value(field: Field[Any], value: Any) -> Any:
    """A list of numbers as an array; NaN for null where a number stands otherwise."""
    if value is None and field.type == "float":
        return float("nan")
    plain = not isinstance(value, list) or field.name in ("notes", "largest_root_stress", "iso_6336_3", "bearings")
    return value if plain else np.array(value, dtype=float)
