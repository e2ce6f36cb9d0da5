"""Two rigid involute helicoids on a constant spring, written from the geometry alone.

The wrench is the gradient of 1/2 k delta^2 by the twelve freedoms of the gears, taken by complex steps
(W. Squire, G. Trapp, SIAM Rev. 40 (1998) 110-112): no rule of differentiation, nothing of the library's
equations for forces. SI, world axes; s = +1 drive, -1 coast flank, kappa = +1 teeth of a gear, -1 spaces of a ring.
"""

import numpy as np

STEP = 1e-30


def involute(t):
    """Involute function of the pressure angle whose tangent is `t`."""
    return t - np.arctan(t)


def angle(x, y):
    """atan2(y, x), also of complex arguments with small imaginary parts."""
    t = np.arctan2(y.real, x.real)
    return t + 1j * (y.imag * x.real - y.real * x.imag) / (x.real**2 + y.real**2)


class Flank:
    """Flanks of sign `sigma` of all teeth of one gear: G is the signed distance of a point, positive outside."""

    def __init__(self, gear, sigma, hand, thinning):
        z, beta, alpha_n = gear["teeth"], gear["helix_angle_rad"], gear["normal_pressure_angle_rad"]
        alpha_t = np.arctan(np.tan(alpha_n) / np.cos(beta))
        self.rb = 0.5 * z * gear["normal_module_m"] / np.cos(beta) * np.cos(alpha_t)
        self.beta_b = np.arctan(np.tan(beta) * np.cos(alpha_t))
        self.kappa = -1.0 if gear["kind"] == "ring" else 1.0
        self.sigma, self.helix = sigma, hand * np.tan(self.beta_b)
        psi = np.pi / (2 * z) + 2 * gear["profile_shift"] * np.tan(alpha_n) / z
        psi += involute(np.tan(alpha_t)) - self.kappa * thinning / (2 * self.rb)
        self.eta = self.kappa * sigma * psi

    def distance(self, x):
        """G at the point `x` of the body."""
        rho, theta = np.sqrt(x[0] * x[0] + x[1] * x[1]), angle(x[0], x[1])
        turned = self.rb * (theta - self.eta) - self.helix * x[2]
        inv = involute(np.sqrt((rho / self.rb) ** 2 - 1))
        return np.cos(self.beta_b) * (self.sigma * turned + self.kappa * self.rb * inv)

    def surface(self, t, zeta):
        """Point of the flank at height `zeta`: the end of a string of length rb t, unwound from the base circle."""
        sense = self.sigma * self.kappa
        at = self.eta + self.helix * zeta / self.rb - sense * t
        x, y = np.cos(at) - sense * t * np.sin(at), np.sin(at) + sense * t * np.cos(at)
        return np.array([self.rb * x, self.rb * y, zeta + 0 * t])


class Mesh:
    """The pair of resources/unit.json with the stiffness (N/m) and the backlash (m) of the FMU's parameters."""

    def __init__(self, geometry, stiffness, backlash):
        self.gears, self.c = geometry["gears"], geometry["center_distance"]
        g1, g2 = self.gears
        self.e = -1 if "ring" in (g1["kind"], g2["kind"]) else 1
        self.z = [g["teeth"] for g in self.gears]
        self.hand = [g1["hand"], -self.e * g1["hand"]]
        self.w = self.z[0] / (self.z[0] + self.e * self.z[1])
        rb = [Flank(g, 1, 1, 0.0).rb for g in self.gears]
        self.base_sum, self.base_pitch = abs(rb[0] + self.e * rb[1]), 2 * np.pi * rb[0] / self.z[0]
        # Without backlash the pressure angle phi_0 is that of the profile shifts; what the gap between both
        # flanks lacks at the nominal centre distance has been taken from the teeth, from both gears alike.
        alpha_n, beta = g1["normal_pressure_angle_rad"], g1["helix_angle_rad"]
        shifts = g1["profile_shift"] + self.e * g2["profile_shift"]
        inv_0 = involute(np.tan(alpha_n) / np.cos(beta))
        inv_0 += 2 * np.tan(alpha_n) * shifts / (self.z[0] + self.e * self.z[1])
        cos_phi = self.base_sum / self.c
        inv = involute(np.sqrt(1 / cos_phi**2 - 1))
        thinning = backlash * cos_phi - 2 * self.e * self.base_sum * (inv - inv_0)
        self.flanks = {
            s: [
                Flank(g, sigma, hand, thinning / 2)
                for g, sigma, hand in zip(self.gears, (s, self.e * s), self.hand)
            ]
            for s in (1, -1)
        }
        self.stiffness = stiffness / cos_phi**2
        self.face_offset = g2["face_offset_m"] - g1["face_offset_m"]
        low = max(g1["face_offset_m"], g2["face_offset_m"])
        high = min(g["face_offset_m"] + g["face_width_m"] for g in self.gears)
        self.z_ref = 0.5 * (low + high) - g1["face_offset_m"]

    def pitch_point(self, poses):
        """The operating pitch point at mid-face of gear 1, and the centre distance there."""
        (p1, r1), (p2, r2) = poses
        a1, a2 = r1[:, 2], r2[:, 2]
        c1 = p1 + self.z_ref * a1
        c2 = p2 + (c1 - p2) @ a1 / (a1 @ a2) * a2
        return c1 + self.w * (c2 - c1), np.sqrt((c2 - c1) @ (c2 - c1))

    def elongation(self, s, poses):
        """delta of flank `s`, along the line of action, less whole pitches."""
        x, _ = self.pitch_point(poses)
        gaps = [f.distance(r.T @ (x - p)) for f, (p, r) in zip(self.flanks[s], poses)]
        delta = -sum(gaps) / np.cos(self.flanks[s][0].beta_b)
        return delta - self.base_pitch * np.round(delta.real / self.base_pitch)

    def gradient(self, s, poses):
        """d delta by position and rotation vector of gear 1, then of gear 2."""
        out = np.zeros(12)
        for i in range(12):
            moved = [(np.array(p, complex), np.array(r, complex)) for p, r in poses]
            p, r = moved[i // 6]
            step = np.zeros(3, complex)
            step[i % 3] = 1j * STEP
            if i % 6 < 3:
                moved[i // 6] = p + step, r
            else:
                moved[i // 6] = p, r + np.cross(step, r, axisb=0, axisc=0)
            out[i] = self.elongation(s, moved).imag / STEP
        return out

    def wrench(self, poses, touching=None):
        """Force and moment on gear 1, on gear 2 (12 numbers), and the elongation of either flank.

        `touching`: a pose at which the drive flank just touches; None: where the teeth stand by their drawing.
        """
        zero = 0.0 if touching is None else -self.elongation(1, touching).real
        total, elongations = np.zeros(12), {}
        for s in (1, -1):
            delta = self.elongation(s, poses).real + s * zero
            delta -= self.base_pitch * np.round(delta / self.base_pitch)
            elongations[s] = delta
            if delta > 0:
                total -= self.stiffness * delta * self.gradient(s, poses)
        return total, elongations
