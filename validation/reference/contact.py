"""Loaded tooth contact of gear pairs by finite elements, apart from the program: writes tests/data/contact_reference.json, and
plastic_reference.json with the method of deformed.py.

    python validation/reference/contact.py [CASE ...]      # into the file, case by case; all of them take hours

Both gears in 20-node hexahedra (8-node quadrilaterals in plane strain), the loaded teeth and their neighbours real, bore or rim
held, rebuilt for each mesh position with a band of fine cells along every contact line: 0.012 mm in plane strain (0.003 to 0.004 mm, and 0.001 mm
at tip edges, where an edge bears: the mean gap of a face there exceeds that at an inclined edge), 0.02 mm for solid
spur gears (half of the face, even and odd loads), 0.024 mm for helical ones, 0.03 mm for the helical ring. A constant pressure on each face of the band; gap
between the exact involutes, along the normal of the flank whose tip is further away, plus the removal of material there. Both
gears are condensed onto these pressures; a linear complementarity problem gives them and the turn of gear 1 under its torque,
each with its own arm. No Hertz formula. A misalignment turns gear 2 about the normal of the plane of action through the pitch point
at mid-face and closes each gap by the rigid displacement of the face along its normal. contact_z_mm is where the resultant crosses
the pitch plane, from the moment of the forces about that normal, centroid_z_mm the centroid of the load. Positions, signs and units as in the product: mesh position 0 touches at the pitch
point at mid-face, ste_um is on the transverse line of action, loads are torque (N m) and misalignment (mrad); edge_share is the
share of the load within three cells of a tip edge. flank_pressure_mpa is that of the half-ellipse with the force and spread of the
faces across the contact line, away from tip edges. It is null where contact there is too narrow to be resolved, or where it would be that of
a contact that all but reaches an edge or whose line runs obliquely within 0.5 mm of it. Elsewhere rows of faces follow the contact line, whose
obliqueness is no part of the spread; but where it crosses the knee of a linear relief or runs over a tip edge, load and place change along a
layer, hence graded layers of helical pairs, with one face along each: of two, one bears and the other does not, by turns, and their
spread tells nothing. A contact that leaves the band of fine cells is refused: in a band of 0.36 mm the ring's was cut at 200 N m, its
transmission error 0.3 % and its pressure 8 % too large. Finer cells across the tooth and in the body raise the transmission error of the 13
degree pair by 0.1 %. A position of a graded helical pair takes three to six minutes and 16 GB, one of the wide spur pair three to four minutes,
of the others less than one. Where both gears are alike, the other half of the mesh cycle mirrors that of the data.
"""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import deformed as finite
from deformed import Deformed
from flank_mesh import FlankMesh, Mesh
from pair import Pair

DATA = Path(__file__).parents[2] / "tests/data"
GAUSS = 4  # points along the flank of a face, 3 along the width
CELLS = 6  # across a contact, so that its spread tells its pressure


