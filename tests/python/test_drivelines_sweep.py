"""The sweep of examples/drivelines survives a kill and computes nothing twice."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT))

from examples.drivelines.files import shipped  # noqa: E402
from examples.drivelines.sweep import runs  # noqa: E402
from examples.drivelines.sweep.__main__ import connect, study  # noqa: E402
from gearmesh.sweep import finished, grid  # noqa: E402

SCRIPT = f"""
import sys
from pathlib import Path
sys.path[:0] = [{str(ROOT)!r}, {str(ROOT / "tests" / "python")!r}]
from test_drivelines_sweep import connect, speeds, study, unit
if __name__ == "__main__":
    with connect(None, 1) as client:
        study(unit(), speeds(), Path(sys.argv[1]), client)
"""


def unit():
    return shipped("fzg-c", phaseReference="absolute").read_bytes()


def speeds():
    some = [2000.0 + 250.0 * i for i in range(40)]
    return grid(speed_rpm=some, torque_nm=[100.0], misalignment_mrad=[0.0], center_distance_offset_um=[0.0])


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


def test_a_killed_sweep_goes_on_where_it_stopped_on_workers_elsewhere(tmp_path, scheduler):
    cases, parts = speeds(), tmp_path / "parts"
    (tmp_path / "script.py").write_text(SCRIPT)
    process = subprocess.Popen([sys.executable, tmp_path / "script.py", parts], start_new_session=True, cwd=tmp_path)
    while not list(parts.glob("*.json")):
        assert process.poll() is None, "the sweep ended before its first result"
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    before = len(dict(finished(parts)))
    assert 0 < before < len(cases), "the kill came too late to show anything"

    seen = []
    with connect(scheduler, 0) as client:
        client.wait_for_workers(2)
        table = study(unit(), cases, parts, client, lambda done, total: seen.append((done, total)))
    assert seen[0] == (before, len(cases)) and seen[-1] == (len(cases), len(cases))
    assert table["speed_rpm"].tolist() == [case["speed_rpm"] for case in cases]
    rows = [key for key, _ in finished(parts)]
    assert len(rows) == len(set(rows)) == len(cases)


def test_cases_side_by_side_are_those_one_after_the_other():
    cases = grid(speed_rpm=[4000.0, 9000.0], torque_nm=[100.0], misalignment_mrad=[1.0], center_distance_offset_um=[20.0])
    assert runs.simulate(unit(), cases) == [row for case in cases for row in runs.simulate(unit(), [case])]
