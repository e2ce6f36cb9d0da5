"""One instance of a gearmesh FMU, driven through fmpy and ctypes."""

from __future__ import annotations

import contextlib
import ctypes
import difflib
import json
import logging
import os
import shutil
import tempfile
import threading
import weakref
import zipfile
from collections import deque
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, NoReturn

import fmpy
from fmpy.fmi2 import FMU2Model, FMU2Slave, fmi2CallbackFunctions, fmi2EventInfo

from .errors import GearPairError
from .geometry import Geometry

WARNING = 1  # fmi2Status: what is above was refused
LAST_SUCCESSFUL_TIME = 2  # fmi2StatusKind
#: Bytes that all files of an archive may unfold into together: some dozens of times the tables of a pair.
MOST_BYTES = 1 << 30
INTERFACES = {"co-simulation": FMU2Slave, "model-exchange": FMU2Model}
SCALARS = {"Real": ctypes.c_double, "Integer": ctypes.c_int, "Boolean": ctypes.c_int}
# The FMU always logs with the format "%s" and one text.
TEXT = ctypes.c_char_p
LOGGER = ctypes.CFUNCTYPE(None, ctypes.c_void_p, TEXT, ctypes.c_int, TEXT, TEXT, TEXT)


class GearPair:
    """An instance of a packed unit with one array of inputs and one of outputs.

    `fmu` is the file that `gearmesh build` wrote. `parameters` are set by name before initialisation (`set_parameter`).
    Everything is in SI units and in the world frame; documentation/index.html of the FMU describes each variable.

    `u` and `y` hold the Real inputs and outputs in the order of modelDescription.xml; `input` and `output` map
    a variable's name to its index there. In a loop, look indices up once and use `u` and `y`; elsewhere `pair[name]`
    reads an output and `pair[name] = value` writes an input. fmpy's own setters build new arrays at every call, which
    costs tens of microseconds; here a step costs three calls into the library, about 2 us beyond the element.

    Co-simulation advances by `step`. Model Exchange, for solvers that want the force at every stage, evaluates at any
    time and in any order by `evaluate`; the FMU has no states of its own.

    What the FMU warns of goes to Python's logger "gearmesh".

    An instance cannot be copied; make a second one of the same file, which shares the unpacked files. It ends with
    `close`, with the `with` block, or when nothing refers to it any more. After that `u` and `y` keep their last
    values and every call raises GearPairError, in all threads.
    """

    #: Index in `u` by the input's name.
    input: dict[str, int]
    #: Index in `y` by the output's name.
    output: dict[str, int]
    #: Of the last call, in s.
    time: float
    #: Of the pair at its nominal centre distance.
    geometry: Geometry

    def __init__(
        self,
        fmu: str | Path,
        parameters: Mapping[str, float | bool | str] | None = None,
        interface: Literal["co-simulation", "model-exchange"] = "co-simulation",
    ) -> None:
        if interface not in INTERFACES:
            raise GearPairError(f"interface = {interface!r}: choose one of {', '.join(INTERFACES)}")
        self.time = 0.0
        self._exchange = interface == "model-exchange"
        unpacked = _Unpacked.of(fmu)
        description, self.geometry = unpacked.description, unpacked.geometry
        self._variables = {v.name: v for v in description.modelVariables}
        here = Path.cwd()
        try:
            instance: Any = INTERFACES[interface](  # of fmpy, which has no types
                guid=description.guid,
                unzipDirectory=unpacked.folder,
                modelIdentifier=description.coSimulation.modelIdentifier,
                instanceName=Path(fmu).stem,
            )
        except Exception as error:
            os.chdir(here)  # fmpy loads the library from its folder and stays there when that fails
            raise GearPairError(f"{fmu}: its library for this platform cannot be loaded: {error}; `gearmesh inspect` lists its platforms") from error
        # fmpy's own callbacks print; these keep the causes of refusals. The FMU needs no other callback.
        self._log = log = deque[str](maxlen=8)
        self._warnings = warnings = deque[str]()

        @LOGGER
        def logger(_environment: Any, _name: bytes, status: int, _category: bytes, _format: bytes, text: bytes) -> None:
            if status > WARNING:
                log.append(text.decode(errors="replace"))
            elif status == WARNING:
                warnings.append(text.decode(errors="replace"))

        callbacks = fmi2CallbackFunctions()
        callbacks.logger = ctypes.cast(logger, type(callbacks.logger))
        try:
            instance.instantiate(callbacks=callbacks, loggingOn=True)
        except Exception as error:
            fmpy.freeLibrary(instance.dll._handle)
            raise GearPairError("; ".join([str(error), *log])) from error
        # A signal handler may close the pair while its thread is in a call.
        self._lock = threading.RLock()
        self._warn()
        self._component = ctypes.c_void_p(instance.component)
        # The same library with functions of our own: fmpy gives its own argument types, which cost time at every call.
        self._library = ctypes.CDLL(instance.dll._name, handle=instance.dll._handle)
        self._free = weakref.finalize(self, _free, instance, self._component, self._lock, callbacks, logger, unpacked)
        self._bind()
        try:
            for name, value in (parameters or {}).items():
                self.set_parameter(name, value)
        except BaseException:
            self.close()
            raise

    def _bind(self) -> None:
        """Prepares the arrays of a step."""
        real = [v for v in self._variables.values() if v.type == "Real"]
        inputs = [v for v in real if v.causality == "input"]
        outputs = [v for v in real if v.causality == "output"]
        self.input = {v.name: i for i, v in enumerate(inputs)}
        self.output = {v.name: i for i, v in enumerate(outputs)}
        self._u = (ctypes.c_double * len(inputs))(*(float(v.start) for v in inputs))
        self._y = (ctypes.c_double * len(outputs))()
        self._parameters = {v.name: _start(v) for v in self._variables.values() if v.causality == "parameter"}
        self._inputs = *self._references(self.input), self._u
        self._outputs = *self._references(self.output), self._y

    def _references(self, names: Collection[str]) -> tuple[ctypes.Array[ctypes.c_uint], ctypes.c_size_t]:
        references = [self._variables[name].valueReference for name in names]
        return (ctypes.c_uint * len(references))(*references), ctypes.c_size_t(len(references))

    def _call(self, name: str, *arguments: object) -> None:
        """Calls a function of the library; `arguments` are of ctypes, or whole numbers for int."""
        with self._lock:
            if not self._component:
                raise GearPairError(f"{name}: the pair is closed")
            refused = None
            if getattr(self._library, name)(self._component, *arguments) > WARNING:
                refused = GearPairError(f"{name} at t = {self.time!r} s: {'; '.join(self._log)}")
                self._log.clear()
        if self._warnings:
            self._warn()
        if refused:
            raise refused

    def _warn(self) -> None:
        """Hands on what the FMU warned of, when no call is under way: a handler may use the pair itself."""
        while self._warnings:
            logging.getLogger("gearmesh").warning(self._warnings.popleft())

    def _scalar(self, verb: Literal["Get", "Set"], variable: Any, value: float = 0) -> float:
        """Gets or sets one value by the call for its type in modelDescription.xml."""
        kind = "Integer" if variable.type == "Enumeration" else variable.type
        cell = SCALARS[kind](value)
        self._call(f"fmi2{verb}{kind}", *self._references([variable.name]), ctypes.byref(cell))
        return cell.value

    @property
    def parameters(self) -> Mapping[str, float | bool | str]:
        """The parameters as they are, by name, as `set_parameter` takes them: an enumeration by the name of its item."""
        return MappingProxyType(self._parameters)

    def set_parameter(self, name: str, value: float | bool | str) -> None:
        """Sets a parameter by name, in SI units: a number, True or False, an enumeration by the name of its item or its number.

        Before `initialize` any parameter; later only `damping`. Raises GearPairError for a value of another kind and for
        what the FMU refuses.
        """
        if name not in self._parameters:
            raise GearPairError(self._unknown(name, "parameter", self._parameters))
        variable = self._variables[name]
        plain = value.item() if hasattr(value, "item") else value  # of NumPy's scalars
        items = _items(variable)
        fits = isinstance(plain, (int, str) if items else (int, float)) and isinstance(plain, bool) <= (variable.type == "Boolean")
        code = {item: number for number, item in items.items()}.get(plain, plain) if fits else None
        if code is None or (items and code not in items):
            choices = f"one of {', '.join(map(str, items.values()))}" if items else "a number"
            raise GearPairError(f"{name} = {value!r}: choose {choices}")
        self._scalar("Set", variable, code)
        self._parameters[name] = items.get(code, code)

    def initialize(self, start_time: float = 0.0) -> None:
        """Takes the pose in `u` as the start at `start_time`, s, takes the phase offset there and fills `y`."""
        self.time, none = start_time, ctypes.c_double(0.0)
        self._call("fmi2SetupExperiment", 0, none, ctypes.c_double(start_time), 0, none)
        self._call("fmi2EnterInitializationMode")
        self._call("fmi2SetReal", *self._inputs)
        self._call("fmi2ExitInitializationMode")
        if self._exchange:
            self._call("fmi2NewDiscreteStates", ctypes.byref(fmi2EventInfo()))
            self._call("fmi2EnterContinuousTimeMode")
        self._call("fmi2GetReal", *self._outputs)

    def step(self, size: float) -> None:
        """Hands over `u`, makes one communication step of `size` seconds and fetches `y`.

        The loads in `y` are constant ones for a step, as `coupling` says; with `automatic`, as packed, for the one in which the caller
        lets them act. The other outputs belong to `u`. With `coupling` = held, or along a given motion, the loads do, too.
        """
        self._call("fmi2SetReal", *self._inputs)
        try:
            self._call("fmi2DoStep", ctypes.c_double(self.time), ctypes.c_double(size), 1)
            self.time += size
            self._call("fmi2GetReal", *self._outputs)
        except GearPairError:
            raise
        except BaseException:  # such as Ctrl-C, which may come before or after the FMU has stepped
            self._catch_up()
            raise

    def _catch_up(self) -> None:
        """Takes time and outputs from the FMU."""
        with contextlib.suppress(GearPairError):  # closed meanwhile
            time = ctypes.c_double()
            self._call("fmi2GetRealStatus", LAST_SUCCESSFUL_TIME, ctypes.byref(time))
            self.time = time.value
            self._call("fmi2GetReal", *self._outputs)

    def evaluate(self, time: float) -> None:
        """Hands over `u` and fetches the outputs that belong to it at `time`, s (Model Exchange)."""
        self.time = time
        self._call("fmi2SetTime", ctypes.c_double(time))
        self._call("fmi2SetReal", *self._inputs)
        self._call("fmi2GetReal", *self._outputs)

    def derivatives(self, outputs: Sequence[str], inputs: Sequence[str]) -> list[list[float]]:
        """Partial derivatives at the last point, SI units: a row for each output, a column for each input."""
        unknown = self._references(outputs)
        column = (ctypes.c_double * len(outputs))()
        seed = ctypes.c_double(1.0)
        columns = []
        for name in inputs:
            known = self._references([name])
            self._call("fmi2GetDirectionalDerivative", *unknown, *known, ctypes.byref(seed), column)
            columns.append(list(column))
        return [list(row) for row in zip(*columns)]

    @property
    def u(self) -> ctypes.Array[ctypes.c_double]:
        """Inputs to be handed over, in SI units; written in place."""
        return self._u

    @property
    def y(self) -> ctypes.Array[ctypes.c_double]:
        """Outputs as last fetched, in SI units."""
        return self._y

    def __getitem__(self, output: str) -> float:
        """An output by name, as last fetched."""
        try:
            return self._y[self.output[output]]
        except KeyError:
            raise KeyError(self._unknown(output, "output", self.output)) from None

    def __setitem__(self, name: str, value: float) -> None:
        """Writes an input by name; the next step or evaluation hands it over."""
        try:
            index = self.input[name]
        except KeyError:
            raise KeyError(self._unknown(name, "input", self.input)) from None
        try:
            self._u[index] = value
        except TypeError:
            raise TypeError(f"{name} = {value!r}: give a number") from None

    def _unknown(self, name: str, what: str, names: Collection[str]) -> str:
        """What to say of a name that is none of ``names``."""
        if name in self.input:
            return f"{name} is an input, which is written"
        if name in self.output:
            return f"{name} is an output, which is read"
        if name in self._parameters:
            return f"{name} is a parameter: `parameters` has its value, and `set_parameter` sets it"
        near = difflib.get_close_matches(str(name), names, 1)
        hint = f"did you mean {near[0]}?" if near else f"docs/fmu.md has all {what}s"
        return f"there is no {what} {name}; {hint}"

    @property
    def out_of_range(self) -> bool:
        """Whether the last operating point lay outside the table."""
        return self["mesh.outOfRange"] != 0.0

    @property
    def flank(self) -> int:
        """1 with the drive flank in contact, -1 with the coast flank, 0 with none."""
        return int(self["mesh.flank"])

    def close(self) -> None:
        """Ends the instance, after a call that another thread has under way; the last one of its archive removes the unpacked files."""
        self._free()

    def __enter__(self) -> GearPair:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __reduce__(self) -> NoReturn:
        raise TypeError("a GearPair cannot be copied: make a second one of the same file")


