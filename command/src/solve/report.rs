//! One mesh cycle as `--json` prints it and as the other outputs take it.

use gearmesh::contact::ContactResult;
use gearmesh::pair::Pair;
use gearmesh::words::rounded;
use gearmesh_preprocessor::contact::{CycleInput, Harmonic, MeshCycle, harmonics};
use gearmesh_preprocessor::pair;
use serde::Serialize;

use super::roots::Roots;
use crate::losses::Losses;

/// What `--json` prints of one load. Arrays run over the positions. docs/contact-results.md has every key.
#[derive(Debug, Serialize)]
pub struct Report {
    /// Torque on gear 1.
    pub torque_nm: f64,
    /// Misalignment in the plane of action.
    pub misalignment_mrad: f64,
    /// Base pitches; 0: a tooth pair touches at the pitch point at mid-face.
    pub mesh_position: Vec<f64>,
    /// Static transmission error on the line of action at mid-face.
    pub ste_loa_um: Vec<f64>,
    /// Resultant force, from gear 1's z = 0 face.
    pub contact_z_mm: Vec<f64>,
    /// Share of each of `tooth_pairs` in the load, one list per position.
    pub load_share: Vec<Vec<f64>>,
    /// Largest Hertz pressure inside the flanks.
    pub maximum_pressure_mpa: Vec<f64>,
    /// Largest normal force per length of contact line where contact reaches a tip edge; zero where none does.
    pub edge_line_load_n_per_mm: Vec<f64>,
    /// Where that is, from gear 1's z = 0 face.
    pub edge_z_mm: Vec<Option<f64>>,
    /// The gear whose tip edge it is, 1 or 2.
    pub edge_gear: Vec<Option<usize>>,
    /// The tooth pairs of `load_share`; number 0 touches at the pitch point at mesh position 0, the
    /// next one to come into mesh has the number below.
    pub tooth_pairs: Vec<i32>,
    /// Tangent stiffness dF/dSTE in the transverse plane along the line of action.
    pub mesh_stiffness_loa_n_per_m: Vec<f64>,
    pub mean_ste_loa_um: f64,
    pub peak_to_peak_ste_loa_um: f64,
    /// Amplitudes of harmonics 1 to 10; null where the positions are too few.
    pub harmonics_loa_um: Vec<Option<f64>>,
    /// Their phases: amplitude cos(2 pi order mesh_position + phase).
    pub harmonics_phase_rad: Vec<Option<f64>>,
    pub mean_mesh_stiffness_loa_n_per_m: f64,
    pub mesh_stiffness_harmonics_loa_n_per_m: Vec<Option<f64>>,
    pub mesh_stiffness_harmonics_phase_rad: Vec<Option<f64>>,
    /// Middles of the stations along the face, from gear 1's z = 0 face.
    pub face_z_mm: Vec<f64>,
    /// Transverse force per face width there, mean over the cycle.
    pub face_load_n_per_mm: Vec<f64>,
    /// Largest over mean of `face_load_n_per_mm`: K_Hbeta.
    pub face_load_factor: f64,
    pub transverse_contact_ratio: f64,
    pub overlap_ratio: f64,
    #[serde(flatten)]
    pub losses: Losses,
    /// Stress in the tooth roots, where it is asked for.
    #[serde(flatten)]
    pub roots: Option<Roots>,
    /// Wall clock of the contact solves.
    pub solve_seconds: f64,
    /// What is to be known of the results, one sentence each; empty where there is nothing.
    pub notes: Vec<String>,
}

