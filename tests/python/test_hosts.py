"""The examples of other hosts, on a short form of their scenario; `python -m examples.hosts` runs the whole."""

import sys

import gearmesh
import pytest
from conftest import ROOT, TABLES

sys.path.insert(0, str(ROOT))

from examples.hosts.compare import HOSTS, run  # noqa: E402
from examples.hosts.scenario import revolution  # noqa: E402


@pytest.fixture(scope="module")
def unit(tmp_path_factory):
    fmu = gearmesh.pack(TABLES / "palermo2013.json", tmp_path_factory.mktemp("hosts") / "palermo2013.fmu", set={"coupling": "held"})
    return fmu, revolution(fmu, 100.0, revolutions=1 / 16, steps=64)


@pytest.mark.parametrize("host", HOSTS)
def test_every_host_finds_the_same_outputs(unit, host):
    try:
        results = run(host, *unit)
    except ImportError as error:
        pytest.skip(f"not installed here: {error}")
    assert results
    for result in results:
        assert result.difference < 1e-12, result
