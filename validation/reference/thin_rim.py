"""Compliance of gears with thin rims from a finite-element model of the whole gear, apart from the product's code.

    python validation/reference/thin_rim.py > tests/data/thin_rim.json
    python validation/reference/thin_rim.py holes > tests/data/web_holes.json
    python validation/reference/thin_rim.py pins > tests/data/ring_pins.json
    python validation/reference/thin_rim.py planet > docs/data/finite-elements/planet-cross-effect.csv

Every tooth of the gear is meshed, with rim, web and hub, in 20-node hexahedra; nothing is condensed and no symmetry
is used. The outline is the envelope of the rolling rack, of a ring an arc at the root. A strip is a line load of 1 N along a contact line, spread
over the arc length of the flank by 15/16 (1 - t^2)^2 / w, |t| < 1 in half-widths w, normal to the flank; the
influence of strip j on strip i is the displacement along i's own load, averaged with it (m/N).
"""

import json
import sys
from itertools import product

import numpy as np
from pypardiso import PyPardisoSolver

from flank_mesh import Profile
from hexahedra import LOCAL, halves, shape, stiffness
from teeth import NU, Gear

E = 206e9


def growing_by(growth, a, b, first):
    """Ends from `a` to `b` of cells that grow geometrically from about `first`."""
    steps = [first]
    while sum(steps) < abs(b - a):
        steps.append(steps[-1] * growth)
    ends = np.r_[0.0, np.cumsum(steps)]
    return a + (b - a) * ends / ends[-1]


