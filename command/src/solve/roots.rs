//! Stress in the tooth roots as `--json`, text and CSV give it.

use std::fmt::Write;

use gearmesh::gear::PairGeometry;
use gearmesh::words::rounded;
use gearmesh_preprocessor::NominalRootStress;
use gearmesh_preprocessor::contact::{CycleInput, GearRoots, MeshCycle, ToothRoot};
use gearmesh_preprocessor::finite_element::RootPoint;
use serde::Serialize;

use crate::output::{Listing, rows};

/// What `--root-stress` adds to a report: one of everything for gear 1 and gear 2.
#[derive(Debug, Serialize)]
pub struct Roots {
    /// Largest principal stress at each mesh position; 0 without load.
    root_stress_mpa: [Vec<f64>; 2],
    /// The same at the 30 degree tangent (ring: 60 degrees).
    root_stress_at_tangent_mpa: [Vec<f64>; 2],
    /// The largest of the cycle, and where; null without load.
    #[serde(rename = "largest_root_stress")]
    pub largest: [Option<Place>; 2],
    /// Nominal stress of ISO 6336-3 with its terms; null where the standard does not go.
    iso_6336_3: [Option<Nominal>; 2],
    /// Every tooth under load at every position.
    #[serde(skip)]
    pub rows: Vec<Place>,
    /// Fillets of the teeth of `largest`.
    #[serde(skip)]
    pub fields: [Vec<Vec<RootPoint>>; 2],
}

/// A tooth under load.
#[derive(Debug, Clone, Serialize)]
pub struct Place {
    /// 1 or 2.
    pub gear: usize,
    pub stress_mpa: f64,
    pub mesh_position: f64,
    pub tooth_pair: i32,
    /// Share of this tooth pair in the load.
    pub load_share: f64,
    /// From gear 1's z = 0 face.
    pub z_mm: f64,
    pub diameter_mm: f64,
    /// Between the fillet's tangent and the tooth's centre line.
    pub tangent_deg: f64,
    /// At the 30 (ring: 60) degree tangent of this tooth at this position, and where along the face.
    pub at_tangent_mpa: Option<f64>,
    pub at_tangent_z_mm: Option<f64>,
}

/// Terms of ISO 6336-3:2006, method B.
#[derive(Debug, Serialize)]
struct Nominal {
    sigma_f0_mpa: f64,
    y_f: f64,
    y_s: f64,
    y_beta: f64,
    y_b: f64,
    virtual_teeth: f64,
    virtual_contact_ratio: f64,
    load_angle_deg: f64,
    h_fe_over_module: f64,
    s_fn_over_module: f64,
    rho_f_over_module: f64,
}

impl Nominal {
    fn new(of: &NominalRootStress) -> Nominal {
        Nominal {
            sigma_f0_mpa: 1e-6 * of.stress,
            y_f: of.form_factor,
            y_s: of.correction_factor,
            y_beta: of.helix_factor,
            y_b: of.rim_factor,
            virtual_teeth: of.virtual_teeth,
            virtual_contact_ratio: of.virtual_contact_ratio,
            load_angle_deg: of.load_angle.to_degrees(),
            h_fe_over_module: of.lever_arm,
            s_fn_over_module: of.chord,
            rho_f_over_module: of.fillet_radius,
        }
    }
}

