"""One instance of a gearmesh unit, driven through fmpy and ctypes."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import fmpy
from fmpy.fmi2 import FMU2Model, FMU2Slave, fmi2CallbackFunctions

from .unpacked import Unpacked

OK = 0
# The unit always logs with the format "%s" and one text.
TEXT = ctypes.c_char_p
LOGGER = ctypes.CFUNCTYPE(None, ctypes.c_void_p, TEXT, ctypes.c_int, TEXT, TEXT, TEXT)


class GearPairError(RuntimeError):
    """The unit refused a call; the text is what it logged."""


class GearPair:
    """An instance of a packed unit with one array of inputs and one of outputs.

    `fmu` is the file that `gearmesh build` wrote. `parameters` are set by name before initialisation: numbers, booleans,
    and enumerations by the name of their item (`{"interpolation": "shepard"}`). Everything is in SI units and in the world
    frame; documentation/index.html of the FMU describes each variable.

    `u` and `y` hold the continuous inputs and outputs in the order of modelDescription.xml; `input` and `output` map
    a variable's name to its index there. In a loop, look indices up once and use `u` and `y`; elsewhere `pair[name]`
    reads an output and `pair[name] = value` writes an input. fmpy's own setters build new arrays at every call, which
    costs tens of microseconds; here a step costs three calls into the library, about 2 us beyond the element.

    Co-simulation advances by `step`. Model Exchange, for solvers that want the force at every stage, evaluates at any
    time and in any order by `evaluate`; the unit has no states of its own.
    """

    #: Inputs to be handed over, in SI units.
    u: ctypes.Array[ctypes.c_double]
    #: Outputs as last fetched, in SI units.
    y: ctypes.Array[ctypes.c_double]
    #: Index in `u` by the input's name.
    input: dict[str, int]
    #: Index in `y` by the output's name; the discrete `mesh.flank` and `mesh.outOfRange` are properties.
    output: dict[str, int]
    #: Of the last call, in s.
    time: float

    def __init__(
        self,
        fmu: str | Path,
        parameters: Mapping[str, float | bool | str] | None = None,
        interface: Literal["co-simulation", "model-exchange"] = "co-simulation",
    ) -> None:
        self._instance: Any = None  # of fmpy, which has no types
        self._log: list[str] = []
        self._unpacked: Unpacked | None = Unpacked.of(fmu)
        try:
            self._description = self._unpacked.description
            self._variables = {v.name: v for v in self._description.modelVariables}
            self._exchange = interface == "model-exchange"
            kind = FMU2Model if self._exchange else FMU2Slave
            instance = kind(
                guid=self._description.guid,
                unzipDirectory=self._unpacked.folder,
                modelIdentifier=self._description.coSimulation.modelIdentifier,
                instanceName=Path(fmu).stem,
            )
            # fmpy's own callbacks print; these keep the text for the exception. The unit needs no other callback.
            self._callbacks = fmi2CallbackFunctions()
            self._logger = LOGGER(self._logged)
            self._callbacks.logger = ctypes.cast(self._logger, type(self._callbacks.logger))
            try:
                instance.instantiate(callbacks=self._callbacks, loggingOn=True)
            except Exception as error:
                fmpy.freeLibrary(instance.dll._handle)
                raise self._error(str(error)) from error
            self._instance = instance
            self._bind()
            for name, value in (parameters or {}).items():
                self.set_parameter(name, value)
        except BaseException:
            self.close()
            raise
        self.time = 0.0

    def _logged(self, *arguments: Any) -> None:
        text: bytes = arguments[-1]
        self._log = [*self._log[-7:], text.decode(errors="replace")]

    def _error(self, call: str) -> GearPairError:
        texts, self._log = self._log, []
        return GearPairError(f"{call}: {'; '.join(texts)}" if texts else call)

    def _bind(self) -> None:
        """Prepares the arrays and the calls of a step."""
        continuous = [v for v in self._description.modelVariables if v.variability == "continuous"]
        inputs = [v for v in continuous if v.causality == "input"]
        outputs = [v for v in continuous if v.causality == "output"]
        self.input = {v.name: i for i, v in enumerate(inputs)}
        self.output = {v.name: i for i, v in enumerate(outputs)}
        self.u = (ctypes.c_double * len(inputs))(*(float(v.start) for v in inputs))
        self.y = (ctypes.c_double * len(outputs))()
        self._input_references = self._references(self.input)
        self._output_references = self._references(self.output)

        library = self._instance.dll
        reference, real = ctypes.POINTER(ctypes.c_uint), ctypes.POINTER(ctypes.c_double)
        block = [ctypes.c_void_p, reference, ctypes.c_size_t, real]
        # library[name] gives a function object of our own: fmpy's keeps its own argument types.
        self._set_real, self._get_real = library["fmi2SetReal"], library["fmi2GetReal"]
        self._set_real.argtypes = self._get_real.argtypes = block
        self._do_step, self._set_time = library["fmi2DoStep"], library["fmi2SetTime"]
        self._do_step.argtypes = [ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int]
        self._set_time.argtypes = [ctypes.c_void_p, ctypes.c_double]
        self._derivative = library["fmi2GetDirectionalDerivative"]
        self._derivative.argtypes = [
            ctypes.c_void_p,
            *(reference, ctypes.c_size_t) * 2,
            *(real,) * 2,
        ]

    def _references(self, names: Iterable[str]) -> ctypes.Array[ctypes.c_uint]:
        references = [self._variables[name].valueReference for name in names]
        return (ctypes.c_uint * len(references))(*references)

    def _call(self, function: Any, *arguments: object) -> None:
        if function(self._instance.component, *arguments) != OK:
            raise self._error(f"{function.__name__} at t = {self.time} s")

    def set_parameter(self, name: str, value: float | bool | str) -> None:
        """Sets a parameter by name, an enumeration by the name of its item; in SI units.

        Before `initialize` any parameter; later only `damping`. Raises GearPairError for what the unit refuses.
        """
        if name not in self._variables:
            raise GearPairError(f"the unit has no variable {name!r}")
        variable = self._variables[name]
        reference = [variable.valueReference]
        try:
            if variable.type == "Enumeration":
                items = {item.name: int(item.value) for item in variable.declaredType.items}
                if value not in items:
                    raise GearPairError(f"{name} = {value!r}: choose one of {', '.join(items)}")
                self._instance.setInteger(reference, [items[value]])
            elif variable.type == "Boolean":
                self._instance.setBoolean(reference, [bool(value)])
            else:
                self._instance.setReal(reference, [float(value)])
        except fmpy.fmi1.FMICallException as error:
            raise self._error(f"{name} = {value!r}") from error

    def initialize(self, start_time: float = 0.0) -> None:
        """Takes the pose in `u` as the start at `start_time`, s, latches the phase there and fills `y`."""
        self.time = start_time
        try:
            self._instance.setupExperiment(startTime=start_time)
            self._instance.enterInitializationMode()
            self._send()
            self._instance.exitInitializationMode()
            if self._exchange:
                self._instance.newDiscreteStates()
                self._instance.enterContinuousTimeMode()
        except fmpy.fmi1.FMICallException as error:
            raise self._error("the unit could not be initialised") from error
        self._receive()

    def step(self, size: float) -> None:
        """Hands over `u`, makes one communication step of `size` seconds and fetches `y`.

        The inputs count for the whole step and the outputs belong to them, unless `extrapolatePoses` is set.
        """
        self._send()
        self._call(self._do_step, self.time, size, 1)
        self.time += size
        self._receive()

    def evaluate(self, time: float) -> None:
        """Hands over `u` and fetches the outputs that belong to it at `time`, s (Model Exchange)."""
        self.time = time
        self._call(self._set_time, time)
        self._send()
        self._receive()

    def derivatives(self, outputs: Sequence[str], inputs: Sequence[str]) -> list[list[float]]:
        """Partial derivatives at the last point, SI units: a row for each output, a column for each input."""
        unknown = self._references(outputs)
        column = (ctypes.c_double * len(outputs))()
        seed = ctypes.c_double(1.0)
        columns = []
        for known in (self._references([name]) for name in inputs):
            self._call(self._derivative, unknown, len(outputs), known, 1, seed, column)
            columns.append(list(column))
        return [list(row) for row in zip(*columns)]

    def _send(self) -> None:
        self._call(self._set_real, self._input_references, len(self.u), self.u)

    def _receive(self) -> None:
        self._call(self._get_real, self._output_references, len(self.y), self.y)

    def __getitem__(self, output: str) -> float:
        """An output by name, as last fetched."""
        return self.y[self.output[output]]

    def __setitem__(self, name: str, value: float) -> None:
        """Writes an input by name; the next step or evaluation hands it over."""
        self.u[self.input[name]] = value

    @property
    def out_of_range(self) -> bool:
        """Whether the last operating point lay outside the table."""
        reference = [self._variables["mesh.outOfRange"].valueReference]
        return bool(self._instance.getBoolean(reference)[0])

    @property
    def flank(self) -> int:
        """1 with the drive flank in contact, -1 with the coast flank, 0 with none."""
        reference = [self._variables["mesh.flank"].valueReference]
        return int(self._instance.getInteger(reference)[0])

    def close(self) -> None:
        """Terminates the instance; the last one of its archive removes the unpacked files."""
        if self._instance is not None:
            try:
                self._instance.terminate()
            except Exception:  # never initialised, or already in error: free it all the same
                pass
            self._instance.freeInstance()
            self._instance = None
        if self._unpacked is not None:
            self._unpacked.release()
            self._unpacked = None

    def __enter__(self) -> GearPair:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
