"""MuJoCo: both gears on hinges, the mesh between them as a passive force, so that backlash needs no joints of its own.

`mjcb_passive` is called at every stage of the integrator; the FMU answers by Model Exchange. MuJoCo's bodies
carry position, orientation and velocities in world axes, and `qfrc_passive` takes the moment about each hinge. A
gear that may tilt or move stands on more joints; here it is moved by its mount (`mocap` would do as well).
"""

import mujoco
import numpy as np
from gearmesh import GearPair
from gearmesh.poses import generalised, place

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
# The joints in the order of their coordinates: the same angles as the FMU's, about x, then y, then z.
COORDINATES = ["gear1.angles[3]", "gear2.position[1]", "gear2.angles[1]", "gear2.angles[2]", "gear2.angles[3]"]
JOINTS = [5, 6, 9, 10, 11]  # of the twelve coordinates of both gears


class Mesh:
    """The passive force of an FMU between gear 1 and gear 2 of `MODEL`."""

    def __init__(self, fmu):
        self.pair = GearPair(fmu, interface="model-exchange")
        self.reference = (0.0, 0.0, 0.0), (0.0, *self.pair.u[17:19])  # the joint x holds the whole distance
        self.model = mujoco.MjModel.from_xml_string(MODEL)
        self.data = mujoco.MjData(self.model)

    def force(self, _model, data):
        """Adds the generalised force at the poses and velocities of `data`."""
        q, q_t = np.zeros(12), np.zeros(12)
        q[JOINTS], q_t[JOINTS] = data.qpos, data.qvel
        place(self.pair, q.tolist(), q_t.tolist(), self.reference)
        self.pair.evaluate(data.time)
        data.qfrc_passive += generalised(self.pair.y[:12], q)[JOINTS]

    def __enter__(self):
        mujoco.set_mjcb_passive(self.force)
        return self

    def __exit__(self, *_):
        mujoco.set_mjcb_passive(None)
        self.pair.close()


def model_exchange(fmu, scenario, outputs):
    """The FMU's outputs inside MuJoCo's forward dynamics at the imposed poses."""
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
