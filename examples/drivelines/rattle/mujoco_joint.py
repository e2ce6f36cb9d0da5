"""A geared joint with backlash in MuJoCo: the usual limited extra hinge, and the gear element in its place."""

from __future__ import annotations

import mujoco
import numpy as np
from gearmesh import GearPair, Turning
from gearmesh.energy import Ledger

from examples.shared.files import shipped

# fzg-c: 16/24 teeth, 150 um of circumferential backlash at the pitch circle of the 24-tooth gear, 109.8 mm.
RATIO, GAP = 16 / 24, 150e-6 / 54.9e-3  # rad at the wheel
INERTIAS = (1e-3, 1.5e-3)  # kg m^2, as in the models below
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


class Joint:
    """Pinion and wheel, turning, with the element or the limited hinge between them; `close` it, MuJoCo has one callback for all.

    `drive(data, angle, speed)` returns what acts on pinion and wheel besides, N m, from angle and speed of the wheel.
    """

    def __init__(self, element: bool, drive, step: float = STEP, integrator: str = "implicitfast"):
        self.element, self.drive = element, drive
        wheel, equality = ELEMENT, ""
        if not element:
            wheel = HINGE.format(low=np.degrees(-GAP / 2), high=np.degrees(GAP / 2))
            equality = f'<joint joint1="carrier" joint2="pinion" polycoef="0 {-RATIO} 0 0 0" solref="1e-4 1"/>'
        text = WORLD.format(step=step, integrator=integrator, wheel=wheel, equality=equality)
        self.model = mujoco.MjModel.from_xml_string(text)
        self.data = mujoco.MjData(self.model)
        self.pair = GearPair(shipped("fzg-c", phaseReference="absolute"), interface="model-exchange")
        self.turning, self.middle = Turning(self.pair), self.pair.u[self.pair.input["gear2.angles[3]"]]

    def __enter__(self) -> Joint:
        mujoco.set_mjcb_passive(self._passive)
        return self

    def __exit__(self, *_) -> None:
        mujoco.set_mjcb_passive(None)
        self.pair.close()

    def start(self, damping: float | None = None) -> None:
        """Readies the element, with `damping`, N s/m, or what is packed."""
        if damping is not None:
            self.pair.set_parameter("damping", damping)
        self.pair.initialize()

    def _passive(self, _model, d) -> None:
        on_pinion, on_wheel = self.drive(d, *self.wheel(d))
        d.qfrc_passive[0] += on_pinion
        # A moment on the wheel acts on the carrier's joint, too: their angles add up.
        d.qfrc_passive[1:] += on_wheel
        if self.element:
            self.touch(d)
            d.qfrc_passive[:] += self.turning.moments()

    def touch(self, d) -> None:
        """Evaluates the element at the joint's angles and speeds."""
        self.turning(d.qpos[0], d.qvel[0], self.middle + d.qpos[-1], d.qvel[-1])

    def wheel(self, d) -> tuple[float, float]:
        """Angle, rad, and speed of the wheel: the last joint and, with the hinge, the one that carries it."""
        return float(d.qpos[1:].sum()), float(d.qvel[1:].sum())


def run(element: bool, duration: float = 0.45) -> tuple[np.ndarray, np.ndarray]:
    """Angles of pinion and wheel, rad, every 0.1 ms."""

    def drive(d, _, speed):
        angle = SWING * np.sin(2.0 * np.pi * FREQUENCY * d.time)
        return PULL * (angle - d.qpos[0]) - 10.0 * d.qvel[0], -DRAG * speed

    every, out = round(1e-4 / STEP), []
    with Joint(element, drive) as joint:
        joint.start()
        data = joint.data
        for n in range(round(duration / STEP)):
            mujoco.mj_step(joint.model, data)
            if n % every == 0:
                out.append((data.qpos[0], joint.wheel(data)[0]))
    return tuple(np.array(out).T)


def let_go(element: bool, integrator: str, step: float, duration: float, speed: float):
    """Nothing fed, nothing damped: the pinion on its spring, set off at `speed`, rad/s, hits the wheel on both flanks.

    Yields the joint every 0.1 ms, with the energies of motion and of the drive's spring, J.
    """
    every = round(1e-4 / step)
    with Joint(element, lambda d, *_: (-PULL * d.qpos[0], 0.0), step, integrator) as joint:
        joint.start(damping=0.0)
        data = joint.data
        data.qvel[0] = speed
        for n in range(round(duration / step)):
            if n % every == 0:
                motion = 0.5 * (INERTIAS[0] * data.qvel[0] ** 2 + INERTIAS[1] * joint.wheel(data)[1] ** 2)
                yield joint, motion, 0.5 * PULL * data.qpos[0] ** 2
            mujoco.mj_step(joint.model, data)


def balance(integrator: str, step: float, duration: float = 0.03, speed: float = 6.0) -> dict[str, float]:
    """What energy and loads stray where MuJoCo steps the element by `integrator`, over the run; shares of time by flank."""
    ledger, flanks = Ledger(duration), []
    for joint, motion, spring in let_go(True, integrator, step, duration, speed):
        joint.touch(joint.data)
        flanks.append(joint.pair.flank)
        ledger.enter([joint.pair], motion, spring, 0.0, 0.0)
    shares = {word: float(np.mean(np.equal(flanks, flank))) for word, flank in (("apart", 0), ("on the second flank", -1))}
    return ledger.found() | {f"share of time {word}": share for word, share in shares.items()}


def kept_by_the_hinge(step: float, duration: float = 0.03, speed: float = 6.0) -> float:
    """Share of the energy that is left at the end with the limited hinge in place of the element."""
    energies = [motion + spring for _, motion, spring in let_go(False, "implicitfast", step, duration, speed)]
    return energies[-1] / energies[0]


def lost_motion(pinion: np.ndarray, wheel: np.ndarray) -> float:
    """Width of the hysteresis between the pinion's motion and the wheel's, rad at the wheel."""
    later = slice(len(pinion) // 2, None)
    return float(np.ptp((wheel + RATIO * pinion)[later]))
