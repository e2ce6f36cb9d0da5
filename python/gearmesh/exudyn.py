"""The FMU in exudyn: one object over the nodes of both gear bodies.

A multibody program asks for forces at every stage of its integrator, with states that it may reject later. Model
Exchange allows that. In co-simulation the FMU steps between the steps of the integrator, which holds its loads over each.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from exudyn.utilities import ObjectGenericODE2

from .pair import GearPair
from .poses import generalised, place


def attach(mbs: Any, pair: GearPair, nodes: Sequence[Any], positions: Sequence[Sequence[float]]) -> int:
    """Adds the forces of an FMU between two nodes.

    exudyn's Tait-Bryan angles are the FMU's Cardan angles x-y-z, so coordinates and inputs differ by the nodes' reference
    positions alone.

    Parameters
    ----------
    mbs
        System of exudyn.
    pair
        Initialised, through Model Exchange.
    nodes
        `NodeRigidBodyRxyz` on the axis of each gear in its z = 0 face.
    positions : (2, 3)
        Their reference positions, m.

    Returns
    -------
    int
        Number of the object.
    """
    reference = [tuple(map(float, position)) for position in positions]

    def forces(_mbs: Any, time: float, _item: int, q: Any, q_t: Any) -> Any:
        place(pair, q, q_t, reference)
        pair.evaluate(time)
        return generalised(pair.y[:12], q)

    return mbs.AddObject(ObjectGenericODE2(nodeNumbers=list(nodes), forceUserFunction=forces))


def attach_stepped(
    mbs: Any, pair: GearPair, nodes: Sequence[Any], positions: Sequence[Sequence[float]]
) -> Callable[[Sequence[float], Sequence[float], float], None]:
    """As `attach`, of an initialised co-simulation instance.

    Returns
    -------
    function
        Of coordinates (12,) and rates of both nodes and a step, s, to be called before the integrator makes that step: the FMU
        steps. Its loads act in the same step or, with `coupling` = parallel, in the next one, as if all had stepped at once.
    """
    reference = [tuple(map(float, position)) for position in positions]
    late = pair.parameters["coupling"] == "parallel"
    acting: Sequence[float] = [0.0] * 12
    given: Sequence[float] = []

    def step(q: Sequence[float], q_t: Sequence[float], size: float) -> None:
        nonlocal acting, given
        place(pair, q, q_t, reference)
        pair.step(size)
        loads = pair.y[:12]
        acting, given = (given or loads) if late else loads, loads  # the first ones act at once

    def forces(_mbs: Any, _time: float, _item: int, q: Any, _q_t: Any) -> Any:
        return generalised(acting, q)

    mbs.AddObject(ObjectGenericODE2(nodeNumbers=list(nodes), forceUserFunction=forces))
    return step