class Model:
    def __init__(self, gear):
        self.gear = gear
        m, z = gear["module"], gear["teeth"]
        ring = gear["pins"] is not None
        self.hole = gear["pins"] or gear["holes"]
        kappa = -1 if ring else 1
        tip = 1e3 * (0.5 * z * m / np.cos(np.radians(gear["helix_deg"])) + kappa * m)
        self.teeth = Gear(z, 1e3 * m, 20.0, gear["helix_deg"], tip=tip, ring=ring)
        self.profile = profile = Profile(self.teeth)  # tooth at 0, this flank faces +theta; mm
        pitch = 2 * np.pi / z
        # Arc lengths (m) where the fillet has turned by 45 degrees, where the involute starts, and of the tip.
        split, form, tip = (1e-3 * arc for arc in (profile.split, profile.of_radius(profile.form_radius), profile.tip))

        def at(arc):
            r, t = profile.at(1e3 * arc)
            return 1e-3 * r, t

        # Arc lengths of flank nodes; the involute starts on one.
        n1 = max(1, round((form - split) / (0.2 * m)))
        n2 = round((tip - form) / (0.17 * m))
        arcs = halves(np.r_[np.linspace(split, form, n1 + 1), np.linspace(form, tip, n2 + 1)[1:]])
        self.arcs = arcs
        u = halves(np.sin(0.5 * np.pi * np.linspace(-1, 1, gear["across"] + 1)))
        r_row, t_row = at(arcs)
        blocks = [(np.outer(np.ones(u.size), r_row), np.outer(u, t_row), "rim")]
        self.rim_in = 1e-3 * self.teeth.root - kappa * gear["rim"]
        r_s, t_s = at(split)
        below = halves(growing_by(1.35, 0.0, 1.0, 0.3 * m / abs(r_s - self.rim_in)))
        land = halves(np.linspace(split, 0.0, gear["land"] + 1))
        r_land, t_land = at(land)
        columns = []  # (surface radius, surface angle, angle inside)
        columns.append((np.full(u.size, r_s), u * t_s, u * t_s))
        w = (split - land) / split
        inside = t_s + w * (0.5 * pitch - t_s)
        columns.append((r_land, t_land, inside))
        columns.append((r_land[::-1], -t_land[::-1], -inside[::-1]))
        web = growing_by(1.6, self.rim_in, gear["hub"], 0.3 * m) if self.hole is None else np.linspace(self.rim_in, gear["hub"], 9)
        # Where the two columns of the tooth next to its middle end: a hole takes the place of these.
        self.inner = t_s * u[2 * (gear["across"] // 2 + 2)]
        radii = {"web": web, "hub": growing_by(gear["growth"], gear["hub"], gear["bore"], 0.5 * m)}
        for surface, theta, deep in columns:
            blocks.append((
                surface[:, None] + below * (self.rim_in - surface[:, None]),
                theta[:, None] + below * (deep - theta)[:, None],
                "rim",
            ))
            for part, ends in radii.items():
                if ends[0] == ends[-1]:
                    continue
                rows = halves(ends)
                blocks.append((np.outer(np.ones(deep.size), rows), np.outer(deep, np.ones(rows.size)), part))
        self.mesh(blocks, pitch)

    def mesh(self, blocks, pitch):
        gear = self.gear
        zs = halves(gear["stations"])
        spans = {"rim": [0.0, gear["face"]], "web": gear["web"], "hub": gear["hub_z"]}
        twist = 1e3 * self.teeth.twist
        steps = LOCAL + 1
        cells, flank, webs = [], [], []
        for number, (r, t, part) in enumerate(blocks):
            low, high = spans[part]
            inside = [k for k in range(0, zs.size - 1, 2) if low - 1e-9 < zs[k + 1] < high + 1e-9]
            for k, i, j in product(inside, range(0, r.shape[0] - 1, 2), range(0, r.shape[1] - 1, 2)):
                a, b, c = i + steps[:, 0], j + steps[:, 1], k + steps[:, 2]
                if number == 0 and i in (0, r.shape[0] - 3):
                    flank.append((1 if i else -1, len(cells), j, k))
                cells.append(np.c_[r[a, b], t[a, b], zs[c]])
                webs.append(part == "web")
        sector = np.array(cells)
        whole, kept = [], []
        for tooth in range(gear["teeth"]):
            here, solid = sector, np.ones(len(cells), bool)
            if self.hole and tooth % (gear["teeth"] // self.hole["count"]) == 0:
                here, solid = self.pierced(sector, np.array(webs), 0.5 * pitch)
            angle = here[..., 1] + tooth * pitch + twist * here[..., 2]
            whole.append(np.stack([here[..., 0] * np.cos(angle), here[..., 0] * np.sin(angle), here[..., 2]], -1))
            kept.append(solid)
        kept = np.concatenate(kept)
        self.place = np.cumsum(kept) - 1
        x = np.concatenate(whole)[kept]
        keys = np.round(x.reshape(-1, 3) / 1e-8).astype(np.int64)
        _, first, inverse = np.unique(keys // 3, axis=0, return_index=True, return_inverse=True)
        self.x, self.points = x, x.reshape(-1, 3)[first]
        self.elements = inverse.reshape(x.shape[0], 20)
        self.flank, self.per_tooth, self.zs = flank, len(cells), zs
        place = self.points[:, 0] + 1j * self.points[:, 1]
        if gear["pins"]:
            middles = self.hole["circle"] * np.exp(2j * np.pi * np.arange(self.hole["count"]) / self.hole["count"])
            self.held = np.min(np.abs(place[:, None] - middles), axis=1) < self.hole["radius"] * (1 + 1e-9)
        elif gear["held_z"] is None:
            self.held = (np.abs(place) < gear["bore"] * (1 + 1e-9)) & (np.abs(np.angle(place / 1j)) < np.radians(0.5 * gear["held_deg"]) + 1e-9)
        else:
            self.held = np.min(np.abs(self.points[:, 2:] - np.array(gear["held_z"])), axis=1) < 1e-9

    def pierced(self, sector, webs, half):
        """The sector (polar) of a spur gear with the elements of its web laid around a hole under the middle of the tooth, and which of them stay:
        squares about the hole become circles, and blend into the edge of the web's part of the sector."""
        hole, hub = self.hole, self.gear["hub"]
        middle, depth = 0.5 * (self.rim_in + hub), 0.5 * abs(self.rim_in - hub)
        share = lambda x, inner, outer: np.where(abs(x) < inner, 0.5 * x / inner, np.sign(x) * (0.5 + 0.5 * (abs(x) - inner) / (outer - inner)))
        back = lambda s, inner, outer: np.where(abs(s) < 0.5, 2 * s * inner, np.sign(s) * (inner + (2 * abs(s) - 1) * (outer - inner)))
        sizes = [(0.5 * depth, depth), (self.inner, half)]
        a, b = share(sector[..., 0] - middle, *sizes[0]), share(sector[..., 1], *sizes[1])
        square = np.maximum(abs(a), abs(b))
        solid = ~(webs & (square.max(1) < 0.5 + 1e-9))
        square = np.maximum(square, 1e-9)
        edge, turn = middle + back(a / square, *sizes[0]), back(b / square, *sizes[1])
        edge = np.stack([edge * np.cos(turn), edge * np.sin(turn)], -1)
        away = edge - [hole["circle"], 0.0]
        round_ = [hole["circle"], 0.0] + hole["radius"] * away / np.linalg.norm(away, axis=-1)[..., None]
        t = (2 * square - 1)[..., None]
        at = (1 - t) * round_ + t * edge
        moved = sector.copy()
        moved[webs, :, 0] = np.hypot(at[..., 0], at[..., 1])[webs]
        moved[webs, :, 1] = np.arctan2(at[..., 1], at[..., 0])[webs]
        return moved, solid

    def stiffness(self):
        self.number = np.where(self.held, -1, np.cumsum(~self.held) - 1)
        nodes = self.number[self.elements][..., None]
        dofs = np.where(nodes < 0, -1, 3 * nodes + np.arange(3))
        return stiffness(self.x, dofs, 3 * int((~self.held).sum()), E, NU)

    def load(self, strip, half_width):
        """Vector of a unit line load; `strip` has tooth, z (two ends) and diameter (at both ends), and flank -1 if that faces -theta."""
        f = np.zeros(3 * int((~self.held).sum()))
        gauss = list(zip(*np.polynomial.legendre.leggauss(6)))
        z0, z1 = strip["z_mm"][0] * 1e-3, strip["z_mm"][1] * 1e-3
        facing = strip.get("flank", 1)
        roll = [np.sqrt((0.5 * d) ** 2 - self.teeth.rb**2) for d in strip["diameter_mm"]]
        for side, cell, j, k in self.flank:
            low, high = max(self.zs[k], z0), min(self.zs[k + 2], z1)
            if side != facing or high <= low:
                continue
            s0, s1 = self.arcs[j], self.arcs[j + 2]
            element = self.place[strip["tooth"] * self.per_tooth + cell]
            for (p, wp), (q, wq) in product(gauss, repeat=2):
                z = 0.5 * (low + high) + 0.5 * (high - low) * p
                share = (z - z0) / (z1 - z0)
                place = 1e-3 * self.profile.of_radius(np.hypot(roll[0] + share * (roll[1] - roll[0]), self.teeth.rb))
                lo, hi = max(s0, place - half_width), min(s1, place + half_width)
                if hi <= lo:
                    continue
                s = 0.5 * (lo + hi) + 0.5 * (hi - lo) * q
                t = (s - place) / half_width
                density = 15 / 16 * (1 - t * t) ** 2 / half_width
                xi = [side, 2 * (s - s0) / (s1 - s0) - 1, 2 * (z - self.zs[k]) / (self.zs[k + 2] - self.zs[k]) - 1]
                n, g = shape(xi)
                tangents = g[0].T @ self.x[element]
                normal = np.cross(tangents[1], tangents[2])
                normal /= np.linalg.norm(normal)
                at = n[0] @ self.x[element]
                if side * (normal[1] * at[0] - normal[0] * at[1]) < 0:  # outwards faces +theta
                    normal = -normal
                value = -density * wp * 0.5 * (high - low) / (z1 - z0) * wq * 0.5 * (hi - lo)
                for node, share_of_node in zip(self.number[self.elements[element]], n[0]):
                    f[3 * node : 3 * node + 3] += value * share_of_node * normal
        return f


def influences(name, gear, strips, half_width):
    """Number of unknowns, and the influences (m/N) of `strips` on each other."""
    model = Model(gear)
    matrix = model.stiffness()
    loads = np.array([model.load(s, half_width) for s in strips])
    print(name, matrix.shape[0], "unknowns", matrix.nnz, "entries", file=sys.stderr, flush=True)
    solver = PyPardisoSolver(mtype=2)
    solver.factorize(matrix)
    answer = solver.solve(matrix, np.ascontiguousarray(loads.T))
    solver.free_memory(everything=True)
    return matrix.shape[0], loads @ answer


def gear_of(teeth, module, helix, face, rim, web, hub, hub_z, bore, stations, held_z=None, held_deg=360.0, growth=2.0, holes=None, pins=None):
    """Lengths in mm; `bore` of a ring is its outside, `hub` begins where the part that is `web` ends."""
    circle = lambda holes: holes and dict(count=holes["count"], circle=0.5e-3 * holes["circle_mm"], radius=0.5e-3 * holes["diameter_mm"])
    return dict(teeth=teeth, module=module * 1e-3, helix_deg=helix, face=face * 1e-3, rim=rim * 1e-3,
                web=[v * 1e-3 for v in web], hub=0.5e-3 * hub, hub_z=[v * 1e-3 for v in hub_z], bore=0.5e-3 * bore,
                stations=[v * 1e-3 for v in stations], across=6, land=2, growth=growth, holes=circle(holes), pins=circle(pins),
                held_z=held_z and [v * 1e-3 for v in held_z], held_deg=held_deg)


def case(name, strips, **data):
    unknowns, influence = influences(name, gear_of(**data), strips, 0.3e-3 * data["module"])
    teeth = dict(name=name, teeth=data["teeth"], normal_module_mm=data["module"], helix_angle_deg=data["helix"], face_width_mm=data["face"])
    if data.get("pins"):
        body = dict(rim_diameter_mm=data["bore"], rim_pins=data["pins"])
    else:
        body = dict(rim_thickness_mm=data["rim"], web_z_mm=data["web"], hub_diameter_mm=data["hub"], hub_z_mm=data["hub_z"],
                    bore_diameter_mm=data["bore"], held_z_mm=data.get("held_z") or [], web_holes=data.get("holes"))
    return teeth | body | dict(kernel_half_width_mm=0.3 * data["module"], unknowns=unknowns, strips=strips,
                               influence_nm_per_n=[[round(1e9 * v, 6) for v in row] for row in influence])


def strip(tooth, z, diameters):
    return dict(tooth=tooth, z_mm=z, diameter_mm=diameters)


def planet():
    """What a load of one mesh of a planet adds at the other one, as CSV."""
    print("# Spur planet of 24 teeth of 2 mm, face 12 mm: the first mesh loads tooth 0, the second one tooth 12 half-way round, on its other")
    print("# flank as an idler's, both over the whole face at the pitch circle. rim_depth: from the roots to the bore, modules. The bore is held")
    print("# in all directions over held_deg: all around, or where the bearing bears, which is opposite to the resultant of both loads.")
    print("# own: deflection of tooth 0 along its load by that load; cross: what an equal load of the second mesh adds to it, of own.")
    print("rim_depth_modules,held_deg,own_nm_per_n,cross_percent")
    strips = [strip(0, [0, 12], [48, 48]), strip(12, [0, 12], [48, 48]) | dict(flank=-1)]
    for depth in (1.5, 2.5, 4.0, 8.0):
        for held in (360, 180, 120):
            bore = 2 * (21.5 - 2 * depth)
            gear = gear_of(teeth=24, module=2.0, helix=0.0, face=12.0, rim=2 * depth, web=[0, 0], hub=bore, hub_z=[0, 0], bore=bore,
                           stations=[0, 0.8, 2.4, 6, 9.6, 11.2, 12], held_deg=held)
            _, influence = influences(f"{depth} {held}", gear, strips, 0.6e-3)
            print(f"{depth},{held},{1e9 * influence[0, 0]:.4f},{round(100 * influence[0, 1] / influence[0, 0], 2) + 0.0:.2f}", flush=True)


def main():
    chosen = sys.argv[1:]
    if chosen == ["planet"]:
        return planet()
    spur = [strip(0, [0, 12], [48, 48]), strip(0, [0, 12], [50.5, 50.5]), strip(0, [0, 3], [48, 48]), strip(0, [9, 12], [48, 48]),
            strip(1, [0, 12], [46.5, 46.5]), strip(1, [9, 12], [46.5, 46.5]), strip(2, [0, 12], [48, 48])]
    helical = [strip(0, [0, 12], [49.5, 52.5]), strip(0, [0, 4], [52, 53.5]), strip(0, [8, 12], [49.5, 51]),
               strip(1, [0, 12], [49, 51]), strip(1, [8, 12], [49, 50.5])]
    common = dict(teeth=24, module=2.0, face=12.0)
    cases = {
        "spur": dict(helix=0.0, rim=3.0, web=[4.5, 7.5], hub=26.0, hub_z=[0.0, 12.0], bore=18.0,
                     stations=[0, 0.6, 1.6, 3.1, 4.5, 6, 7.5, 8.9, 10.4, 11.4, 12], strips=spur),
        "helical": dict(helix=20.0, rim=4.0, web=[2.0, 5.0], hub=28.0, hub_z=[-3.0, 12.0], bore=18.0,
                        stations=[-3, -1.2, 0, 0.7, 2, 3.5, 5, 6.3, 8, 9.9, 11.3, 12], strips=helical),
        # A pinion shaft of 38 mm at low z and 28 mm at high z, held at its end there; all but solid.
        "shaft": dict(helix=20.0, rim=4.0, web=[-8.0, 12.0], hub=28.0, hub_z=[-8.0, 32.0], bore=2.0, held_z=[32.0], growth=1.6,
                      stations=[-8, -4, -1.5, 0, 0.7, 2, 3.5, 5, 6.3, 8, 9.9, 11.3, 12, 13, 15, 18.5, 23, 27.5, 30.5, 32],
                      strips=helical),
    }
    if "holes" in chosen:
        # One under the middle of every fourth tooth.
        places = [strip(tooth, [0, 12], [48, 48]) for tooth in range(5)] + [strip(0, [0, 3], [48, 48]), strip(2, [0, 3], [48, 48])]
        cases = {"holes": cases["spur"] | dict(holes=dict(count=6, circle_mm=31.5, diameter_mm=3.6), strips=places)}
    if "pins" in chosen:
        # Under the middles of teeth 0, 10, 20 and 30.
        places = [strip(tooth, [0, 12], [80, 80]) for tooth in (0, 1, 3, 5, 6)] + [strip(5, [0, 3], [78, 78]), strip(0, [0, 3], [83, 83])]
        common |= dict(teeth=40)
        cases = {"pins": dict(helix=0.0, rim=2.0, web=[0.0, 12.0], hub=103.0, hub_z=[0.0, 12.0], bore=108.0, stations=[0, 0.35, 0.9, 1.7, 2.4, 3, 5.5, 9, 12],
                              pins=dict(count=4, circle_mm=96.0, diameter_mm=4.0), strips=places)}
    results = [case(name, **common, **data) for name, data in cases.items() if not chosen or name in chosen]
    text = json.dumps(dict(description=__doc__.strip(), cases=results))
    print(text.replace('{"name"', '\n{"name"').replace('{"tooth"', '\n {"tooth"'))


if __name__ == "__main__":
    main()
