"""A gear pair of involute teeth: where flanks touch, how far apart they are, and the material removed from them. Lengths in mm."""

from math import acos, cos, hypot, pi, radians, sqrt, tan

import numpy as np

from teeth import Gear


def read_gear(pair, name):
    """A gear of a pair file."""
    of = pair[name]
    m, beta = pair["normal_module_mm"], pair.get("helix_angle_deg", 0.0)
    ring = "rim_diameter_mm" in of
    kappa, x, z = -1 if ring else 1, of.get("profile_shift", 0.0), of["teeth"]
    r = 0.5 * z * m / cos(radians(beta))
    tip = 0.5 * of["tip_diameter_mm"] if "tip_diameter_mm" in of else r + m * (x + kappa * of.get("addendum_coefficient", 1.0))
    held = 0.5 * of["rim_diameter_mm" if ring else "bore_diameter_mm"]
    sign = -1 if name == "gear2" else 1
    return Gear(z, m, pair["normal_pressure_angle_deg"], sign * beta, x, of.get("dedendum_coefficient", 1.25),
                of.get("tool_tip_radius_coefficient", 0.38), tip, held, of["face_width_mm"], ring)


class Pair:
    """Gear 1 at the origin, gear 2 on the +x axis (a ring: at -x). Gear 1 turns in +theta and drives."""

    def __init__(self, pair, centre_distance_offset=0.0):
        self.file, self.gears = pair, [read_gear(pair, name) for name in ("gear1", "gear2")]
        g1, g2 = self.gears
        self.ring, self.b = g2.ring, g1.b
        self.base = [g.rb for g in self.gears]
        total = g2.rb - g1.rb if self.ring else g1.rb + g2.rb
        shift = (g2.x - g1.x if self.ring else g1.x + g2.x)
        assert "center_distance_mm" in pair or shift == 0.0, "name the centre distance"
        nominal = pair.get("center_distance_mm", abs(g2.r - g1.r) if self.ring else g1.r + g2.r)
        self.a = nominal + 1e-3 * centre_distance_offset
        self.pitch = 2 * pi * g1.rb / g1.z
        self.lean = tan(g1.beta) / g1.r * g1.rb  # of the contact line in the plane of action
        self.cos_base = 1 / hypot(1.0, self.lean)
        self.twist = [g.twist for g in self.gears]
        # Flanks touch at the pitch point of the nominal centre distance at mid-face.
        self.alpha = acos(total / self.a)
        self.roll = [g.rb * tan(self.alpha) for g in self.gears]
        rw = g1.rb / cos(self.alpha)
        self.nominal_roll = [g.rb * tan(acos(total / nominal)) for g in self.gears]
        self.middle = []
        for e in (0, 1):
            q = complex(self.local(e, complex(rw, 0.0)))
            self.middle.append(np.angle(q) - self.gears[e].flank(abs(q)))

    def local(self, gear, point):
        """A point (complex) of the world in the frame of a gear, where loaded flanks face +theta."""
        return point if gear == 0 else np.conj(point + self.a) if self.ring else self.a - point

    def world(self, gear, point):
        """The way back."""
        return point if gear == 0 else np.conj(point) - self.a if self.ring else self.a - point

    def turned(self, gear, vector):
        """A vector of the world in the frame of a gear, or back."""
        return vector if gear == 0 else np.conj(vector) if self.ring else -vector

    def path(self, position, k, z):
        """Distance of the contact of tooth pair k from the pitch point, towards the tip of gear 1."""
        return (position + k) * self.pitch + self.lean * (z - 0.5 * self.b)

    def landmarks(self, position):
        """Where along the face (helical pairs) loads change within less than a millimetre: its ends, where contact lines cross
        the pitch point, at which reliefs may begin, and where they run over tip edges; mm, ascending."""
        path = [0.0]
        for gear, sign in ((0, 1), (1, 1 if self.ring else -1)):
            path.append(sign * (sqrt(self.gears[gear].tip ** 2 - self.base[gear] ** 2) - self.roll[gear]))
        middle = [s - (position + k) * self.pitch for s in path for k in range(-9, 10)]
        z = 0.5 * self.b + np.array(middle) / self.lean
        return np.sort(np.r_[0.0, z[(z > 0) & (z < self.b)], self.b])

    def tooth_angle(self, gear, position, k, z):
        """Angle of the middle of pair k's tooth at z."""
        turn = (position + k) * self.pitch / self.base[gear] * (1 if gear == 0 else -1)
        return self.middle[gear] + turn + self.twist[gear] * (z - 0.5 * self.b)

    def nominal_radius(self, gear, path):
        sign = -1 if gear == 1 and not self.ring else 1
        return np.hypot(self.base[gear], np.maximum(self.roll[gear] + sign * path, 0.0))

    def foot(self, gear, position, k, r, z):
        """From points of gear's flank to the mate's: gap (transverse), roll there, its normal in the world, and the arm about gear 1."""
        mate, g, m = 1 - gear, self.gears[gear], self.gears[1 - gear]
        angle = self.tooth_angle(gear, position, k, z) + g.flank(r)
        point = self.world(gear, r * np.exp(1j * angle))
        q = self.local(mate, point)
        radius = np.maximum(np.abs(q), m.rb)
        alpha = np.arccos(m.rb / radius)
        middle = self.tooth_angle(mate, position, k, z)
        apart = np.angle(q * np.exp(-1j * middle)) - m.flank(radius)
        gap = m.rb * apart
        normal = self.turned(mate, q / np.abs(q) * (m.kappa * np.sin(alpha) + 1j * np.cos(alpha)))
        roll = np.sqrt(radius**2 - m.rb**2) - m.kappa * gap
        arm = np.abs((np.conj(point) * normal).imag)
        return gap, roll, normal, arm

    def lever(self, gear, position, k, r, z, normal, axial):
        """By how much points of gear's flank close along the normal (`normal` in the transverse plane of the world, `axial` along z; out
        of the mate), where gear 2 turns about the normal of the plane of action through the pitch point at mid-face, over the angle, mm."""
        point = self.world(gear, r * np.exp(1j * (self.tooth_angle(gear, position, k, z) + self.gears[gear].flank(r))))
        along = 1j * np.exp(-1j * self.alpha)  # the line of action, as the force on gear 2 points
        y = ((point - self.base[0] / cos(self.alpha)) * np.conj(along)).real
        sign = -1.0 if gear == 0 else 1.0  # the force on gear 2
        return sign * ((z - 0.5 * self.b) * (normal * np.conj(along)).real - y * axial)

    def removal(self, gear, roll, z):
        """Material removed from a flank along its normal, mm: the fields of the pair file that the cases use."""
        of, g, mate = self.file[f"gear{gear + 1}"], self.gears[gear], 1 - gear
        known = {"tip_relief", "root_relief", "lead_crowning_um", "lead_slope_um"}
        spare = {k for k in of if "relief" in k or "crown" in k or "slope" in k or "flank" in k or "bias" in k} - known
        assert not spare, spare
        tip = sqrt(g.tip**2 - g.rb**2)
        mate_tip = sqrt(self.gears[mate].tip ** 2 - self.gears[mate].rb ** 2)
        # The start of the active profile is where the mate's tip touches at the nominal centre distance.
        sign = 1 if self.ring else -1
        start = self.nominal_roll[gear] + sign * (mate_tip - self.nominal_roll[mate])
        out = np.zeros(np.broadcast(roll, z).shape)
        for name, end in (("tip_relief", tip), ("root_relief", start)):
            if name not in of:
                continue
            relief = of[name]
            power = {"linear": 1, "parabolic": 2}[relief.get("shape", "linear")]
            at = relief.get("start", "pitch_point")
            begin = self.nominal_roll[gear] if at == "pitch_point" else sqrt((0.5 * at["diameter_mm"]) ** 2 - g.rb**2)
            out = out + 1e-3 * relief["amount_um"] * np.maximum((roll - begin) / (end - begin), 0.0) ** power
        share = 2 * z / self.b - 1
        return out + 1e-3 * (of.get("lead_crowning_um", 0.0) * share**2 + 0.5 * of.get("lead_slope_um", 0.0) * share)
