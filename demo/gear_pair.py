"""One instance of a GearMesh unit, driven through fmpy and ctypes.

fmpy's own setters build new arrays at every call, which costs tens of microseconds. This class
keeps one array for all inputs and one for all outputs, so a step costs three calls into the library:

    pair = GearPair("pair.fmu", {"loadDependent": True, "damping": 1e5})
    pair.initialize()
    spin = pair.input["gear2.angles[3]"]
    pair.u[spin] = 1e-4
    pair.step(1e-5)
    moment = pair.y[pair.output["gear2.moment[3]"]]
"""

from __future__ import annotations

import ctypes
import shutil
from collections.abc import Mapping
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave

BODIES = ("gear1", "gear2", "carrier")
# Scalar diagnostics that are continuous; `mesh.flank` and `mesh.outOfRange` are discrete.
DIAGNOSTICS = (
    "transmissionError",
    "transmissionErrorRate",
    "position",
    "centerDistance",
    "misalignment",
    "tangentialForce",
    "normalForce",
    "stiffness",
    "contactZ",
)


class GearPairError(RuntimeError):
    """A call into the unit did not return fmi2OK."""


class GearPair:
    """A co-simulation instance with preallocated blocks of inputs `u` and outputs `y`.

    `input` and `output` map a variable's name to its index in `u` and `y`. Everything is in SI units
    and in the world frame. The protocol of a step is Set, DoStep, Get: after `step`, `y` holds the
    outputs that belong to `u`.
    """

    def __init__(self, fmu: str | Path, parameters: Mapping[str, object] | None = None):
        self._folder = fmpy.extract(str(fmu))
        self._slave = None
        try:
            self.description = fmpy.read_model_description(str(fmu))
            self._variables = {v.name: v for v in self.description.modelVariables}
            self._slave = FMU2Slave(
                guid=self.description.guid,
                unzipDirectory=self._folder,
                modelIdentifier=self.description.coSimulation.modelIdentifier,
                instanceName=Path(fmu).stem,
            )
            self._slave.instantiate()
        except Exception:
            self.close()
            raise
        self.time = 0.0
        self._bind()
        for name, value in (parameters or {}).items():
            self.set_parameter(name, value)

    def _bind(self) -> None:
        """Prepares the arrays and the three calls of a step."""
        inputs = [v for v in self.description.modelVariables if v.causality == "input"]
        outputs = [
            f"{gear}.{quantity}[{i}]"
            for gear in BODIES[:2]
            for quantity in ("force", "moment")
            for i in (1, 2, 3)
        ]
        outputs += [f"contact.point[{i}]" for i in (1, 2, 3)]
        outputs += [f"mesh.{name}" for name in DIAGNOSTICS]
        self.input = {v.name: i for i, v in enumerate(inputs)}
        self.output = {name: i for i, name in enumerate(outputs)}

        self._input_references = self._references(self.input)
        self._output_references = self._references(self.output)
        self.u = (ctypes.c_double * len(inputs))(*(float(v.start) for v in inputs))
        self.y = (ctypes.c_double * len(outputs))()

        library, self._component = self._slave.dll, self._slave.component
        block = [
            ctypes.c_void_p,
            ctypes.POINTER(ctypes.c_uint),
            ctypes.c_size_t,
            ctypes.POINTER(ctypes.c_double),
        ]
        # library[name] gives a function object of our own: fmpy's keeps its own argument types.
        self._set_real, self._get_real = library["fmi2SetReal"], library["fmi2GetReal"]
        self._set_real.argtypes = self._get_real.argtypes = block
        self._do_step = library["fmi2DoStep"]
        self._do_step.argtypes = [
            ctypes.c_void_p,
            ctypes.c_double,
            ctypes.c_double,
            ctypes.c_int,
        ]

    def _references(self, names) -> ctypes.Array:
        references = [self._variables[name].valueReference for name in names]
        return (ctypes.c_uint * len(references))(*references)

    def set_parameter(self, name: str, value: object) -> None:
        """Sets a parameter by name; an enumeration by the name of its item."""
        variable = self._variables[name]
        reference = [variable.valueReference]
        if variable.type == "Enumeration":
            items = {item.name: int(item.value) for item in variable.declaredType.items}
            if value not in items:
                raise GearPairError(f"{name} = {value!r}: choose one of {', '.join(items)}")
            self._slave.setInteger(reference, [items[value]])
        elif variable.type == "Boolean":
            self._slave.setBoolean(reference, [bool(value)])
        else:
            self._slave.setReal(reference, [float(value)])

    def initialize(self, start_time: float = 0.0) -> None:
        """Takes the pose in `u` as the start, latches the phase there and fills `y`."""
        self.time = start_time
        self._slave.setupExperiment(startTime=start_time)
        self._slave.enterInitializationMode()
        self._send()
        self._slave.exitInitializationMode()
        self._receive()

    def step(self, size: float) -> None:
        """Hands over `u`, makes one communication step of `size` seconds and fetches `y`."""
        self._send()
        status = self._do_step(self._component, self.time, size, 1)
        if status != 0:
            raise GearPairError(f"fmi2DoStep at t = {self.time} s returned status {status}")
        self.time += size
        self._receive()

    def _send(self) -> None:
        status = self._set_real(self._component, self._input_references, len(self.u), self.u)
        if status != 0:
            raise GearPairError(f"fmi2SetReal at t = {self.time} s returned status {status}")

    def _receive(self) -> None:
        status = self._get_real(self._component, self._output_references, len(self.y), self.y)
        if status != 0:
            raise GearPairError(f"fmi2GetReal at t = {self.time} s returned status {status}")

    def __getitem__(self, output: str) -> float:
        """An output by name, as fetched by the last step."""
        return self.y[self.output[output]]

    def __setitem__(self, name: str, value: float) -> None:
        """Writes an input by name; the next step hands it over."""
        self.u[self.input[name]] = value

    @property
    def out_of_range(self) -> bool:
        """Whether the last operating point lay outside the table."""
        reference = [self._variables["mesh.outOfRange"].valueReference]
        return bool(self._slave.getBoolean(reference)[0])

    def close(self) -> None:
        """Terminates the instance and removes the unpacked archive."""
        if self._slave is not None:
            try:
                self._slave.terminate()
            except Exception:  # never initialised, or already in error: free it all the same
                pass
            self._slave.freeInstance()
            self._slave = None
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None

    def __enter__(self) -> GearPair:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
