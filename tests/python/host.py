"""A host for the tests: the FMU's C interface through fmpy, with names and its own logger.

fmpy's logger proxy must not be mixed with other callbacks in one process, so the tests bring their
own callbacks everywhere. The FMU logs through the format "%s" with one string; on the machines the
tests run on, a variadic argument arrives like an ordinary one, so the logger takes six arguments.
"""

import ctypes
import json
import shutil
from pathlib import Path

from fmpy import extract, freeLibrary, read_model_description
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2EventInfo as EventInfo
from gearmesh.geometry import Geometry
from gearmesh.pair import LOGGER, SCALARS

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
MODEL_EXCHANGE, CO_SIMULATION = range(2)


class Unit:
    """An unpacked FMU; `instance()` makes running instances of it."""

    def __init__(self, fmu, folder=None):
        self.folder = str(extract(str(fmu), unzipdir=None if folder is None else str(folder)))
        self.description = read_model_description(self.folder)
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.geometry = Geometry.of_unit(json.loads(Path(self.folder, "resources", "unit.json").read_text())["geometry"])

    def instance(self, **options):
        return Instance(self, **options)

    def close(self):
        shutil.rmtree(self.folder, ignore_errors=True)


class Instance:
    """One instance; methods without checks return the status, `set`, `get`, ... expect success."""

    def __init__(self, unit, name="mesh", logging=True, guid=None, logger=True, kind=CO_SIMULATION):
        self.unit = unit
        self.is_co_simulation = kind == CO_SIMULATION
        self.messages = []
        self.slave = FMU2Slave(
            guid=guid or unit.description.guid,
            unzipDirectory=unit.folder,
            modelIdentifier=unit.description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        # fmpy raises on bad status; the tests look at it themselves.
        self.dll = self.slave.dll
        self._logger = LOGGER(self._log)
        self._callbacks = fmi2CallbackFunctions()
        if logger:
            self._callbacks.logger = ctypes.cast(self._logger, type(self._callbacks.logger))
        uri = Path(unit.folder, "resources").as_uri()
        self.dll.fmi2Instantiate.restype = ctypes.c_void_p
        self.component = self.dll.fmi2Instantiate(
            name.encode(),
            kind,
            (guid or unit.description.guid).encode(),
            uri.encode(),
            ctypes.byref(self._callbacks),
            0,
            int(logging),
        )

    def _log(self, _environment, name, status, category, form, text):
        self.messages.append((name.decode(), status, category.decode(), form.decode(), text.decode()))

    def log(self):
        """All texts so far, one per line."""
        return "\n".join(m[4] for m in self.messages)

    def call(self, function, *arguments):
        """Calls `function` of the C interface and returns its status."""
        f = getattr(self.dll, function)
        # fmpy declares argument types; the tests pass what hosts should not.
        f.argtypes, f.restype = None, ctypes.c_int
        return f(ctypes.c_void_p(self.component), *arguments)

    def expect(self, function, *arguments):
        status = self.call(function, *arguments)
        assert status == OK, f"{function} returned {status}: {self.log()}"

    def refused(self, values):
        """What the log says when an instance with these values cannot be initialised."""
        self.expect("fmi2EnterInitializationMode")
        self.set(values)
        assert self.call("fmi2ExitInitializationMode") == ERROR
        return self.log()

    def close(self):
        if self.component:
            self.dll.fmi2FreeInstance(ctypes.c_void_p(self.component))
        if self.dll:
            freeLibrary(self.dll._handle)
        self.component = self.dll = None

    # Values by name ------------------------------------------------------------------------

    def kind(self, name):
        kind = self.unit.variables[name].type
        return "Integer" if kind == "Enumeration" else kind

    def status_of_setting(self, values):
        """Sets values by name with one call per type; the worst status."""
        worst = OK
        for kind, c_type in SCALARS.items():
            names = [n for n in values if self.kind(n) == kind]
            if names:
                references = self.references(names)
                data = (c_type * len(names))(*(c_type(values[n]).value for n in names))
                status = self.call(f"fmi2Set{kind}", references, ctypes.c_size_t(len(names)), data)
                worst = max(worst, status)
        return worst

    def references(self, names):
        return (ctypes.c_uint * len(names))(*(self.unit.variables[n].valueReference for n in names))

    def set(self, values):
        status = self.status_of_setting(values)
        assert status == OK, f"setting {values}: {self.log()}"

    def get(self, *names):
        """Values of variables of one kind, in their order; one value for one name."""
        kind, count = self.kind(names[0]), len(names)
        data = (SCALARS[kind] * count)()
        self.expect(f"fmi2Get{kind}", self.references(names), ctypes.c_size_t(count), data)
        return data[0] if count == 1 else list(data)

    def vector(self, name):
        return self.get(*(f"{name}[{i}]" for i in (1, 2, 3)))

    # Life ------------------------------------------------------------------------------------

    def initialize(self, values=None, start=0.0, stop=None):
        """From instantiated to the first communication point, or to Continuous-Time Mode."""
        times = ctypes.c_double(start), int(stop is not None), ctypes.c_double(stop or 0.0)
        self.expect("fmi2SetupExperiment", 0, ctypes.c_double(0.0), *times)
        self.expect("fmi2EnterInitializationMode")
        self.set(values or {})
        self.expect("fmi2ExitInitializationMode")
        if not self.is_co_simulation:
            self.expect("fmi2NewDiscreteStates", ctypes.byref(EventInfo()))
            self.expect("fmi2EnterContinuousTimeMode")
        return self

    def step(self, time, step):
        return self.call("fmi2DoStep", ctypes.c_double(time), ctypes.c_double(step), 1)

    # FMU states --------------------------------------------------------------------------------

    def store(self, state=None):
        place = ctypes.c_void_p(state)
        self.expect("fmi2GetFMUstate", ctypes.byref(place))
        return place.value

    def restore(self, state):
        return self.call("fmi2SetFMUstate", ctypes.c_void_p(state))

    def serialize(self, state):
        size = ctypes.c_size_t()
        self.expect("fmi2SerializedFMUstateSize", ctypes.c_void_p(state), ctypes.byref(size))
        data = ctypes.create_string_buffer(size.value)
        self.expect("fmi2SerializeFMUstate", ctypes.c_void_p(state), data, size)
        return data.raw

    def deserialize(self, data):
        place = ctypes.c_void_p()
        status = self.call(
            "fmi2DeSerializeFMUstate", data, ctypes.c_size_t(len(data)), ctypes.byref(place)
        )
        return status, place.value
