"""Teeth of involute gears by formulas that share nothing with the program: what the reference programs here have in common."""

from math import acos, atan, cos, hypot, pi, radians, sin, tan

import numpy as np
from scipy.optimize import brentq

E, NU = 206e3, 0.3  # MPa; lengths in mm


def inv(alpha):
    return np.tan(alpha) - alpha


class Gear:
    """One gear; `ring`: internal teeth, whose fillet is an arc of radius rho."""

    def __init__(self, z, m, alpha, beta=0.0, x=0.0, dedendum=1.25, rho=0.38, tip=None, held=None, b=0.0, ring=False):
        self.z, self.m, self.x, self.b, self.ring, self.held = z, m, x, b, ring, held
        self.alpha, self.beta = radians(alpha), radians(beta)
        self.kappa = -1 if ring else 1
        self.alpha_t = atan(tan(self.alpha) / cos(self.beta))
        self.r = 0.5 * z * m / cos(self.beta)
        self.rb = self.r * cos(self.alpha_t)
        self.root = self.r + m * (x - self.kappa * dedendum)
        self.tip, self.rho = tip, rho * m
        self.twist = tan(self.beta) / self.r
        # Half the angle of the tooth (ring: of the space) at the base circle.
        self.psi = pi / (2 * z) + 2 * x * tan(self.alpha) / z + inv(self.alpha_t)

    def flank(self, r):
        """Angle of the flank from the centre line of the tooth at a radius or at an array of them."""
        angle = self.psi - inv(np.arccos(np.minimum(1.0, self.rb / r)))
        return pi / self.z - angle if self.ring else angle

    def fillet(self, n=160):
        """Points (r, theta) from the root circle to the start of the involute, by the envelope of the rack's round or the arc."""
        if self.ring:
            rc = self.root - self.rho

            def foot(rr):  # point of the offset involute from the flank point at radius rr, into the space
                a = acos(self.rb / rr)
                x, y = rr * cos(self.flank(rr)), rr * sin(self.flank(rr))
                # The normal of the flank out of the material, which for internal teeth touches the base circle.
                ux, uy = cos(self.flank(rr) + a), sin(self.flank(rr) + a)
                tx, ty = self.rb * ux - x, self.rb * uy - y
                s = hypot(tx, ty)
                return x + self.rho * tx / s, y + self.rho * ty / s

            rr = brentq(lambda q: hypot(*foot(q)) - rc, max(self.tip, self.rb) * 1.0001, self.root)
            cx, cy = foot(rr)
            px, py = rr * cos(self.flank(rr)), rr * sin(self.flank(rr))
            a0, a1 = np.arctan2(cy, cx), np.arctan2(py - cy, px - cx)
            t = np.linspace(a0, a1, n)
            x, y = cx + self.rho * np.cos(t), cy + self.rho * np.sin(t)
            return np.hypot(x, y), np.arctan2(y, x)
        cb = cos(self.beta)
        depth = self.r - self.root - self.rho
        s0 = (self.m * (pi / 4 + self.x * tan(self.alpha)) + depth * tan(self.alpha) + self.rho / cos(self.alpha)) / cb
        nu = np.linspace(pi / 2, self.alpha, n)
        s, d = s0 - self.rho * np.cos(nu) / cb, depth + self.rho * np.sin(nu)
        # The rack stands where the normal of its point passes through the pitch point.
        y = -d * cb / np.tan(nu)
        x = self.r - d
        return np.hypot(x, y), np.arctan2(y, x) - (y - s) / self.r

    def half(self, points=60):
        """Root land, fillet, flank of the +theta side, from the middle of the space to the tip: lists of (r, theta)."""
        r, t = self.fillet()
        start, end = r[-1], self.tip
        flank = [(q, self.flank(q)) for q in np.linspace(start, end, points)]
        return [(self.root, pi / self.z), (r[0], t[0])], list(zip(r, t)), flank

    def tangent_angle(self, r, t):
        """Angle between the tangent plane of the helicoid through the points and the centre line of the tooth, degrees."""
        x, y = r * np.cos(t), r * np.sin(t)
        dx, dy = np.gradient(x), np.gradient(y)
        nx, ny = dy / np.hypot(dx, dy), -dx / np.hypot(dx, dy)
        nz = self.twist * (nx * y - ny * x)
        return np.degrees(np.arcsin(np.abs(nx) / np.sqrt(1 + nz**2)))
