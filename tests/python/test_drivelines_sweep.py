"""The sweep of examples/drivelines survives a kill and computes nothing twice."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest
from conftest import ROOT
from examples.drivelines.sweep import runs
from examples.drivelines.sweep.__main__ import cases, connect, study
from examples.shared.files import shipped
from gearmesh.sweep import finished

SCRIPT = f"""
import sys
from pathlib import Path
sys.path[:0] = [{str(ROOT)!r}, {str(ROOT / "tests" / "python")!r}]
from test_drivelines_sweep import cases, connect, study, unit
if __name__ == "__main__":
    with connect(sys.argv[1], 0) as client:
        study(unit(), cases(4), Path(sys.argv[2]), client, batch=1)
"""


def unit():
    return shipped("fzg-c", phaseReference="absolute").read_bytes()


@pytest.fixture
def scheduler(tmp_path):
    """Address of a scheduler with two workers, processes that were started where nothing of the repository is importable."""
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    file = folder / "scheduler.json"
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}

    def start(program, *options):
        command = [sys.executable, "-m", f"distributed.cli.dask_{program}", "--scheduler-file", file, *options]
        return subprocess.Popen(command, cwd=folder, env=environment, stderr=subprocess.DEVNULL)

    processes = [start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")]
    try:
        processes += [start("worker", "--nthreads", "1", "--no-nanny", "--no-dashboard") for _ in range(2)]
        while not file.exists():
            assert processes[0].poll() is None, "the scheduler ended"
            time.sleep(0.05)
        yield json.loads(file.read_text())["address"]
    finally:
        for process in processes:
            process.kill()
            process.wait()


def test_a_killed_sweep_goes_on_where_it_stopped_on_workers_elsewhere_bit_equal(tmp_path, scheduler):
    some, parts = cases(4), tmp_path / "parts"
    (tmp_path / "script.py").write_text(SCRIPT)
    process = subprocess.Popen([sys.executable, tmp_path / "script.py", scheduler, parts], start_new_session=True, cwd=tmp_path)
    while not list(parts.glob("*.json")):
        assert process.poll() is None, "the sweep ended before its first result"
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    before = len(dict(finished(parts)))
    assert 0 < before < len(some), "the kill came too late to show anything"

    seen = []
    with connect(scheduler, 0) as client:
        client.wait_for_workers(2)
        table = study(unit(), some, parts, client, progress=lambda done, total: seen.append((done, total)))
    assert seen[0] == (before, len(some)) and seen[-1] == (len(some), len(some))
    keys = [key for key, _ in finished(parts)]
    assert len(keys) == len(set(keys)) == len(some)
    at_a_stretch = runs.simulate(unit(), some)
    rows = [case | result for case, result in zip(some, at_a_stretch)]
    assert {name: column.tolist() for name, column in table.items()} == {name: [row[name] for row in rows] for name in table}


def test_run_up_and_run_down_keep_their_own_answers():
    case = {"torque_nm": 200.0, "misalignment_mrad": 0.0, "center_distance_offset_um": 0.0, "speeds": 9}
    below, above = runs.simulate(unit(), [case | {"first_rpm": a, "last_rpm": b} for a, b in ((8000.0, 12000.0), (12000.0, 8000.0))])
    assert below["speed_rpm"] == above["speed_rpm"][::-1]
    factor = dict(zip(below["speed_rpm"], zip(below["dynamic_factor"], above["dynamic_factor"][::-1])))
    assert factor[9000.0][1] > 2.0 * factor[9000.0][0]
    assert factor[11500.0][1] == pytest.approx(factor[11500.0][0], rel=0.02)
