"""ROSS (pip install ross-rotordynamics==2.3.0 "plotly<6"): `python -m examples.hosts.in_ross`, two rotors with the mesh stiffness over the angle."""

from __future__ import annotations

import numpy as np
import ross

from examples.shared.files import PAIRS

from .mesh_stiffness import over_a_pitch

STEEL = ross.Material("steel", rho=7810.0, E=206e9, G_s=79.2e9)


def rotor() -> ross.Rotor:
    """A shaft of 0.2 m and 40 mm on two bearings with a gear of 50 teeth and module 3 mm in the middle."""
    shaft = [ross.ShaftElement(0.1, 0.0, 0.04, material=STEEL) for _ in range(2)]
    gear = ross.GearElement(1, 2.6, 3.9e-3, 7.6e-3, n_teeth=50, pitch_diameter=0.15, pr_angle=np.radians(20.0))
    bearings = [ross.BearingElement(n, kxx=2e8, cxx=600.0, kzz=2e8) for n in (0, 2)]
    return ross.Rotor(shaft, [gear], bearings)


def coupled(angle: np.ndarray, stiffness: np.ndarray) -> ross.MultiRotor:
    """Two such rotors; integration in time reads the stiffness along the normal of the flank, N/m, over a pitch of gear 1, rad, everything
    else its mean."""
    both = ross.MultiRotor(rotor(), rotor(), (1, 1), gear_mesh_stiffness=float(stiffness[:-1].mean()), update_mesh_stiffness=True)
    both.mesh.theta_range, both.mesh.stiffness_range = angle, stiffness
    return both


def lag(both: ross.MultiRotor, rpm: float, torque: float, duration: float = 5e-3, step: float = 5e-6) -> np.ndarray:
    """Of gear 2, m on the pitch circle, over time, after the torque, N m on gear 1, is switched on.

    ROSS counts the angle of gear 2 in the sense in which it turns.
    """
    time = np.arange(0.0, duration, step)
    angles = [gear.dof_global_index[f"theta_{gear.n}"] for gear in (both.mesh.driving_gear, both.mesh.driven_gear)]
    loads = np.zeros((len(time), both.ndof))
    loads[:, angles] = torque, -torque
    found = both.run_time_response(rpm * np.pi / 30.0, loads, time, method="newmark").yout
    return found[:, angles] @ [0.075, -0.075]


if __name__ == "__main__":
    # Of spur gears the line of action is the normal of the flank.
    rotors = coupled(*over_a_pitch(PAIRS / "spur-50-50.json", 150.0))
    print("eigenfrequencies, Hz:", np.round(rotors.run_modal(0.0, num_modes=24).wn / (2.0 * np.pi)))
    print(f"gear 2 lags by {1e6 * lag(rotors, 2000.0, 150.0).mean():.1f} um in the mean, by mesh, shafts and bearings")
