"""Systems of FMUs in one file, by System Structure and Parameterization 1.0, as Ecos, libcosim and other masters run them."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription version="1.0" name="system" xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
  xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon">
"""


def write(file: str | Path, units: Mapping[str, str | Path], connections: Sequence[tuple[str, str, str, str]] = ()) -> Path:
    """Writes an SSP.

    Parameters
    ----------
    file
        Of the SSP, such as gearbox.ssp.
    units
        FMUs by the names of their components.
    connections
        Component and Real output, then component and Real input.

    Returns
    -------
    Path
        Of the SSP.
    """
    ends = {("output", unit, variable) for unit, variable, _, _ in connections} | {("input", unit, variable) for _, _, unit, variable in connections}
    components = []
    for unit in units:
        connectors = [
            f"<ssd:Connector name={quoteattr(variable)} kind={quoteattr(kind)}><ssc:Real/></ssd:Connector>"
            for kind, owner, variable in sorted(ends)
            if owner == unit
        ]
        source = quoteattr(f"resources/{unit}.fmu")
        inside = f"<ssd:Connectors>{''.join(connectors)}</ssd:Connectors>" if connectors else ""
        components.append(f'<ssd:Component name={quoteattr(unit)} type="application/x-fmu-sharedlibrary" source={source}>{inside}</ssd:Component>')
    names = ("startElement", "startConnector", "endElement", "endConnector")
    wires = ["<ssd:Connection " + " ".join(f"{name}={quoteattr(end)}" for name, end in zip(names, wire)) + "/>" for wire in connections]
    parts = ["<ssd:Elements>", *components, "</ssd:Elements>"] + (["<ssd:Connections>", *wires, "</ssd:Connections>"] if wires else [])
    text = "\n".join(['<ssd:System name="system">', *parts, "</ssd:System>", '<ssd:DefaultExperiment startTime="0"/>'])
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("SystemStructure.ssd", f"{HEAD}{text}\n</ssd:SystemStructureDescription>\n")
        for unit, fmu in units.items():
            archive.write(fmu, f"resources/{unit}.fmu")
    return Path(file)
