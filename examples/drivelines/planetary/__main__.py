"""`python -m examples.drivelines.planetary`: prints the comparisons, writes target/drivelines/planetary.png."""

from __future__ import annotations

import numpy as np
from gearmesh.energy import in_words
from gearmesh.plots import figure as new_figure

from examples.shared.files import save

from . import cases, phase
from .stage import IN_PHASE, PITCH, SEQUENTIAL, Stage


def harmonics(values: np.ndarray) -> np.ndarray:
    """Amplitudes of the first six over a cycle."""
    return 2.0 * np.abs(np.fft.rfft(values, axis=0))[1:7] / len(values)


def main() -> None:
    print(f"lag of the ring mesh, pitch points: {phase.at_pitch_points():.4f} in closed form, {cases.measured_phase():.4f} from the FMUs")
    for point, standard in phase.conventions(phase.STANDARD).items():
        print(f"| {point} | {standard:.4f} | {phase.conventions(phase.FITTED)[point]:.4f} |")
    print(f"published: {phase.PUBLISHED}")
    for name, teeth in (("standard teeth", phase.STANDARD), ("teeth of the root diameters", phase.FITTED)):
        further = teeth.tips[2] - phase.ring_tip_for(phase.PUBLISHED, teeth)
        print(f"{name}: end of contact has it, ring drives, with the ring's tip {1e3 * further:.2f} mm further in")
    figure, (left, middle, right) = new_figure(3)

    cycles = {"0/40/80": cases.cycle(IN_PHASE), "0/42/84": cases.cycle(SEQUENTIAL)}
    spectra = {name: 1e6 * PITCH[0] * harmonics(cycle.error) for name, cycle in cycles.items()}
    for (name, spectrum), offset in zip(spectra.items(), (-0.2, 0.2)):
        left.bar(np.arange(1, 7) + offset, spectrum, 0.4, label=f"planets at {name}")
    expected = [cases.vanishing(SEQUENTIAL, n) for n in range(1, 7)]
    left.plot(np.arange(1, 7) + 0.2, spectra["0/40/80"] * expected, "k_", ms=14, label="0/40/80 times |mean of the phases|")
    left.set(xlabel="harmonic of the mesh frequency", ylabel="transmission error, µm at the sun", yscale="log")
    left.legend(fontsize=8)
    for n in range(3):
        print(f"harmonic {n + 1}: {spectra['0/40/80'][n]:.3f} um in phase, {spectra['0/42/84'][n]:.4f} um sequential, "
              f"ratio {spectra['0/42/84'][n] / spectra['0/40/80'][n]:.4f}, from the phases {expected[n]:.4f}")
    for name, cycle in cycles.items():
        print(f"{name}: lateral force on the sun {np.linalg.norm(cycle.lateral.mean(axis=0)):.0f} N steady, "
              f"harmonics up to {harmonics(cycle.lateral).max():.2g} N")
    print(f"closed form: {cases.steady_lateral(SEQUENTIAL):.0f} N")

    moment, thrust = cases.overturning()
    for name, cycle in {"planets that tilt": cycles["0/40/80"], "stiff pins": cases.cycle(span=cases.STIFF)}.items():
        count = len(cycle.tilting)
        middle.plot(np.arange(count) / count, 1e-3 * cycle.tilting[:, 1], label=name)
        print(f"{name}: moment on a pin {cycle.tilting[:, 1].mean():.1f} N m, thrust on the sun {-cycle.thrust.mean():.1f} N")
    print(f"closed form: {moment:.1f} N m, {thrust:.1f} N; tilt {1e6 * np.abs(cycles['0/40/80'].tilt).mean():.0f} urad")
    middle.axhline(1e-3 * moment, color="k", lw=0.8, ls="--", label="axial forces of both meshes")
    middle.set(xlabel="mesh cycle", ylabel="overturning moment on a pin, kN m", ylim=(0.0, None))
    middle.legend(fontsize=8)

    stiffness = cases.path_stiffness()
    pins = np.linspace(0.0, 50e-6, 6)
    for floating, colour in ((False, "C0"), (True, "C1")):
        shares = np.array([cases.load_sharing(e, floating) for e in pins])
        closed = np.array([cases.shares_in_closed_form(e, floating, stiffness) for e in pins])
        name = "floating" if floating else "fixed"
        right.plot(1e6 * pins, shares[:, 0], "o", color=colour, label=f"{name} sun, planet with the error")
        right.plot(1e6 * pins, shares[:, 1:].mean(axis=1), "x", color=colour, label=f"{name} sun, the others")
        right.plot(1e6 * pins, closed[:, :2], color=colour, lw=0.8)
        print(f"{name} sun, 50 um: shares {np.round(shares[-1], 4)}, closed form {np.round(closed[-1], 4)}")
    right.set(xlabel="pin error, µm", ylabel="share of the load", ylim=(0.29, 0.435))
    right.legend(fontsize=8)
    save(figure, "planetary")
    print(f"fixed sun, 50 um, planets that tilt: shares {np.round(cases.load_sharing(50e-6, False, span=Stage.span), 4)}")
    for damped in (False, True):
        print(f"{'damped' if damped else 'undamped'}: {in_words(cases.balance(damped))}")


if __name__ == "__main__":
    main()
