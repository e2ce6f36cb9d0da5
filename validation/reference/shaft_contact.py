"""Teeth and shaft together by finite elements, apart from the program: writes tests/data/shaft_contact.json.

    python validation/reference/shaft_contact.py      # a quarter of an hour on two cores

The shaft is the intermediate shaft of Budynas, Nisbett, Shigley's Mechanical Engineering Design, 9th ed., Example 7-2, Figure 7-10,
with its gear 4 alone (d_4 = 2.67 in, two inches wide, 2431 lbf): 16 teeth of six to the inch, which is not in the example, against 72 on a
rigid shaft. Teeth and what is left of the pinion around the shaft are the hexahedra of contact.py, the shaft is the solid of
revolution of shafts.py under the force and the torque of each strip of the face. What a strip bears moves and turns the
shaft at all strips; the linear complementarity problem has both compliances. The tip of gear 2 is 0.37 mm shorter than an addendum of one
module, so that the undercut of 16 teeth stays below the active profile.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from contact import SOLID, Contact, complementarity
from pair import Pair
from shafts import DIAMETERS, SHOULDERS, flexibility

OUTPUT = Path(__file__).parents[2] / "tests/data/shaft_contact.json"
INCH = 25.4
LOW, BEARINGS = 7.5, (0.75, 10.75)  # in: z = 0 face of gear 4; bearings
TORQUE = 366.2  # N m: 2431 lbf on the radius 1.333 in
FACE = 2 * INCH
MESH = replace(SOLID, cell=0.024, band=36)
# Ends of layers up to mid-face, mm; the finest at the ends of the face, where loads change most.
HALF = [0, 0.635, 1.27, 2.54, 3.81, 5.08, 7.62, 10.16, 13.97, 17.78, 21.59, 25.4]

SECTIONS = [[round(INCH * (a - LOW), 4), round(INCH * (b - LOW), 4), round(INCH * d, 4)] for a, b, d in zip(SHOULDERS, SHOULDERS[1:], DIAMETERS)]
SHAFT = {"sections": SECTIONS, "face": FACE, "root": 1.625 * INCH, "bearings": [[round(INCH * (z - LOW), 4), 1e6] for z in BEARINGS], "torque_end": "lower"}
PAIR = dict(
    name="shaft of a textbook", meshing="external", normal_module_mm=INCH / 6, normal_pressure_angle_deg=20.0, helix_angle_deg=0.0,
    center_distance_mm=44 * INCH / 6,
    gear1=dict(teeth=16, face_width_mm=FACE, tool_tip_radius_coefficient=0.3, bore_diameter_mm=SHAFT["root"]),
    gear2=dict(teeth=72, face_width_mm=FACE, tool_tip_radius_coefficient=0.3, tip_diameter_mm=312.9, bore_diameter_mm=285.0),
    operating=dict(nominal_torque_nm=TORQUE, maximum_torque_nm=550.0, center_distance_offset_um=[0.0, 0.0]))


def main():
    pair = Pair(PAIR)
    strips = sorted({round(z, 6) for low, high in zip(HALF, HALF[1:]) for z in (low, 0.5 * (low + high), high)})
    strips += [round(FACE - z, 6) for z in strips[-2::-1]]
    rows = {}
    flexible = [flexibility(SHAFT, size, strips) for size in (2.5e-3, 1.25e-3)]
    for position in (0.0, 0.5):
        contact = Contact(pair, position, HALF, 2, MESH)
        strip = np.searchsorted(strips, contact.z) - 1
        found = []
        for z, across, twist, tilt in flexible:
            # um/kN and mrad/(kN m), to mm/N.
            give = 1e-6 * across + 1e-9 * pair.gears[0].rb ** 2 * twist
            at = np.array([np.interp(contact.z, z, column) for column in give.T]).T
            force, turn = complementarity(contact.compliance + at[:, strip], contact.gap, contact.arm, 1e3 * TORQUE)
            assert not force[contact.end].any(), "contact leaves the band of fine cells"
            load = np.bincount(strip, force, len(strips) - 1)
            # Sections tilt away from gear 2 where the displacement rises.
            misalignment = -1e-3 * np.interp(0.5 * FACE, z, tilt @ load)
            found.append((load / np.diff(strips), misalignment, 1e3 * turn * pair.gears[0].rb))
        rows[position] = found
        print(position, contact.unknowns, len(contact.gap), [(round(f[0].max() / (f[0] @ np.diff(strips) / FACE), 4), f[1], f[2]) for f in found], flush=True)
        write(strips, rows)


def write(strips, rows):
    """What is known at these mesh positions so far."""
    shaft = {"start_mm": SECTIONS[0][0], "torque_end": "lower", "seat_diameter_mm": SHAFT["root"], "youngs_modulus_gpa": 206, "poisson_ratio": 0.3,
             "sections": [{"diameter_mm": d, "length_mm": round(b - a, 4)} for a, b, d in SECTIONS],
             "bearings": [{"z_mm": z, "radial_stiffness_n_per_um": k} for z, k in SHAFT["bearings"]]}
    file = {**PAIR, "gear1": {**PAIR["gear1"], "shaft": shaft}}
    positions = [{"mesh_position": p, "face_load_n_per_mm": [round(float(v), 3) for v in found[-1][0]], "misalignment_mrad": round(float(found[-1][1]), 5)}
                 for p, found in rows.items()]
    OUTPUT.write_text(json.dumps({"description": " ".join(__doc__.split()), "pair": file, "strip_ends_mm": strips, "positions": positions}) + "\n")


if __name__ == "__main__":
    main()
