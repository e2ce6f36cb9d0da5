"""The Python package: both interfaces against one another, and its refusals."""

import copy
import gc
import logging
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import zipfile
from pathlib import Path
from concurrent.futures import ThreadPoolExecutor

import gearmesh
import numpy as np
import pytest
from conftest import PAIRS
from gearmesh import GearPair, GearPairError

MISALIGNED = {"gear2.angles[2]": 1e-4, "gear2.position[1]": 0.08206, "gear2.angles[3]": 1e-3}


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    """The paper's pair with constant stiffness, whose name no folder likes."""
    folder = tmp_path_factory.mktemp("pair")
    commented = folder / "commented.json"
    commented.write_text("// as drawn\n" + (PAIRS / "palermo2013.json").read_text(encoding="utf-8"), encoding="utf-8")
    return gearmesh.pack(commented, folder / "pair with spaces ä.fmu")


def turned(pair):
    """The pair after initialisation, gear 2 moved onto the flank."""
    pair.initialize()
    for name, value in MISALIGNED.items():
        pair[name] = value
    return pair


def test_steps_and_evaluations_give_the_same_outputs(fmu):
    with GearPair(fmu) as stepped, GearPair(fmu, interface="model-exchange") as evaluated:
        turned(stepped).step(1e-6)
        turned(evaluated).evaluate(1e-6)
        assert abs(stepped["gear2.moment[3]"]) > 10.0
        assert list(stepped.y) == list(evaluated.y)
        assert (stepped.flank, stepped.out_of_range) == (evaluated.flank, evaluated.out_of_range)
        # In any order: a solver comes back to earlier times with other inputs.
        there = list(evaluated.y)
        evaluated["gear2.angles[3]"] = 0.0
        evaluated.evaluate(5e-7)
        assert list(evaluated.y) != there
        evaluated["gear2.angles[3]"] = MISALIGNED["gear2.angles[3]"]
        evaluated.evaluate(1e-6)
        assert list(evaluated.y) == there


def test_derivatives_are_those_of_the_outputs(fmu):
    outputs, inputs = ["gear1.moment[3]", "gear2.force[2]"], ["gear1.angles[3]", "gear2.position[1]"]
    with GearPair(fmu, interface="model-exchange") as pair:
        turned(pair).evaluate(0.0)
        exact = np.array(pair.derivatives(outputs, inputs))

        def at(name, value):
            pair[name] = value
            pair.evaluate(0.0)
            return np.array([pair[o] for o in outputs])

        found = np.empty_like(exact)
        for column, name in enumerate(inputs):
            start = pair.u[pair.input[name]]
            found[:, column] = (at(name, start + 1e-9) - at(name, start - 1e-9)) / 2e-9
            pair[name] = start
    assert found == pytest.approx(exact, rel=1e-4, abs=1e-6 * abs(exact).max())


REFUSED = {
    "formulation": ("paper, conjugate", ["exact", 3, True]),
    "loadDependent": ("False, True", ["false", 2, 0.0]),
    "damping": ("a number", ["500", True, None]),
}


@pytest.mark.parametrize("name, choices, value", [(n, c, v) for n, (c, values) in REFUSED.items() for v in values])
def test_a_value_of_another_kind_is_refused_with_name_value_and_choices(fmu, name, choices, value):
    with pytest.raises(GearPairError) as refused:
        GearPair(fmu, {name: value})
    assert f"{name} = {value!r}" in str(refused.value) and choices in str(refused.value)


ACCEPTED = {
    ("formulation", "paper"): ["paper", 1],
    ("loadDependent", False): [False, 0, np.bool_(False)],
    ("damping", 500.0): [500, np.float32(500)],
}


@pytest.mark.parametrize("name, expected, value", [(*known, v) for known, values in ACCEPTED.items() for v in values])
def test_parameters_are_set_by_value_number_or_name_and_read_back(fmu, name, expected, value):
    with GearPair(fmu) as plain, GearPair(fmu, {name: value}) as pair:
        assert plain.parameters[name] != expected == pair.parameters[name]
        # As the FMU has it.
        pair.initialize()
        code = pair._scalar("Get", pair._variables[name])
        assert code == {"paper": 1, False: 0}.get(expected, expected)
        with pytest.raises(TypeError):
            pair.parameters[name] = value
        with GearPair(fmu, pair.parameters) as same:
            assert same.parameters == pair.parameters


