"""The gear element in exudyn: one object over the nodes of both gear bodies.

A multibody program asks for forces at every stage of its integrator, with states that it may reject later. Model
Exchange allows that, co-simulation does not.
"""

from __future__ import annotations

from exudyn.utilities import ObjectGenericODE2
from gearmesh import GearPair

from .cardan import generalised, place


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