class Contact:
    """Pressures on the faces of one mesh position: gap, compliance and arms; any modification, torque and misalignment follow."""

    def __init__(self, pair, position, layers=None, parts=2, mesh=Mesh(), limit=0.04):
        """`layers`: ends along the face, mm, of a spur pair those up to mid-face (None: plane strain), each with `parts` faces;
        `limit`: gaps up to it may close, mm."""
        self.pair, self.position = pair, position
        self.plane = layers is None
        half = not self.plane and pair.lean == 0.0
        layers = np.array([0.0, pair.b]) if self.plane else np.asarray(layers)
        zs = np.linspace(0, pair.b, 201)
        self.pairs = [k for k in range(-6, 7) if self.lines(k, zs)[2].min() < limit]
        meshes = []
        for gear in (0, 1):
            sign = 1 if gear == 0 else -1
            lines = {sign * k: (lambda z, k=k, gear=gear: self.lines(k, z)[gear]) for k in self.pairs}
            meshes.append(FlankMesh(pair.gears[gear], layers, lines, mesh, self.plane, half))
        self.faces(meshes, layers, 1 if self.plane else parts, mesh, limit)
        self.points = [tuple(np.concatenate(v) for v in zip(*of)) for of in self.points]
        if half:
            self.each += [dict(f, z=pair.b - f["z"], zs=pair.b - f["zs"], lever=-f["lever"], layer=2 * len(layers) - 3 - f["layer"]) for f in self.each]
        for name in ("gap", "arm", "area", "lever", "length", "width", "arc", "z", "tooth", "row", "layer", "edge", "end", "follows"):
            setattr(self, name, np.array([f[name] for f in self.each]))
        first = meshes[0].condensed(self.points[0])
        swap = self.reflection(layers if not half else np.r_[layers, pair.b - layers[-2::-1]])
        self.compliance = first + (meshes[1].condensed(self.points[1]) if swap is None else first[np.ix_(swap, swap)])
        self.unknowns = [m.size for m in meshes]

    def reflection(self, layers):
        """Numbers of the faces in the point reflection that swaps equal gears at mesh positions 0 and 1/2; None elsewhere."""
        g1, g2 = self.pair.gears
        same = all(getattr(g1, n) == getattr(g2, n) for n in ("z", "x", "tip", "root", "held", "rho")) and not self.pair.ring
        if not same or self.position not in (0.0, 0.5) or not np.allclose(layers, self.pair.b - layers[::-1]):
            return None
        name = lambda tooth, z, row, gear: (int(tooth), round(float(z), 6), int(row), int(gear))
        number = {name(f["tooth"], f["z"], f["row"], f["gear"]): i for i, f in enumerate(self.each)}
        of = [name(-f["tooth"] - round(2 * self.position), self.pair.b - f["z"], f["row"], 1 - f["gear"]) for f in self.each]
        return [number[n] for n in of] if all(n in number for n in of) else None

    def lines(self, k, z):
        """Radii on both gears where pair k is closest, and the gap there (transverse)."""
        p = self.pair
        path = p.path(self.position, k, z)
        radii, gap = [], 0.0
        for e in (0, 1):
            g, mate = p.gears[e], p.gears[1 - e]
            own = path > 0 if e == 0 else path <= 0
            r = p.nominal_radius(e, path)
            beyond = g.kappa * (r - g.tip) > 0
            r = np.where(beyond, g.tip, r)
            apart, roll, _, _ = p.foot(e, self.position, k, r, z)
            radii.append((np.where(own, r, 0.0), np.where(own, np.hypot(mate.rb, roll), 0.0)))
            gap = gap + np.where(own & beyond, apart, 0.0)
        return radii[0][0] + radii[1][1], radii[0][1] + radii[1][0], gap

    def faces(self, meshes, layers, parts, mesh, limit):
        """Faces on the flank whose tip is near, and their points on both gears."""
        self.each, self.points = [], ([], [])
        xi, weight_xi = np.polynomial.legendre.leggauss(GAUSS)
        zeta, weight_zeta = np.polynomial.legendre.leggauss(3)
        self.local = [v.ravel() for v in np.meshgrid(xi, zeta, indexing="ij")]
        self.weight = 0.25 * np.outer(weight_xi, weight_zeta).ravel()
        for k in self.pairs:
            for layer, (low, high) in enumerate(zip(layers[:-1], layers[1:])):
                gear = 0 if self.pair.path(self.position, k, 0.5 * (low + high)) > 0 else 1
                for part in range(parts):
                    ends = low + (high - low) * np.array([part, part + 1]) / parts
                    for row in range(len(meshes[gear].tooth[k if gear == 0 else -k][1])):
                        self.face(meshes, gear, k, row, ends, mesh, limit, layer)

    def face(self, meshes, e, k, row, ends, mesh, limit, layer):
        """One face between `ends` along the width on the row of cells `row` of gear e, unless it is no candidate."""
        p, number, sector = self.pair, len(self.each), (k, -k)
        g, m = p.gears[e], p.gears[1 - e]
        middle, width = ends.mean(), ends[1] - ends[0]
        z = middle + 0.5 * width * self.local[1]

        def along(row):
            edges = np.array([meshes[e].radius(sector[e], row, s, np.array([middle]))[0] for s in (-1.0, 1.0)])
            rolls = np.sqrt(np.maximum(edges**2 - g.rb**2, 0.0))
            return edges, rolls, abs(rolls[1] ** 2 - rolls[0] ** 2) / (2 * g.rb)

        edges, rolls, length = along(row)
        if length > 1.5 * mesh.cell or g.kappa * (edges[0] - meshes[e].profile.form_radius) < 0:
            return
        r = meshes[e].radius(sector[e], row, self.local[0], z)
        gap, roll, normal, arm = p.foot(e, self.position, k, r, z)
        mate = np.hypot(m.rb, roll)
        beyond_tip = m.kappa * (mate - m.tip) > 1e-9
        below_form = (roll < 0) | (m.kappa * (mate - meshes[1 - e].profile.form_radius) < 0)
        if self.weight @ gap > limit or beyond_tip.any() or below_form.any():
            return
        # Forces along the normal of the mate's flank, which leans along the face.
        axial = 0.0 if self.plane else -m.rb * p.twist[1 - e]
        for gear, radius, sign in ((e, r, 1.0), (1 - e, mate, -1.0)):
            # The tooth of the mesh stands elsewhere than that of the gear.
            stands = sector[gear] * 2 * np.pi / p.gears[gear].z + p.twist[gear] * z
            n = sign * p.turned(gear, normal) * np.exp(1j * (stands - p.tooth_angle(gear, self.position, k, z)))
            direction = p.cos_base * np.stack([n.real, n.imag, np.full(n.size, sign * axial)], 1)
            same = np.ones(n.size, int)
            self.points[gear].append((same * sector[gear], radius, z, direction, self.weight, same * number))
        own = np.sqrt(r**2 - g.rb**2)
        beside = [other for other in (row - 1, row + 1) if 0 <= other < len(meshes[e].tooth[sector[e]][1])]
        self.each.append(dict(
            tooth=k, row=row, gear=e, layer=layer, z=middle, zs=z, rolls=(own, roll) if e == 0 else (roll, own), length=length, width=width,
            gap=self.weight @ gap * p.cos_base, arm=self.weight @ arm * p.cos_base,
            lever=self.weight @ p.lever(e, self.position, k, r, z, p.cos_base * normal, p.cos_base * axial), area=length * width / p.cos_base,
            arc=(rolls**2).mean() / (2 * g.rb), edge=abs(edges[1] - g.tip) < 3 * mesh.cell,
            end=any(along(other)[2] > 1.5 * mesh.cell for other in beside),
            follows=p.lean == 0.0 or meshes[e].follows[sector[e]][2 * layer : 2 * layer + 3].all()))

    def solve(self, torque, misalignment=0.0, pair=None):
        """Torque N m on gear 1, misalignment mrad. `pair`: the same gears with other modifications."""
        pair, w = pair or self.pair, self.weight
        removal = np.array([w @ sum(pair.removal(e, f["rolls"][e], f["zs"]) for e in (0, 1)) for f in self.each])
        gap = self.gap + removal - 1e-3 * misalignment * self.lever
        force, turn = complementarity(self.compliance, gap, self.arm, 1e3 * torque)
        if force[self.end].any():
            raise RuntimeError(f"{self.pair} at {self.position}, {torque} N m: contact leaves the band of fine cells")
        return dict(ste_um=1e3 * turn * pair.gears[0].rb, centroid_z_mm=force @ self.z / force.sum(),
                    contact_z_mm=0.5 * pair.b + force @ self.lever / (1e3 * torque / pair.gears[0].rb),
                    flank_pressure_mpa=self.peak(force), edge_share=force[self.edge].sum() / force.sum())

    def peak(self, force):
        """Largest pressure away from tip edges: of the half-ellipses with the force and spread of the faces across a layer. In layers
        longer than 1 mm, along the face where the parabola through the line loads of a layer and its neighbours has its top. None where
        contact there is less than `CELLS` cells wide, where it would be that of a contact that has all but reached an edge, and where
        the rows, held off an edge, do not follow the line: faces then bear as steps of a stair."""
        largest, beside_edge, cells = 0.0, 0.0, 0.0
        for tooth in np.unique(self.tooth[force > 0]):
            on = self.tooth == tooth
            layers = np.unique(self.layer[on & (force > 0)])
            columns = [np.flatnonzero(on & (self.layer == n)) for n in layers]
            parts = [[at[self.z[at] == z] for z in np.unique(self.z[at])] for at in columns]
            width = np.array([sum(self.width[part[0]] for part in layer) for layer in parts])
            load = np.array([force[at].sum() for at in columns]) / width
            middle = np.array([np.mean([self.z[part[0]] for part in layer]) for layer in parts])
            for n, at in enumerate(columns):
                at_edge = force[at][self.edge[at]].sum() / force[at].sum()
                if at_edge > 0.5:
                    continue
                # The contact line may be oblique, and the pressure is constant over each face.
                spread = 0.0
                for part in (part for part in parts[n] if force[part].any()):
                    f, s = force[part], self.arc[part]
                    spread += f @ ((s - f @ s / f.sum()) ** 2 + self.length[part] ** 2 / 12)
                half_width = 2 * np.sqrt(spread / force[at].sum())
                top = load[n]
                if width[n] > 1.0 and 0 < n < len(columns) - 1 and load[n] >= max(load[n - 1], load[n + 1]):
                    # Averages of 1, z and z^2 over the three layers, z from the middle of this one.
                    z, w = middle[n - 1 : n + 2] - middle[n], width[n - 1 : n + 2]
                    a, b, c = np.linalg.solve(np.stack([np.ones(3), z, z**2 + w**2 / 12], 1), load[n - 1 : n + 2])
                    top = a - b**2 / (4 * c) if c < 0 else top
                # A half-ellipse of more load is wider in proportion to its height.
                pressure = 2 * self.pair.cos_base * np.sqrt(load[n] * top) / (np.pi * half_width)
                if at_edge > 0 or not self.follows[at].all():
                    beside_edge = max(beside_edge, pressure)
                elif pressure > largest:
                    largest, cells = pressure, 2 * half_width / self.length[at].max()
        return largest if largest > beside_edge and cells > CELLS else None


