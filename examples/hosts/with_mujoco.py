"""MuJoCo: both gears on hinges, the mesh between them as a passive force, so that backlash needs no joints of its own.

`mjcb_passive` is called at every stage of the integrator; the unit answers by Model Exchange. MuJoCo's bodies
carry position, orientation and velocities in world axes, and `qfrc_passive` takes the moment about each hinge. A
gear that may tilt or move stands on more joints; here it is moved by its mount (`mocap` would do as well).
"""

import mujoco
import numpy as np
from gearmesh import GearPair

VERSION = mujoco.__version__
MODEL = """
<mujoco>
  <option timestep="1e-6" integrator="RK4" gravity="0 0 0"><flag contact="disable"/></option>
  <worldbody>
    <body name="gear1"><joint name="spin1" axis="0 0 1"/><inertial pos="0 0 0" mass="1" diaginertia="4e-4 4e-4 8e-4"/></body>
    <body name="mount2"><joint name="x" type="slide" axis="1 0 0"/><joint name="tilt1" axis="1 0 0"/>
      <joint name="tilt2" axis="0 1 0"/><joint name="spin2" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="1" diaginertia="4e-4 4e-4 8e-4"/></body>
  </worldbody>
</mujoco>
"""
# The joints in the order of their coordinates: the same angles as the unit's, about x, then y, then z.
COORDINATES = ["gear1.angles[3]", "gear2.position[1]", "gear2.angles[1]", "gear2.angles[2]", "gear2.angles[3]"]


class Mesh:
    """The passive force of a unit between gear 1 and gear 2 of `MODEL`."""

    def __init__(self, fmu):
        self.pair = GearPair(fmu, interface="model-exchange")
        self.model = mujoco.MjModel.from_xml_string(MODEL)
        self.data = mujoco.MjData(self.model)

    def force(self, _model, data):
        """Adds the generalised force at the poses and velocities of `data`."""
        pair = self.pair
        spin, x, tilt1, tilt2, spin2 = data.qpos
        pair["gear1.angles[3]"], pair["gear1.angularVelocity[3]"] = spin, data.qvel[0]
        for name, value in zip(COORDINATES[1:], (x, tilt1, tilt2, spin2)):
            pair[name] = value
        pair["gear2.velocity[1]"] = data.qvel[1]
        # Hinge by hinge in world axes: MuJoCo keeps them as xaxis.
        turning = data.xaxis[2:].T @ data.qvel[2:]
        for i in range(3):
            pair[f"gear2.angularVelocity[{i + 1}]"] = turning[i]
        pair.evaluate(data.time)
        moment = np.array([pair[f"gear2.moment[{i}]"] for i in (1, 2, 3)])
        data.qfrc_passive[0] += pair["gear1.moment[3]"]
        data.qfrc_passive[1] += pair["gear2.force[1]"]
        data.qfrc_passive[2:] += data.xaxis[2:] @ moment

    def __enter__(self):
        mujoco.set_mjcb_passive(self.force)
        return self

    def __exit__(self, *_):
        mujoco.set_mjcb_passive(None)
        self.pair.close()


def model_exchange(fmu, scenario, outputs):
    """The unit's outputs inside MuJoCo's forward dynamics at the imposed poses."""
    column = {name: i for i, name in enumerate(scenario.names)}
    rows = []
    with Mesh(fmu) as mesh:
        data = mesh.data
        for i, (time, row) in enumerate(zip(scenario.times, scenario.values)):
            if i == 0:
                for name, value in zip(scenario.names, row):
                    mesh.pair[name] = value
                mesh.pair.initialize()
            data.time = time
            data.qpos[:] = [row[column[name]] for name in COORDINATES]
            mujoco.mj_kinematics(mesh.model, data)
            turning = [row[column[f"gear2.angularVelocity[{k}]"]] for k in (1, 2, 3)]
            hinges = np.linalg.solve(data.xaxis[2:].T, turning)
            data.qvel[:] = [row[column["gear1.angularVelocity[3]"]], row[column["gear2.velocity[1]"]], *hinges]
            mujoco.mj_forward(mesh.model, data)
            rows.append([mesh.pair[name] for name in outputs])
    return np.array(rows)
