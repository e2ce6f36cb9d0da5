use super::*;
use crate::gear::GearKind;
use crate::pair::Refinement;

fn spur(teeth: u32, module: f64, bore_ratio: f64) -> Gear {
    let mut gear = Gear {
        kind: GearKind::External,
        teeth,
        hand: 1.0,
        normal_module: module,
        normal_pressure_angle: 20f64.to_radians(),
        helix_angle: 0.0,
        profile_shift: 0.0,
        face_width: 6.0 * module,
        face_offset: 0.0,
        tip_radius: 0.5 * module * (f64::from(teeth) + 2.0),
        dedendum_coefficient: 1.25,
        tool_tip_radius_coefficient: 0.38,
        held_radius: 0.0,
        tooth_thinning: 0.0,
        youngs_modulus: 206e9,
        poisson_ratio: 0.3,
    };
    gear.held_radius = bore_ratio * gear.root_radius();
    gear
}

#[test]
fn timing() {
    for refinement in [Refinement::Coarse, Refinement::Normal] {
        let mut gear = spur(20, 4e-3, 0.5);
        gear.helix_angle = 13f64.to_radians();
        gear.tip_radius = 90.315e-3/2.0; gear.held_radius=15e-3; gear.face_width=25e-3;
        let c = FiniteElementCompliance::new(&gear, &Settings::new(refinement, 2), &|_, _| true).unwrap();
        println!("{:?} {:?}", refinement, c.cost());
        let c0=&c.influence[0];
        println!("asym {}", (c0-c0.transpose()).norm()/c0.norm());
    }
}