def _items(variable: Any) -> dict[int, bool | str]:
    """Values of a Boolean or an enumeration by the number that stands for them; empty for numbers."""
    if variable.type == "Boolean":
        return {0: False, 1: True}
    return {int(item.value): item.name for item in variable.declaredType.items} if variable.type == "Enumeration" else {}


def _start(variable: Any) -> float | bool | str:
    """Start value of a parameter in modelDescription.xml."""
    number = float({"false": 0, "true": 1}.get(variable.start, variable.start))
    return _items(variable).get(int(number), number)


def _free(instance: Any, component: ctypes.c_void_p, lock: threading.RLock, *_used: object) -> None:
    """Frees an instance when no call is under way and makes `component` null; `_used` is what it needs until then."""
    with lock:
        component.value = None
        try:
            instance.terminate()
        except Exception:  # never initialised, or already in error: free it all the same
            pass
        instance.freeInstance()


_LOCK = threading.Lock()
_UNPACKED: weakref.WeakValueDictionary[tuple[Path, int, int], _Unpacked] = weakref.WeakValueDictionary()


class _Unpacked:
    """An archive unpacked once for all its instances, which share library and tables in memory; its folder goes with the last of them."""

    def __init__(self, file: Path) -> None:
        with zipfile.ZipFile(file) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
            if size > MOST_BYTES:
                raise GearPairError(f"its files unfold into {size >> 20} MB, more than {MOST_BYTES >> 20} MB")
            self.folder: str = tempfile.mkdtemp(prefix="gearmesh-")
            weakref.finalize(self, shutil.rmtree, self.folder, ignore_errors=True)
            archive.extractall(self.folder)
        self.description: Any = fmpy.read_model_description(self.folder)
        unit = json.loads(Path(self.folder, "resources", "unit.json").read_text(encoding="utf-8"))
        self.geometry = Geometry.of_unit(unit["geometry"])

    @staticmethod
    def of(fmu: str | Path) -> _Unpacked:
        """The archive as it is now: one that was written anew is another one.

        Raises
        ------
        GearPairError
            The file cannot be read, or is no FMU of gearmesh.
        """
        try:
            path = Path(fmu).resolve()
            if not path.is_file() and path.exists():
                raise GearPairError("it is no file")
            status = path.stat()
            key = (path, status.st_mtime_ns, status.st_size)
            with _LOCK:
                unpacked = _UNPACKED.get(key)
                if unpacked is None:
                    unpacked = _UNPACKED[key] = _Unpacked(path)
                return unpacked
        except Exception as error:  # of zipfile, its decompressors, fmpy, XML and JSON: whatever a damaged file can cause
            cause = f"it has no {error}" if isinstance(error, KeyError) else str(error) or type(error).__name__
            raise GearPairError(f"{fmu}: {cause}; name an FMU that `gearmesh build` or `gearmesh pack` wrote") from error