def test_a_parameter_that_was_refused_stays_as_it_was(fmu):
    with GearPair(fmu) as pair:
        before = dict(pair.parameters)
        with pytest.raises(GearPairError, match="damping"):
            pair.set_parameter("damping", -1.0)
        assert pair.parameters == before


def test_interfaces_and_variables_that_do_not_exist_are_refused_by_name_and_what_the_unit_logs_is_in_the_exception(fmu):
    with pytest.raises(GearPairError, match="'ModelExchange'.*co-simulation, model-exchange"):
        GearPair(fmu, interface="ModelExchange")
    with pytest.raises(GearPairError, match="no parameter dampnig; did you mean damping"):
        GearPair(fmu, {"dampnig": 1.0})
    with pytest.raises(GearPairError, match=r"gear1\.position\[1\] is an input, which is written"):
        GearPair(fmu, {"gear1.position[1]": 0.0})
    with GearPair(fmu, {"stiffnessModel": "table"}) as pair, pytest.raises(GearPairError, match="stiffnessModel.*table"):
        pair.initialize()
    with GearPair(fmu) as pair, pytest.raises(GearPairError, match=r"gear1\.position\[1\]"):
        pair.initialize()
        pair["gear1.position[1]"] = float("nan")
        pair.step(1e-6)
    with GearPair(fmu) as pair:
        with pytest.raises(KeyError, match="did you mean gear1.moment"):
            pair["gear1.moment[4]"]
        with pytest.raises(KeyError, match="is an input, which is written"):
            pair["gear1.position[1]"]
        with pytest.raises(KeyError, match="is an output, which is read"):
            pair["gear1.moment[3]"] = 1.0
        with pytest.raises(KeyError, match="damping is a parameter: .* `set_parameter` sets it"):
            pair["damping"]
        with pytest.raises(KeyError, match="damping is a parameter: .* `set_parameter` sets it"):
            pair["damping"] = 500.0
        with pytest.raises(TypeError, match=r"gear1.angles\[3\] = '1': give a number"):
            pair["gear1.angles[3]"] = "1"


def test_an_exception_has_no_line_that_the_unit_logged_before(fmus):
    texts = []
    for offset in (0.0, 2e-3):  # the second is further apart than the table: a line in the log
        with GearPair(fmus["palermo2013"]) as pair:
            pair.initialize()
            pair.u[pair.input["gear2.position[1]"]] += offset
            pair.step(1e-6)
            assert pair.out_of_range == (offset > 0.0)
            pair["gear1.position[1]"] = float("nan")
            with pytest.raises(GearPairError) as refused:
                pair.step(1e-6)
            texts.append(str(refused.value))
    assert texts[0] == texts[1]


@pytest.fixture
def unpacked(tmp_path, monkeypatch):
    """The folders that archives are unpacked to."""
    gc.collect()  # pairs that tracebacks of earlier refusals still hold
    folder = tmp_path / "unpacked"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return lambda: list(folder.iterdir())


def test_instances_of_one_archive_share_its_files_until_the_last_one_closes(fmu, unpacked):
    first, second = GearPair(fmu), GearPair(fmu, interface="model-exchange")
    assert len(unpacked()) == 1
    first.close()
    assert len(unpacked()) == 1
    turned(second).evaluate(0.0)
    second.close()
    assert not unpacked()


def test_a_pair_that_nobody_closed_leaves_no_files(fmu, unpacked, tmp_path):
    pair = GearPair(fmu)
    assert unpacked()
    del pair
    gc.collect()
    assert not unpacked()
    script = f"import tempfile; tempfile.tempdir = {tempfile.tempdir!r}; from gearmesh import GearPair; pair = GearPair({str(fmu)!r})"
    subprocess.run([sys.executable, "-c", script], check=True)
    assert not unpacked()


def test_a_pair_that_was_refused_leaves_no_files(fmu, unpacked):
    for parameters in ({"damping": -1.0}, {"dampnig": 1.0}):
        with pytest.raises(GearPairError):
            GearPair(fmu, parameters)
    gc.collect()
    assert not unpacked()


