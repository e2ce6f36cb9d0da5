"""A geared joint with backlash in MuJoCo: the usual limited extra hinge, and the gear element in its place."""

from __future__ import annotations

import mujoco
import numpy as np
from gearmesh import GearPair

from ..files import shipped

# fzg-c: 16/24 teeth, 150 um of circumferential backlash at the pitch circle of the 24-tooth gear, 109.8 mm.
RATIO, GAP = 16 / 24, 150e-6 / 54.9e-3  # rad at the wheel
STEP = 5e-6
SWING, FREQUENCY = 0.02, 5.0  # rad and Hz of the pinion

WORLD = """
<mujoco>
  <option timestep="{step}" integrator="{integrator}" gravity="0 0 0"/>
  <worldbody>
    <body name="pinion"><joint name="pinion" axis="0 0 1"/><inertial pos="0 0 0" mass="1" diaginertia="1e-3 1e-3 1e-3"/></body>
    {wheel}
  </worldbody>
  <equality>{equality}</equality>
</mujoco>
"""
HINGE = """
    <body name="carrier"><joint name="carrier" axis="0 0 1"/><inertial pos="0 0 0" mass="1e-3" diaginertia="1e-6 1e-6 1e-6"/>
      <body name="wheel"><joint name="wheel" axis="0 0 1" limited="true" range="{low} {high}" solreflimit="1e-4 1"/>
      <inertial pos="0 0 0" mass="2" diaginertia="1.5e-3 1.5e-3 1.5e-3"/></body></body>
"""
ELEMENT = """
    <body name="wheel" pos="0.0915 0 0"><joint name="wheel" axis="0 0 1"/>
    <inertial pos="0 0 0" mass="2" diaginertia="1.5e-3 1.5e-3 1.5e-3"/></body>
"""
DRAG, PULL = 0.3, 2e3  # N m s/rad against the wheel; N m/rad and 10 N m s/rad of the drive on the pinion


def run(element: bool, duration: float = 0.45) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angles of pinion and wheel, rad, and the moment that the wheel receives, N m, every 0.1 ms."""
    if element:
        text = WORLD.format(step=STEP, integrator="implicitfast", wheel=ELEMENT, equality="")
    else:
        wheel = HINGE.format(low=np.degrees(-GAP / 2), high=np.degrees(GAP / 2))
        equality = f'<joint joint1="carrier" joint2="pinion" polycoef="0 {-RATIO} 0 0 0" solref="1e-4 1"/>'
        text = WORLD.format(step=STEP, integrator="implicitfast", wheel=wheel, equality=equality)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    pair = GearPair(shipped("fzg-c", "phaseReference=absolute"), interface="model-exchange")
    pair.initialize()
    middle = pair.u[pair.input["gear2.angles[3]"]]
    spin1, rate1 = pair.input["gear1.angles[3]"], pair.input["gear1.angularVelocity[3]"]
    spin2, rate2 = pair.input["gear2.angles[3]"], pair.input["gear2.angularVelocity[3]"]
    moment1, moment2 = pair.output["gear1.moment[3]"], pair.output["gear2.moment[3]"]

    def passive(_model, d):
        angle = SWING * np.sin(2.0 * np.pi * FREQUENCY * d.time)
        d.qfrc_passive[0] += PULL * (angle - d.qpos[0]) - 10.0 * d.qvel[0]
        d.qfrc_passive[-1] -= DRAG * (d.qvel[-1] if element else d.qvel[-1] + d.qvel[1])
        if not element:
            d.qfrc_passive[1] -= DRAG * (d.qvel[-1] + d.qvel[1])
            return
        pair.u[spin1], pair.u[rate1] = d.qpos[0], d.qvel[0]
        pair.u[spin2], pair.u[rate2] = middle + d.qpos[-1], d.qvel[-1]
        pair.evaluate(d.time)
        d.qfrc_passive[0] += pair.y[moment1]
        d.qfrc_passive[-1] += pair.y[moment2]

    mujoco.set_mjcb_passive(passive)
    try:
        every, out = round(1e-4 / STEP), []
        for n in range(round(duration / STEP)):
            mujoco.mj_step(model, data)
            if n % every == 0:
                wheel = data.qpos[-1] if element else data.qpos[-1] + data.qpos[1]
                speed = data.qvel[-1] if element else data.qvel[-1] + data.qvel[1]
                force = pair.y[moment2] if element else data.qacc[1:].sum() * 1.5e-3 + DRAG * speed
                out.append((data.qpos[0], wheel, force))
        return tuple(np.array(out).T)
    finally:
        mujoco.set_mjcb_passive(None)
        pair.close()


def lost_motion(pinion: np.ndarray, wheel: np.ndarray) -> float:
    """Width of the hysteresis between the pinion's motion and the wheel's, rad at the wheel."""
    later = slice(len(pinion) // 2, None)
    return float(np.ptp((wheel + RATIO * pinion)[later]))
