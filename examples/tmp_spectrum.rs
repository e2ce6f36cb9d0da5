use std::path::Path;
use gearmesh::compliance::finite_element::{ModelCache, PairCompliance, Settings};
use gearmesh::contact::{ContactSettings, ContactSolver};
use gearmesh::gear::Flank;
use gearmesh::pair::Pair;
use nalgebra::DMatrix;
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let pair = Pair::read(folder.join(format!("resources/pairs/{name}.json")))?;
    let settings = Settings::for_pair(&pair);
    let cache = ModelCache::new(folder.join("target/finite-elements"), ModelCache::DEFAULT_LIMIT);
    let models = PairCompliance::new(&pair.geometry, &settings, Some(&cache), &|_, _, _| true)?;
    let [first, second] = models.gears;
    let solver = ContactSolver::new(&pair, [first, second], ContactSettings::for_pair(&pair))?;
    for tau in [0.1, 0.6] {
        let p = solver.position(Flank::Drive, tau, 0.0)?;
        let n = p.candidates().len();
        let a = DMatrix::from_row_slice(n, n, p.bulk());
        println!("n {n} tau {tau}");
        let mut e: Vec<f64> = a.clone().symmetric_eigenvalues().iter().copied().collect();
        e.sort_by(|a, b| b.total_cmp(a));
        println!("all, 1e-9: {:?}", e.iter().map(|x| (x * 1e13).round() / 1e4).collect::<Vec<_>>());
        let k = p.candidates()[n / 2].tooth_pair;
        let idx: Vec<usize> = (0..n).filter(|&i| p.candidates()[i].tooth_pair == k).collect();
        let m = idx.len();
        let b = DMatrix::from_fn(m, m, |i, j| a[(idx[i], idx[j])]);
        let mut e: Vec<f64> = b.clone().symmetric_eigenvalues().iter().copied().collect();
        e.sort_by(|a, b| b.total_cmp(a));
        println!("pair {k} ({m}), 1e-9: {:?}", e.iter().map(|x| (x * 1e13).round() / 1e4).collect::<Vec<_>>());
        println!("row: {:?}", (0..m).map(|j| (b[(m/2, j)] * 1e13).round() / 1e4).collect::<Vec<_>>());
        let r = p.solve_torque(pair.operating.nominal_torque, 0.0, None)?;
        println!("active {} forces {:?}", r.forces.iter().filter(|f| **f > 0.0).count(), r.forces.iter().map(|f| f.round()).collect::<Vec<_>>());
        println!("stiffness {:.3e} iterations {}", r.tangent.force_by_approach, r.iterations);
    }
    Ok(())
}