def test_closing_a_pair_that_another_thread_steps_ends_the_steps_by_an_exception(fmu):
    """Where the library would be called after the instance was freed, the interpreter dies."""
    with ThreadPoolExecutor(1) as pool:
        for _ in range(20):
            pair, stepping = turned(GearPair(fmu)), threading.Event()

            def run():
                while True:
                    pair.step(1e-7)
                    stepping.set()

            steps = pool.submit(run)
            stepping.wait()
            pair.close()
            with pytest.raises(GearPairError, match="closed"):
                steps.result()


def test_after_close_every_call_is_an_exception(fmu):
    pair = turned(GearPair(fmu))
    pair.step(1e-6)
    pair.close()
    pair.close()
    calls = [
        lambda: pair.step(1e-6),
        lambda: pair.evaluate(0.0),
        pair.initialize,
        lambda: pair.derivatives(["gear1.moment[3]"], ["gear1.angles[3]"]),
        lambda: pair.set_parameter("damping", 1.0),
    ]
    for call in calls:
        with pytest.raises(GearPairError, match="closed"):
            call()
    assert abs(pair["gear2.moment[3]"]) > 10.0  # as last fetched


def test_a_pair_cannot_be_copied_nor_its_arrays_be_replaced(fmu):
    with GearPair(fmu) as pair:
        for copied in (copy.copy, copy.deepcopy):
            with pytest.raises(TypeError, match="second one"):
                copied(pair)
        for name in ("u", "y"):
            with pytest.raises(AttributeError):
                setattr(pair, name, [0.0] * 1000)


def test_an_archive_written_anew_is_another_one(fmu, tmp_path):
    file = shutil.copy2(fmu, tmp_path / "pair.fmu")
    with GearPair(file) as old:
        gearmesh.pack(PAIRS / "fzg-c.json", file)
        with GearPair(file) as new:
            assert list(new.u) != list(old.u)  # they start with gear 2 at the centre distance


class Handler(logging.Handler):
    """Hands every record to a function, and what that raises to the one who logs."""

    def __init__(self, act):
        super().__init__()
        self.act = act

    def emit(self, record):
        self.act(record)


@pytest.mark.parametrize("use", ["get", "set_parameter", "step", "close"])
def test_a_handler_of_the_logger_may_use_the_pair_that_warns(fmus, use):
    seen = []
    with GearPair(fmus["palermo2013"]) as pair:
        pair.initialize()

        def act(record):
            seen.append(record.getMessage())
            handler.act = lambda record: None
            pair[pair_input] = nominal
            {
                "get": lambda: pair["mesh.outOfRange"],
                "set_parameter": lambda: pair.set_parameter("damping", 500.0),
                "step": lambda: pair.derivatives(["gear1.moment[3]"], ["gear1.angles[3]"]),
                "close": pair.close,
            }[use]()

        pair_input = "gear2.position[1]"
        nominal = pair.u[pair.input[pair_input]]
        handler, logger = Handler(act), logging.getLogger("gearmesh")
        logger.addHandler(handler)
        try:
            pair[pair_input] = nominal + 2e-3  # further apart than the tables
            step = ThreadPoolExecutor(1).submit(pair.step, 1e-6)
            if use == "close":
                with pytest.raises(GearPairError, match="closed"):
                    step.result(timeout=60)
            else:
                step.result(timeout=60)
        finally:
            logger.removeHandler(handler)
    assert seen and "range" in seen[0]


def test_a_step_that_an_interrupt_cuts_leaves_time_and_outputs_that_belong_together(fmu, monkeypatch):
    """Before the FMU has stepped, and between that and the fetching of its outputs."""
    call = GearPair._call
    for interrupted, steps in (("fmi2SetReal", 0), ("fmi2DoStep before", 0), ("fmi2DoStep", 1), ("fmi2GetReal", 1)):
        with GearPair(fmu) as pair, GearPair(fmu) as whole:
            turned(pair).step(1e-6)
            turned(whole).step(1e-6)
            done = []

            def interrupting(self, name, *arguments):
                if self is pair and not done and name == interrupted.partition(" ")[0]:
                    done.append(name)
                    if " before" not in interrupted:
                        call(self, name, *arguments)
                    raise KeyboardInterrupt
                return call(self, name, *arguments)

            pair["gear2.angles[3]"] = whole["gear2.angles[3]"] = 1.1e-3
            monkeypatch.setattr(GearPair, "_call", interrupting)
            with pytest.raises(KeyboardInterrupt):
                pair.step(1e-6)
            assert pair.time == (1 + steps) * 1e-6
            for _ in range(2 - steps):
                pair.step(1e-6)
            for _ in range(2):
                whole.step(1e-6)
            assert (pair.time, list(pair.y)) == (whole.time, list(whole.y)), interrupted


@pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
def test_steps_go_on_after_every_real_interrupt_and_a_signal_handler_may_close_the_pair(fmu):
    with GearPair(fmu) as pair:
        turned(pair)
        stop = threading.Event()

        def interrupt():
            while not stop.wait(2e-3):
                os.kill(os.getpid(), signal.SIGINT)

        class Cut(BaseException):
            pass

        def cut(*_):
            # Once a loop: on a busy machine the next interrupt comes before this one is handled.
            nonlocal armed
            if armed:
                armed = False
                raise Cut

        armed = False
        before, count, steps = signal.signal(signal.SIGINT, cut), 0, 0
        thread = threading.Thread(target=interrupt)
        thread.start()
        try:
            while count < 100:
                try:
                    armed = True
                    while True:
                        pair.step(1e-7)
                        steps += 1
                except Cut:
                    count += 1
        finally:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            stop.set()
            thread.join()
            signal.signal(signal.SIGINT, before)
        pair.step(1e-7)
        assert steps > 100
        closed = signal.signal(signal.SIGUSR1, lambda *_: pair.close())
        try:
            with pair._lock:
                signal.raise_signal(signal.SIGUSR1)
        finally:
            signal.signal(signal.SIGUSR1, closed)
        with pytest.raises(GearPairError, match="closed"):
            pair.step(1e-7)


def no_fmus(folder, fmu):
    """Files that are no FMU of gearmesh, by what they are."""

    def archive(name, change):
        with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(folder / name, "w") as new:
            for entry in old.infolist():
                found = change(entry.filename, old.read(entry))
                if found is not None:
                    new.writestr(entry.filename, found)
        return folder / name

    whole = fmu.read_bytes()
    for name, data in {"text.fmu": b"no archive", "empty.fmu": b"", "cut.fmu": whole[: len(whole) // 2]}.items():
        (folder / name).write_bytes(data)
        yield folder / name
    middle = bytearray(whole)
    middle[200:2000] = bytes(1800)
    (folder / "damaged.fmu").write_bytes(middle)
    yield folder / "damaged.fmu"
    yield folder / "missing.fmu"
    yield folder
    for part in ("modelDescription.xml", "resources/unit.json", "binaries/"):
        yield archive(f"without-{part.strip('/').replace('/', '-')}.fmu", lambda name, data: None if name.startswith(part) else data)
    for part, data in {"modelDescription.xml": b"<x/>", "resources/unit.json": b"[1, 2]", "binaries/": b"no library"}.items():
        yield archive(f"other-{part.strip('/').replace('/', '-')}.fmu", lambda name, old: data if name.startswith(part) else old)
    with zipfile.ZipFile(folder / "bomb.fmu", "w", zipfile.ZIP_DEFLATED, compresslevel=1) as bomb:
        for i in range(5):
            with bomb.open(f"{i}", "w") as entry:
                for _ in range(240):
                    entry.write(bytes(1 << 20))
    yield folder / "bomb.fmu"


@pytest.mark.slow
def test_a_file_that_is_no_fmu_is_refused_by_name_and_leaves_no_files(fmu, tmp_path, unpacked):
    folder, here = tmp_path / "files", Path.cwd()
    folder.mkdir()
    for file in no_fmus(folder, fmu):
        with pytest.raises(GearPairError) as refused:
            GearPair(file)
        assert str(refused.value).startswith(f"{file}: ") and "gearmesh" in str(refused.value), file
        refused = None
        gc.collect()
        assert not unpacked(), file
        assert Path.cwd() == here, file
