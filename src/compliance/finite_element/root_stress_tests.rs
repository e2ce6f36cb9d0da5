use super::*;
use crate::gear::{GearKind, samples};
use crate::pair::Refinement;

fn spur20() -> Gear {
    let mut gear = samples::with_module(samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0), 4e-3);
    gear.face_width = 25e-3;
    gear.youngs_modulus = 206e9;
    gear.poisson_ratio = 0.3;
    gear.tip_radius = 44e-3;
    gear.held_radius = 15e-3;
    gear
}

#[test]
fn convergence() {
    let gear = spur20();
    for radius in [38.5e-3, 40e-3, 42e-3, 44e-3f64] {
        let roll = gear.roll_length(radius);
        let strip = Strip {
            tooth: 0,
            z: [0.0, 1.0],
            roll: [roll; 2],
        };
        for (fillet, flank, root) in [
            (0.2, 0.25, 0.25),
            (0.1, 0.25, 0.25),
            (0.05, 0.25, 0.25),
            (0.1, 0.12, 0.25),
            (0.1, 0.12, 0.12),
            (0.05, 0.06, 0.1),
            (0.025, 0.06, 0.1),
            (0.02, 0.03, 0.1),
        ] {
            let mut settings = Settings::new(Refinement::Normal, 1);
            settings.plane_strain = true;
            let d = &mut settings.discretization;
            d.fillet_element = Some(fillet);
            d.flank_element = flank;
            d.kernel_half_width = 0.3f64.max(1.25 * flank);
            d.root_element = root;
            let model = RootStress::new(&gear, &settings, &|_, _| true).unwrap();
            let field = model.of_tooth(0, &[(strip, 1e5)]).unwrap();
            let top = field.largest();
            let at = field.at_tangent().unwrap();
            let next = model.of_tooth(1, &[(strip, 1e5)]).unwrap().largest();
            println!(
                "r {:.1} fillet {fillet} flank {flank} root {root}: {:.3} MPa at r {:.4} tangent {:.2}; 30deg {:.3}; next {:.3} n {}",
                radius * 1e3,
                top.stress * 1e-6,
                top.radius * 1e3,
                top.tangent.to_degrees(),
                at.stress * 1e-6,
                next.stress * 1e-6,
                model.fillet.radii.len()
            );
        }
    }
}
