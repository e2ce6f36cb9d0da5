use super::*;

fn paper_solver(text: &str, settings: ContactSettings) -> ContactSolver {
    coarse_solver(&pair::from_json(text).unwrap(), settings)
}

fn cycle(solver: &ContactSolver, torque: f64, misalignment: f64) -> MeshCycle {
    mesh_cycle(solver, torque, misalignment, 32)
}

#[test]
fn peak_to_peak_of_the_modified_pair_is_least_between_85_and_130_nm() {
    let modified = paper_solver(PAPER, ContactSettings::default());
    let torques: Vec<f64> = (2..=20).map(|i| 10.0 * f64::from(i)).collect();
    let (least, peak_to_peak) = torques
        .iter()
        .map(|&t| (t, cycle(&modified, t, 0.0).peak_to_peak_ste()))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap();
    assert!((85.0..=130.0).contains(&least), "least at {least} N m");
    let unmodified = paper_solver(UNMODIFIED, ContactSettings::default());
    let plain = cycle(&unmodified, least, 0.0).peak_to_peak_ste();
    assert!(peak_to_peak < 0.25 * plain, "{peak_to_peak} of {plain}");
}

#[test]
fn misalignment_moves_the_contact_to_the_closing_side_and_the_mean_ste_down() {
    let solver = paper_solver(PAPER, ContactSettings::default());
    let at = |m: f64| cycle(&solver, 100.0, m);
    let (aligned, plus, minus) = (at(0.0), at(3e-3), at(-3e-3));
    let mean_z = |cycle: &MeshCycle| {
        let results = &cycle.results;
        results.iter().map(|r| r.contact_z).sum::<f64>() / results.len() as f64
    };
    assert!(mean_z(&plus) > 20e-3 && mean_z(&minus) < 5e-3);
    // Both ends alike: the pair is its own mirror image but for the number of its gears, which tells on tip
    // edges, where the torque is that on gear 1.
    let path = ContactSettings {
        tip_corner_contact: false,
        ..Default::default()
    };
    let on_path = paper_solver(PAPER, path);
    let at = |m: f64| cycle(&on_path, 100.0, m).mean_ste();
    assert!((at(3e-3) - at(-3e-3)).abs() < 1e-12);
    assert!((plus.mean_ste() - minus.mean_ste()).abs() < 1e-3 * aligned.mean_ste());
    // Fig. 23: the teeth of the misaligned pair carry the load at a negative transmission error.
    assert!(plus.mean_ste() < 0.0 && aligned.mean_ste() > 12e-6);
    // Twice the stations change nothing that matters.
    let finer = paper_solver(PAPER, with_stations(80));
    let change = cycle(&finer, 100.0, 0.0).mean_ste() / aligned.mean_ste() - 1.0;
    assert!(change.abs() < 5e-3, "{change}");
}