def complementarity(c, gap, arm, torque):
    """Forces f >= 0 and the turn of gear 1: gap + C f - arm turn >= 0, one of the two zero, arm f = torque."""
    active = gap < np.sort(gap)[len(gap) // 8]
    for _ in range(200):
        i = np.flatnonzero(active)
        k = np.zeros((len(i) + 1, len(i) + 1))
        k[:-1, :-1], k[:-1, -1], k[-1, :-1] = c[np.ix_(i, i)], -arm[i], arm[i]
        x = np.linalg.solve(k, np.r_[-gap[i], torque])
        force = np.zeros(len(gap))
        force[i] = x[:-1]
        open_ = gap + c @ force - arm * x[-1]
        pull, press = active & (force < 0), ~active & (open_ < -1e-12)
        if not pull.any() and not press.any():
            return force, x[-1]
        active = (active & ~pull) | press
    raise RuntimeError("the contact did not settle")


def spur(addendum=1.0, teeth=(20, 20), module=4.0, alpha=20.0, b=25.0, bores=(30.0, 30.0), helix=0.0, dedendum=1.25, tool=0.38, torque=200.0, **gears):
    """A pair file; `gears`: fields that both gears or one of them (gear1, gear2) have beside these."""
    each = [dict(teeth=z, face_width_mm=b, addendum_coefficient=addendum, dedendum_coefficient=dedendum, tool_tip_radius_coefficient=tool,
                 bore_diameter_mm=d) for z, d in zip(teeth, bores)]
    for i, gear in enumerate(each):
        gear.update({k: v for k, v in gears.items() if not k.startswith("gear")}, **gears.get(f"gear{i + 1}", {}))
    return dict(name="reference", meshing="external", normal_module_mm=module, normal_pressure_angle_deg=alpha, helix_angle_deg=helix,
                gear1=each[0], gear2=each[1], operating=dict(nominal_torque_nm=0.5 * torque, maximum_torque_nm=torque,
                                                             center_distance_offset_um=[-100.0, 100.0], misalignment_mrad=[-2.0, 2.0]))


def late_relief(amount, share=0.2, shape="linear"):
    """Tip relief over the last `share` of the path of contact of 20/20 teeth of module 4."""
    pair = Pair(spur())
    g = pair.gears[0]
    tip = np.sqrt(g.tip**2 - g.rb**2)
    begin = tip - share * 2 * (tip - pair.roll[0])
    return dict(tip_relief=dict(amount_um=amount, start=dict(diameter_mm=round(2 * float(np.hypot(g.rb, begin)), 6)), shape=shape))


def graded(pair, position, least=0.45, growth=0.35, most=1.0):
    """Ends of layers along the face of a helical pair, mm: of the length `least` at the landmarks, growing away from them by `growth`
    for each mm up to `most`; alike from both ends where the landmarks are."""
    z = np.linspace(0.0, pair.b, 4001)
    size = np.minimum(most, least + growth * np.abs(z[:, None] - pair.landmarks(position)).min(1))
    count = np.r_[0.0, np.cumsum(0.5 * (1 / size[1:] + 1 / size[:-1]) * np.diff(z))]
    ends = np.round(np.interp(np.linspace(0.0, count[-1], int(np.ceil(count[-1])) + 1), count, z), 3)
    if np.allclose(ends, pair.b - ends[::-1], atol=2e-3):
        ends = np.round(0.5 * (ends + pair.b - ends[::-1]), 4)
    return ends


def thin(pair, position):
    """Such layers where those of 0.45 mm tell the pressure up to 5 % too large: at landmarks of 30 degrees and the ring."""
    return graded(pair, position, least=0.25)


def family(cases, positions, layers=None, mesh=Mesh(), offset=0.0, parts=2, limit=0.04):
    """Cases on the same elastic models: name, title, pair, loads (N m, mrad). Each position goes into the file as it is found.
    `layers`: ends along the face, or `graded`."""
    out = {name: dict(title=title, pair=pair, plane_strain=layers is None, center_distance_offset_um=offset, loads=loads, positions=[])
           for name, title, pair, loads in cases}
    for position in positions:
        first = Pair(cases[0][2], offset)
        ends = layers(first, position) if callable(layers) else layers
        contact = Contact(first, position, ends, parts, mesh, limit)
        for name, title, pair, loads in cases:
            found = [contact.solve(*load, pair=Pair(pair, offset)) for load in loads]
            row = dict(mesh_position=position)
            for key, digits in (("ste_um", 4), ("contact_z_mm", 4), ("centroid_z_mm", 4), ("flank_pressure_mpa", 1), ("edge_share", 3)):
                row[key] = [None if f[key] is None else round(float(f[key]), digits) for f in found]
            out[name]["positions"].append(row)
            print(name, position, contact.unknowns, len(contact.gap), row["ste_um"], row["flank_pressure_mpa"], file=sys.stderr, flush=True)
        write(out)


def deformed(name, title, pair, teeth, meshes, large, loads, positions):
    """A case with finite rotations; gear 1 and gear 2 turn alike, and the torque is the mean of both, as in the product. Loads ascend."""
    case = dict(title=title, pair=pair, plane_strain=True, both_turn=True, center_distance_offset_um=0.0, loads=loads, positions=[])
    contact, b = Deformed(pair, teeth, meshes, large), pair["gear1"]["face_width_mm"]
    for position in positions:
        contact.forget()
        row = dict(mesh_position=position, ste_um=[], contact_z_mm=[0.5 * b] * len(loads), flank_pressure_mpa=[], edge_share=[])
        for torque, _ in loads:
            total = 1e3 * torque / contact.pair.gears[0].rb
            approach, force, each = contact.solve(position, total, complementarity)
            row["ste_um"].append(round(float(1e3 * approach), 4))
            row["flank_pressure_mpa"].append(largest_pressure(force / b, each))
            row["edge_share"].append(round(float(sum(f for f, e in zip(force, each) if e["edge"]) / force.sum()), 3))
        case["positions"].append(row)
        print(name, row, file=sys.stderr, flush=True)
        write({name: case}, "plastic_reference.json", finite.__doc__)


def largest_pressure(line_load, each):
    """As `Contact.peak`, in plane strain: None where the largest is next to an edge or less than `CELLS` cells wide."""
    largest, beside_edge, cells = 0.0, 0.0, 0.0
    for tooth in {e["tooth"] for e in each}:
        on = [i for i, e in enumerate(each) if e["tooth"] == tooth and line_load[i] > 0]
        if not on:
            continue
        w, s, length = line_load[on], *(np.array([each[i][key] for i in on]) for key in ("arc", "length"))
        half_width = 2 * np.sqrt(w @ ((s - w @ s / w.sum()) ** 2 + length**2 / 12) / w.sum())
        pressure = 2 * w.sum() / (np.pi * half_width)
        if any(each[i]["edge"] for i in on):
            beside_edge = max(beside_edge, pressure)
        elif pressure > largest:
            largest, cells = pressure, 2 * half_width / length.max()
    return round(float(largest), 1) if largest > beside_edge and cells > CELLS else None


def write(found, name="contact_reference.json", description=__doc__):
    """Adds cases to the file `name`, in the order of their positions."""
    output = DATA / name
    for case in found.values():
        case["positions"].sort(key=lambda row: row["mesh_position"])
    known = json.loads(output.read_text())["cases"] if output.exists() else {}
    text = json.dumps(dict(description=" ".join(description.split()), cases={**known, **found}))
    output.write_text(text.replace('{"mesh_position"', '\n {"mesh_position"').replace('{"title"', '\n{"title"') + "\n")


FLAT = replace(Mesh(), cell=0.012, band=70, side=16, across=18, body=10)
# Where a tip edge bears: the mean gap of a face of the length l at an edge inclined by alpha is alpha l / 2 more than at the edge.
SHARP = replace(Mesh(), cell=0.003, band=150, side=24, across=20, body=10, edge=0.001)
BROAD = replace(SHARP, cell=0.004, band=220)
SOLID = Mesh(cell=0.02, band=24, side=9, across=11, body=6)
CROSSED = [(torque, m) for torque in (100.0, 200.0) for m in (-2.0, -1.0, 0.0, 1.0, 2.0)]
HALF = [0, 0.6, 1.6, 3.4, 6, 9.2, 12.5]


# A tilt of 1 mrad lets contact end within the face: in layers twice as long the transmission error at position 0.5 is 0.022 um more.
FINE_HALF = [0, 0.3, 0.6, 1.1, 1.6, 2.4, 3.4, 4.6, 6, 7.6, 9.5, 11.4, 13.5, 16, 18.5, 21.2, 24]
TILTED = [(torque, m) for torque in (200.0, 400.0) for m in (-1.0, 0.0, 1.0)]
# With 6 cells beside the band instead of 10 the transmission error of the 13 degree pair is 0.9 % too small.
OBLIQUE = Mesh(cell=0.024, band=28, side=10, across=9, body=5)
RING = dict(name="ring", meshing="internal", normal_module_mm=3.0, normal_pressure_angle_deg=20.0, helix_angle_deg=15.0,
            gear1=dict(teeth=20, face_width_mm=18.0, bore_diameter_mm=40.0, lead_crowning_um=4.0, tip_relief=dict(amount_um=12.0, start="pitch_point", shape="linear")),
            gear2=dict(teeth=60, face_width_mm=18.0, tip_diameter_mm=182.0, rim_diameter_mm=206.0),
            operating=dict(nominal_torque_nm=100.0, maximum_torque_nm=200.0, center_distance_offset_um=[0.0, 0.0], misalignment_mrad=[-1.0, 1.0]))


def helical(helix):
    return spur(b=20.0, helix=helix, tip_relief=dict(amount_um=12.0, start="pitch_point", shape="linear"), gear1=dict(lead_crowning_um=5.0))


HELICAL = helical(30.0)
SHIFTED = dict(name="shifted", meshing="external", normal_module_mm=4.5, normal_pressure_angle_deg=20.0, center_distance_mm=91.5,
               gear1=dict(teeth=16, profile_shift=0.1817, face_width_mm=14.0, tip_diameter_mm=82.45, bore_diameter_mm=30.0),
               gear2=dict(teeth=24, profile_shift=0.1715, face_width_mm=14.0, tip_diameter_mm=118.35, bore_diameter_mm=50.0),
               operating=dict(nominal_torque_nm=300.0, maximum_torque_nm=450.0, center_distance_offset_um=[-50.0, 50.0], misalignment_mrad=[-1.0, 1.0]))
SPUR_RING = dict(name="spur ring", meshing="internal", normal_module_mm=3.0, normal_pressure_angle_deg=20.0,
                 gear1=dict(teeth=20, face_width_mm=20.0, bore_diameter_mm=40.0),
                 gear2=dict(teeth=60, face_width_mm=20.0, tip_diameter_mm=174.8, rim_diameter_mm=200.0),
                 operating=dict(nominal_torque_nm=200.0, maximum_torque_nm=300.0, center_distance_offset_um=[-50.0, 50.0], misalignment_mrad=[-1.0, 1.0]))
PAPER = spur(b=25.0, helix=13.0, tip_diameter_mm=90.315)
PAPER["center_distance_mm"] = 82.104
for of in (PAPER["gear1"], PAPER["gear2"]):
    del of["addendum_coefficient"]


def torques(*values):
    return [(v, 0.0) for v in values]


CYCLE = torques(50.0, 100.0, 200.0) + [(100.0, -1.0), (100.0, 1.0)]

# The wheel of a published pair of steel and plastic.
PLASTIC = dict(name="plastic", meshing="external", normal_module_mm=1.0, normal_pressure_angle_deg=20.0, helix_angle_deg=0.0, center_distance_mm=52.0,
               gear1=dict(teeth=51, profile_shift=-0.203, face_width_mm=10.0, tool_tip_radius_coefficient=0.2, bore_diameter_mm=30.0),
               gear2=dict(teeth=52, profile_shift=0.0117, face_width_mm=10.0, tool_tip_radius_coefficient=0.2, bore_diameter_mm=36.2, youngs_modulus_gpa=2.282),
               operating=dict(nominal_torque_nm=5.0, maximum_torque_nm=10.5, center_distance_offset_um=[0.0, 0.0], misalignment_mrad=[0.0, 0.0]))
# A case-hardened first stage of a car: sigma_H0 of ISO 6336-2 is 1480 MPa.
CAR = dict(name="car pinion", meshing="external", normal_module_mm=2.0, normal_pressure_angle_deg=20.0, helix_angle_deg=0.0, center_distance_mm=60.0,
           gear1=dict(teeth=17, profile_shift=0.3, face_width_mm=20.0, bore_diameter_mm=18.0,
                      tip_relief=dict(amount_um=25.0, start=dict(diameter_mm=37.4), shape="parabolic")),
           gear2=dict(teeth=43, profile_shift=-0.3, face_width_mm=20.0, bore_diameter_mm=40.0,
                      tip_relief=dict(amount_um=25.0, start=dict(diameter_mm=86.9), shape="parabolic")),
           operating=dict(nominal_torque_nm=100.0, maximum_torque_nm=100.0, center_distance_offset_um=[0.0, 0.0], misalignment_mrad=[0.0, 0.0]))

# Equal gears without misalignment: the other half of the cycle mirrors this one.
FAMILIES = {
    "plastic": lambda: deformed(
        "plastic", "spur 51/52, steel on plastic, finite rotations, plane strain", PLASTIC, range(-3, 4),
        [Mesh(cell=0.05, side=6, across=6, edge=0.01), Mesh(cell=0.03, side=6, across=8, edge=0.006)], [False, True], torques(1.0, 4.0, 10.0),
        [0.0, 0.5, 0.25, 0.75, 0.125, 0.375, 0.625, 0.875] + [i / 16 for i in range(1, 16, 2)]),
    "car-pinion": lambda: family(
        [("car-pinion", "spur 17/43, tip relief, sigma_H0 1480 MPa, plane strain", CAR, torques(50.0, 100.0))],
        [0.0, 0.5, 0.25, 0.75, 0.125, 0.375, 0.625, 0.875], mesh=FLAT, limit=0.08),
    "relief": lambda: family(
        [(f"relief-{n}", f"spur 20/20, {n} um of tip relief over a fifth of the path, plane strain", spur(**late_relief(n)), torques(25.0, 50.0, 100.0, 200.0))
         for n in (8, 25, 30)], [i / 32 for i in range(17)], mesh=FLAT),
    "parabolic-relief": lambda: family(
        [("relief-30-parabolic", "spur 20/20, 30 um of parabolic tip relief over a fifth of the path, plane strain",
          spur(**late_relief(30, shape="parabolic")), torques(50.0, 100.0, 200.0))], [i / 16 for i in range(7)] + [i / 32 for i in (13, 14, 15, 16)], mesh=FLAT),
    "tip-edge": lambda: family(
        [("tip-edge", "spur 20/20, plane strain", spur(), torques(25.0, 50.0, 100.0, 200.0))],
        [i / 16 for i in range(9)] + [i / 128 for i in (23, 25, 26, 27, 28, 29)], mesh=SHARP),
    "shifted": lambda: family(
        [("shifted", "spur 16/24 with profile shift, plane strain", SHIFTED, torques(75.0, 150.0, 300.0, 450.0))],
        [i / 8 for i in range(8)] + [13 / 64, 49 / 64], mesh=BROAD, limit=0.08),
    "internal": lambda: family(
        [("internal", "internal 20/60, plane strain", SPUR_RING, torques(50.0, 100.0, 200.0, 300.0))],
        [i / 8 for i in range(8)], mesh=BROAD),
    "centre-distance": lambda: [family(
        [(f"centre-distance{offset:+.0f}", f"spur 20/20, centre distance {offset:+.0f} um, plane strain", spur(), torques(50.0, 100.0, 200.0))],
        [i / 16 for i in range(9)], mesh=SHARP, offset=offset) for offset in (-100.0, 100.0)],
    "high-contact-ratio": lambda: family(
        [("high-contact-ratio", "spur 40/40, contact ratio above 2, plane strain",
          spur(teeth=(40, 40), alpha=17.5, addendum=1.25, dedendum=1.5, tool=0.25, bores=(80.0, 80.0), torque=800.0), torques(200.0, 400.0, 800.0))],
        [i / 16 for i in range(9)], mesh=FLAT),
    "solid": lambda: family(
        [("solid-relief-30", "spur 20/20, 30 um of tip relief over a fifth of the path, solid", spur(**late_relief(30)), torques(25.0, 50.0, 100.0, 200.0)),
         ("solid-crowned", "spur 20/20, 8 um of lead crowning, solid", spur(gear1=dict(lead_crowning_um=8.0)), CROSSED)],
        [0.0, 0.5, 0.25, 0.125, 0.375], layers=HALF, mesh=SOLID),
    "wide": lambda: family(
        [("wide", "spur 20/20, face 12 modules, 5 um of lead crowning, solid", spur(b=48.0, gear1=dict(lead_crowning_um=5.0), torque=400.0), TILTED)],
        [0.0, 0.5], layers=FINE_HALF, mesh=SOLID),
    "helix-13": lambda: family(
        [("helix-13", "helical 20/20, 13 degrees, unmodified, solid", PAPER, CYCLE)],
        [0.5, 0.0, 0.25, 0.125, 0.375], layers=graded, mesh=OBLIQUE, parts=1, limit=0.035),
    "helix-25": lambda: family(
        [("helix-25", "helical 20/20, 25 degrees, tip relief and lead crowning, solid", helical(25.0), CYCLE)],
        [0.0, 0.25, 0.375, 0.125, 0.5], layers=graded, mesh=OBLIQUE, parts=1, limit=0.035),
    "helix-30": lambda: family(
        [("helix-30", "helical 20/20, 30 degrees, tip relief and lead crowning, solid", HELICAL, CYCLE)],
        [0.0, 0.25, 0.375, 0.5], layers=thin, mesh=OBLIQUE, parts=1, limit=0.035),
    "internal-helical": lambda: family(
        [("internal-helical", "internal helical 20/60, 15 degrees, tip relief and lead crowning, solid", RING, torques(50.0, 100.0, 200.0))],
        [0.0, 0.25, 0.125, 0.5, 0.75, 0.625], layers=thin, mesh=replace(OBLIQUE, cell=0.03, band=27), parts=1, limit=0.035),
}


if __name__ == "__main__":
    for chosen in sys.argv[1:] or FAMILIES:
        FAMILIES[chosen]()