impl Report {
    /// The report on `cycle`, solved on `stations` stations.
    pub fn new(
        pair: &Pair,
        input: &CycleInput,
        stations: usize,
        cycle: &MeshCycle,
        losses: Losses,
    ) -> Report {
        let geometry = &pair.geometry;
        let tooth_pairs = cycle.tooth_pairs();
        let edges = || cycle.results.iter().map(|r| r.edge_load);
        let over = |value: fn(&ContactResult) -> f64| cycle.results.iter().map(value).collect();
        let stiffness = cycle.stiffness();
        let of_ste = cycle.harmonics();
        let of_stiffness = harmonics(&stiffness);
        let (low, width) = geometry.face_overlap();
        let face = cycle.face_load(
            [low, low + width],
            stations,
            geometry.base_helix_angle().cos(),
        );
        Report {
            torque_nm: input.torque,
            misalignment_mrad: rounded(input.misalignment * 1e3),
            mesh_position: cycle.mesh_position.clone(),
            ste_loa_um: over(|r| r.approach * 1e6),
            contact_z_mm: over(|r| r.contact_z * 1e3),
            load_share: cycle
                .results
                .iter()
                .map(|r| tooth_pairs.iter().map(|&k| share(r, k)).collect())
                .collect(),
            maximum_pressure_mpa: over(|r| r.max_pressure * 1e-6),
            edge_line_load_n_per_mm: edges()
                .map(|edge| edge.map_or(0.0, |edge| edge.line_load * 1e-3))
                .collect(),
            edge_z_mm: edges().map(|edge| Some(edge?.z * 1e3)).collect(),
            edge_gear: edges().map(|edge| Some(edge?.gear + 1)).collect(),
            tooth_pairs,
            mean_ste_loa_um: cycle.mean_ste() * 1e6,
            peak_to_peak_ste_loa_um: cycle.peak_to_peak_ste() * 1e6,
            harmonics_loa_um: amplitudes(&of_ste, 1e6),
            harmonics_phase_rad: phases(&of_ste),
            mean_mesh_stiffness_loa_n_per_m: stiffness.iter().sum::<f64>() / stiffness.len() as f64,
            mesh_stiffness_harmonics_loa_n_per_m: amplitudes(&of_stiffness, 1.0),
            mesh_stiffness_harmonics_phase_rad: phases(&of_stiffness),
            mesh_stiffness_loa_n_per_m: stiffness,
            face_load_factor: face.face_load_factor(),
            face_z_mm: face.z.iter().map(|z| z * 1e3).collect(),
            face_load_n_per_mm: face.load.iter().map(|load| load * 1e-3).collect(),
            transverse_contact_ratio: geometry
                .transverse_contact_ratio(geometry.center_distance + input.center_distance_offset),
            overlap_ratio: geometry.overlap_ratio(),
            losses,
            roots: None,
            solve_seconds: cycle.solve_seconds,
            notes: (pair::note_on_teeth(&pair.teeth)
                .map(String::from)
                .into_iter())
            .chain(cycle.note_on_segments())
            .collect(),
        }
    }
}

impl Report {
    /// Of the whole cycle, MPa.
    pub fn largest_pressure(&self) -> f64 {
        self.maximum_pressure_mpa
            .iter()
            .copied()
            .fold(0.0, f64::max)
    }

    /// Of the whole cycle, N/mm; zero where no contact reaches a tip edge.
    pub fn largest_edge_load(&self) -> f64 {
        self.edge_line_load_n_per_mm
            .iter()
            .copied()
            .fold(0.0, f64::max)
    }
}

/// Share of a tooth pair in the load.
fn share(result: &ContactResult, pair: i32) -> f64 {
    let of_pair = result.load_share.iter().find(|(k, _)| *k == pair);
    of_pair.map_or(0.0, |(_, share)| *share)
}

fn amplitudes(harmonics: &[Option<Harmonic>], scale: f64) -> Vec<Option<f64>> {
    harmonics
        .iter()
        .map(|h| Some(h.as_ref()?.amplitude * scale))
        .collect()
}

fn phases(harmonics: &[Option<Harmonic>]) -> Vec<Option<f64>> {
    harmonics.iter().map(|h| Some(h.as_ref()?.phase)).collect()
}
