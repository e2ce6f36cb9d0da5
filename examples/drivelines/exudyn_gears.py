"""The gear element in exudyn: one object over the nodes of both gear bodies.

A multibody program asks for forces at every stage of its integrator, with states that it may reject later. Model
Exchange allows that. In co-simulation the unit steps between the steps of the integrator, which holds its loads over each.
"""

from __future__ import annotations

from exudyn.utilities import ObjectGenericODE2
from gearmesh import GearPair

from .cardan import generalised, place


def attach_stepped(mbs, pair: GearPair, nodes, positions, parallel: bool):
    """As `attach`, of an initialised co-simulation instance: a function of coordinates and rates of both nodes and a step, s, that makes
    the unit's step. Its loads act in the same step, with `parallel` in the next one, as if all had stepped at once."""
    reference = [tuple(map(float, position)) for position in positions]
    acting = given = [0.0] * 12

    def step(q, q_t, size: float) -> None:
        nonlocal acting, given
        place(pair, q, q_t, reference)
        pair.step(size)
        acting, given = (given if parallel else pair.y[:12]), pair.y[:12]

    def forces(_mbs, _time, _item, q, _q_t):
        return generalised(acting, q)

    mbs.AddObject(ObjectGenericODE2(nodeNumbers=list(nodes), forceUserFunction=forces))
    return step


def attach(mbs, pair: GearPair, nodes, positions) -> int:
    """Adds the forces of `pair` between two nodes `NodeRigidBodyRxyz` on the gears' axes in their z = 0 faces.

    exudyn's Tait-Bryan angles are the unit's Cardan angles x-y-z, so coordinates and inputs differ by the
    nodes' reference positions (`positions`, m) alone. `pair` is an initialised Model Exchange instance.
    """
    reference = [tuple(map(float, position)) for position in positions]

    def forces(_mbs, time, _item, q, q_t):
        place(pair, q, q_t, reference)
        pair.evaluate(time)
        return generalised(pair.y[:12], q)

    return mbs.AddObject(ObjectGenericODE2(nodeNumbers=list(nodes), forceUserFunction=forces))
