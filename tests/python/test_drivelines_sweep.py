"""The sweep of examples/drivelines survives a kill and computes nothing twice."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pyarrow.parquet as pq
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from examples.drivelines.files import shipped  # noqa: E402
from examples.drivelines.sweep import runs, study  # noqa: E402
from examples.drivelines.sweep.__main__ import connect  # noqa: E402

SCRIPT = """
import sys
from pathlib import Path
from tests_sweep import cases, shipped, study, connect
if __name__ == "__main__":
    fmu = shipped("fzg-c", "phaseReference=absolute").read_bytes()
    with connect(None, 1) as client:
        study.run(client, fmu, cases(), Path(sys.argv[1]), lambda done, total: None)
"""
SHARED = """
import sys
sys.path.insert(0, {root!r})
from examples.drivelines.files import shipped
from examples.drivelines.sweep import study
from examples.drivelines.sweep.__main__ import connect
def cases():
    return study.grid(speed_rpm={speeds}, torque_nm=[100.0], misalignment_mrad=[0.0], center_distance_offset_um=[0.0])
"""
SPEEDS = [2000.0 + 250.0 * i for i in range(40)]


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
    fmu = shipped("fzg-c", "phaseReference=absolute").read_bytes()
    cases = study.grid(speed_rpm=SPEEDS, torque_nm=[100.0], misalignment_mrad=[0.0], center_distance_offset_um=[0.0])
    parts = tmp_path / "parts"
    (tmp_path / "tests_sweep.py").write_text(SHARED.format(root=str(ROOT), speeds=SPEEDS))
    (tmp_path / "script.py").write_text(SCRIPT)
    process = subprocess.Popen([sys.executable, tmp_path / "script.py", parts], start_new_session=True, cwd=tmp_path)
    while not list(parts.glob("*.parquet")):
        assert process.poll() is None, "the sweep ended before its first result"
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    before = len(study.finished(parts))
    assert 0 < before < len(cases), "the kill came too late to show anything"

    seen = []
    with connect(scheduler, 0) as client:
        client.wait_for_workers(2)
        assert study.run(client, fmu, cases, parts, lambda done, total: seen.append((done, total))) == len(cases) - before
    assert seen[0] == (before, len(cases)) and seen[-1] == (len(cases), len(cases))
    study.collect(fmu, cases, parts, tmp_path / "all.parquet")
    table = pq.read_table(tmp_path / "all.parquet")
    assert table["speed_rpm"].to_pylist() == SPEEDS
    rows = [key for part in parts.glob("*.parquet") for key in pq.read_table(part)["key"].to_pylist()]
    assert len(rows) == len(set(rows)) == len(cases)


def test_cases_side_by_side_are_those_one_after_the_other():
    fmu = shipped("fzg-c", "phaseReference=absolute").read_bytes()
    cases = study.grid(speed_rpm=[4000.0, 9000.0], torque_nm=[100.0], misalignment_mrad=[1.0], center_distance_offset_um=[20.0])
    assert runs.simulate(fmu, cases) == [row for case in cases for row in runs.simulate(fmu, [case])]
