"""Derivatives of the outputs by differences, to compare fmi2GetDirectionalDerivative with."""

import ctypes

import numpy as np


def directional(instance, outputs, inputs, seed):
    result = (ctypes.c_double * len(outputs))()
    unknown = instance.references(outputs), ctypes.c_size_t(len(outputs))
    known = instance.references(inputs), ctypes.c_size_t(len(inputs))
    instance.expect("fmi2GetDirectionalDerivative", *unknown, *known, (ctypes.c_double * len(inputs))(*seed), result)
    return np.array(list(result))


def variables(instance):
    """Names of the inputs and of the continuous outputs."""
    every = instance.unit.description.modelVariables
    inputs = [v.name for v in every if v.causality == "input"]
    return inputs, [v.name for v in every if v.causality == "output" and v.type == "Real"]


def jacobian(instance, inputs, outputs):
    return np.array([directional(instance, outputs, [name], [1.0]) for name in inputs]).T


def by_differences(instance, values, outputs, step):
    """The same at `values` by sixth-order differences, `step` (m, rad) apart: small against the elongation, large against rounding."""
    columns = []
    for name, value in values.items():
        h = 1e-3 if "elocity" in name else step
        at = {}
        for k in (-3, -2, -1, 1, 2, 3):
            instance.set({name: value + k * h})
            at[k] = np.array(instance.get(*outputs))
        columns.append((45 * (at[1] - at[-1]) - 9 * (at[2] - at[-2]) + at[3] - at[-3]) / (60 * h))
        instance.set({name: value})
    return np.array(columns).T


def columns_by_kind(inputs):
    """Numbers of the inputs that are measured in one unit: with the largest among them an error is compared."""
    kinds = ("position", "angles", "quaternion", "velocity", "angularVelocity")
    found = {kind: [j for j, n in enumerate(inputs) if n.split(".")[1].startswith(kind)] for kind in kinds}
    return {kind: columns for kind, columns in found.items() if columns}
