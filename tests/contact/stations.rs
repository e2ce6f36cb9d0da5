//! How few stations along the face are enough.

use super::*;
use gearmesh::gear::Flank;
use gearmesh::random::Random;

#[test]
fn few_stations_at_run_time_say_what_many_do() {
    let pairs = [
        (include_str!("../../resources/pairs/palermo2013.json"), 1e-3),
        (
            include_str!("../../resources/pairs/planet-ring-27-84.json"),
            2e-3,
        ),
    ];
    for (text, bound) in pairs {
        let pair = pair::from_json(text).unwrap();
        let solver = |stations| coarse_solver(&pair, with_stations(stations));
        let (few, many) = (solver(40).at_run_time(), solver(160));
        assert!(few.settings().stations < 24);
        let operating = &pair.operating;
        let nominal = operating.nominal_torque / pair.geometry.gears[0].base_radius();
        let half_face = 0.5 * pair.geometry.face_overlap().1;
        let (mut random, poses) = (Random::new(9), 30);
        let mut squares = [0.0; 2];
        for _ in 0..poses {
            let misalignment = random.within(operating.misalignment);
            let torque = random.within([0.1, 1.0]) * operating.maximum_torque;
            let tau = random.within([0.0, 1.0]);
            let [a, b] = [&many, &few].map(|s| s.position(Flank::Drive, tau, 0.0).unwrap());
            let exact = a.solve_torque(torque, misalignment, None).unwrap();
            let found = b
                .solve_approach(exact.approach, misalignment, None)
                .unwrap();
            squares[0] += ((found.loa_force - exact.loa_force) / nominal).powi(2);
            squares[1] += ((found.moment - exact.moment) / (nominal * half_face)).powi(2);
        }
        let rms = squares.map(|sum| (sum / f64::from(poses)).sqrt());
        println!("{}: {rms:?}", pair.name);
        assert!(rms.iter().all(|rms| *rms < bound), "{}: {rms:?}", pair.name);
    }
}