impl Roots {
    /// The report on `gears` in `cycle`, which was solved for `input`.
    pub fn new(
        geometry: &PairGeometry,
        input: &CycleInput,
        cycle: &MeshCycle,
        gears: [GearRoots; 2],
    ) -> Roots {
        let place = |i: usize, tooth: &ToothRoot| Place::new(i, cycle, tooth);
        let over = |of: fn(&ToothRoot) -> Option<f64>| {
            gears.each_ref().map(|gear| {
                let stress = gear.over_cycle(input.positions, of);
                stress.into_iter().map(|s| 1e-6 * s).collect()
            })
        };
        let rows = gears.iter().enumerate();
        Roots {
            root_stress_mpa: over(|tooth| Some(tooth.largest.stress)),
            root_stress_at_tangent_mpa: over(|tooth| Some(tooth.at_tangent?.stress)),
            largest: [0, 1].map(|i| Some(place(i, gears[i].largest()?))),
            iso_6336_3: [0, 1].map(|i| {
                let nominal = NominalRootStress::new(geometry, i, input.torque);
                nominal.as_ref().map(Nominal::new)
            }),
            rows: rows
                .flat_map(|(i, gear)| gear.teeth.iter().map(move |tooth| place(i, tooth)))
                .collect(),
            fields: gears.map(|gear| gear.field),
        }
    }

    /// Adds itself to `rows` of the text for one load.
    pub fn list(&self, rows: &mut Listing) {
        for (i, (largest, nominal)) in self.largest.iter().zip(&self.iso_6336_3).enumerate() {
            let beyond = "beyond the standard (rim or notch)";
            rows! { rows;
                format!("root stress of gear {}", i + 1) => "{}", largest.as_ref().map_or("none".into(), Place::words);
                "  ISO 6336-3 sigma_F0" => "{}", nominal.as_ref().map_or(beyond.into(), Nominal::words);
            }
        }
    }

    /// The points of the fillets of the teeth of `largest`, each after its tooth.
    pub fn largest_fields(&self) -> impl Iterator<Item = (&Place, &RootPoint)> {
        let gears = self.largest.iter().zip(&self.fields);
        let loaded = gears.filter_map(|(tooth, field)| Some((tooth.as_ref()?, field)));
        loaded.flat_map(|(tooth, field)| field.iter().flatten().map(move |point| (tooth, point)))
    }

    /// The largest stress of gear `i`, MPa, anywhere in its fillets or at the standard tangent.
    pub fn largest_over_cycle(&self, i: usize, at_tangent: bool) -> f64 {
        let stress = match at_tangent {
            true => &self.root_stress_at_tangent_mpa[i],
            false => &self.root_stress_mpa[i],
        };
        stress.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }
}

impl Place {
    fn new(i: usize, cycle: &MeshCycle, tooth: &ToothRoot) -> Place {
        let shares = &cycle.results[tooth.position].load_share;
        let share = shares.iter().find(|(k, _)| *k == tooth.tooth_pair);
        let RootPoint {
            stress,
            z,
            radius,
            tangent,
        } = tooth.largest;
        Place {
            gear: i + 1,
            stress_mpa: 1e-6 * stress,
            mesh_position: cycle.mesh_position[tooth.position],
            tooth_pair: tooth.tooth_pair,
            load_share: share.map_or(0.0, |(_, share)| *share),
            z_mm: 1e3 * z,
            diameter_mm: 2e3 * radius,
            tangent_deg: tangent.to_degrees(),
            at_tangent_mpa: tooth.at_tangent.map(|point| 1e-6 * point.stress),
            at_tangent_z_mm: tooth.at_tangent.map(|point| 1e3 * point.z),
        }
    }

    fn words(&self) -> String {
        let mut words = format!(
            "{:.1} MPa at mesh position {}, pair {} ({:.0} % of the load), z = {:.2} mm, d = {:.3} mm ({:.0} deg tangent)",
            self.stress_mpa,
            rounded(self.mesh_position),
            self.tooth_pair,
            100.0 * self.load_share,
            self.z_mm,
            self.diameter_mm,
            self.tangent_deg,
        );
        if let Some(stress) = self.at_tangent_mpa {
            let _ = write!(words, "; {stress:.1} MPa at the standard tangent");
        }
        words
    }
}

impl Nominal {
    fn words(&self) -> String {
        format!(
            "{:.1} MPa, Y_F {:.3}, Y_S {:.3}, Y_beta {:.3}, Y_B {:.3}",
            self.sigma_f0_mpa, self.y_f, self.y_s, self.y_beta, self.y_b
        )
    }
}
