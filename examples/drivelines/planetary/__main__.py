"""`python -m examples.drivelines.planetary`: prints the comparisons, writes target/drivelines/planetary.png."""

from __future__ import annotations

import numpy as np
from gearmesh.energy import in_words
from gearmesh.plots import figure as new_figure

from ..files import save
from . import cases, phase
from .stage import IN_PHASE, PITCH, SEQUENTIAL


def main() -> None:
    print(f"lag of the ring mesh, pitch points: {phase.at_pitch_points():.4f} in closed form, {cases.measured_phase():.4f} from the units")
    for point, standard in phase.conventions(phase.STANDARD).items():
        print(f"| {point} | {standard:.4f} | {phase.conventions(phase.FITTED)[point]:.4f} |")
    print(f"published: {phase.PUBLISHED}")
    for name, teeth in (("standard teeth", phase.STANDARD), ("teeth of the root diameters", phase.FITTED)):
        further = teeth.tips[2] - phase.ring_tip_for(phase.PUBLISHED, teeth)
        print(f"{name}: end of contact has it, ring drives, with the ring's tip {1e3 * further:.2f} mm further in")
    figure, (left, middle, right) = new_figure(3)

    errors = {name: cases.transmission_error(places) for name, places in
              (("0/40/80", IN_PHASE), ("0/42/84", SEQUENTIAL))}
    spectra = {}
    for (name, error), offset in zip(errors.items(), (-0.2, 0.2)):
        left.plot(np.arange(len(error)) / len(error), 1e6 * (error - error.mean()) * PITCH[0], label=f"planets at {name}")
        spectra[name] = 2e6 * PITCH[0] * np.abs(np.fft.rfft(error))[1:7] / len(error)
        middle.bar(np.arange(1, 7) + offset, spectra[name], 0.4, label=name)
    left.set(xlabel="mesh cycle", ylabel="transmission error of the stage, µm at the sun")
    middle.set(xlabel="harmonic of the mesh frequency", ylabel="amplitude, µm", yscale="log")
    expected = [cases.vanishing(SEQUENTIAL, n) for n in range(1, 7)]
    middle.plot(np.arange(1, 7) + 0.2, spectra["0/40/80"] * expected, "k_", ms=14, label="0/40/80 times |mean of the phases|")
    left.legend()
    middle.legend(fontsize=8)
    for n in range(4):
        print(f"harmonic {n + 1}: {spectra['0/40/80'][n]:.3f} um in phase, {spectra['0/42/84'][n]:.4f} um sequential, "
              f"ratio {spectra['0/42/84'][n] / spectra['0/40/80'][n]:.3f}, from the phases {expected[n]:.3f}")

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
    for damped in (False, True):
        print(f"{'damped' if damped else 'undamped'}: {in_words(cases.balance(damped))}")


if __name__ == "__main__":
    main()
