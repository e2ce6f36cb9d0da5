"""`python -m examples.drivelines.rattle`: writes target/drivelines/rattle.png."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor

import numpy as np
from gearmesh.energy import in_words
from gearmesh.plots import figure as new_figure

from examples.shared.files import save

from .idle import balance, gearbox, period_one, restitution, shaken
from .mujoco_joint import GAP, RATIO, balance as free_joint, kept_by_the_hinge, lost_motion, run

GAMMAS = np.round(np.arange(0.6, 1.61, 0.05), 2)


def main() -> None:
    r = restitution()
    low, high = period_one(r)
    print(f"restitution {r:.3f} at 0.03 m/s, {restitution(0.01):.3f} at 0.01 m/s: one impact a period from {low:.3f} to {high:.3f}")
    figure, (left, middle, right) = new_figure(3)
    with ProcessPoolExecutor(2) as pool:
        gaps, boxes = list(pool.map(shaken, GAMMAS)), list(pool.map(gearbox, GAMMAS))
    for gamma, gap in zip(GAMMAS, gaps):
        left.plot(np.full(len(gap), gamma), 1e6 * gap, "k.", ms=3)
    for limit in (low, high):
        left.axvline(limit, color="C3", lw=0.8)
    left.set(xlabel="acceleration over drag, Gamma", ylabel="gap in mid-flight, once a period (µm)", title="idle gear over a shaken gear")
    one = [g for g, gap in zip(GAMMAS, gaps) if gap.min() > 1e-5 and np.ptp(gap) < 4e-6]
    print(f"found with one impact a period: {min(one):.2f} to {max(one):.2f}")

    flight = {coupling: shaken(1.0, coupling=coupling).mean() for coupling in (None, "held", "sequential", "parallel")}
    print("gap in mid-flight at Gamma 1 by co-simulation against Model Exchange: "
          + ", ".join(f"{c} {100 * (flight[c] / flight[None] - 1):+.2f} %" for c in ("held", "sequential", "parallel")))

    loaded, idle = np.array(boxes).T
    middle.plot(GAMMAS, idle, "o-", label="idle pair")
    middle.plot(GAMMAS, loaded, "s-", label="loaded pair")
    middle.axvline(1.0, color="C3", lw=0.8)
    middle.set(xlabel="Gamma by the rigid ratio", ylabel="share of time without contact", title="two-stage gearbox")
    middle.legend()
    print(f"gearbox: idle pair quiet up to Gamma {GAMMAS[idle < 0.01].max():.2f}; loaded pair apart {loaded.max():.3f} of the time at most")

    for damped in (False, True):
        print(f"gearbox, {'damped' if damped else 'undamped'}: {in_words(balance(damped))}")

    for element, name in ((False, "limited hinge"), (True, "gear element")):
        pinion, wheel = run(element)
        part = slice(len(pinion) // 2, None)
        right.plot(1e3 * RATIO * pinion[part], -1e3 * wheel[part], label=name)
        print(f"MuJoCo, {name}: lost motion {1e3 * lost_motion(pinion, wheel):.3f} mrad, gap {1e3 * GAP:.3f} mrad")
    for integrator in ("implicitfast", "RK4"):
        for step in (5e-6, 2.5e-6, 1.25e-6):
            print(f"MuJoCo, nothing damped, {integrator} at {1e6 * step:g} us: {in_words(free_joint(integrator, step))}")
    print(f"MuJoCo, nothing damped, limited hinge: {kept_by_the_hinge(5e-6):.3f} of the energy left")
    right.set(xlabel="pinion times ratio (mrad)", ylabel="wheel (mrad)", title="reversing joint in MuJoCo")
    right.legend()
    save(figure, "rattle")


if __name__ == "__main__":
    main()
