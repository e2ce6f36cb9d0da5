use std::path::Path;
use gearmesh::compliance::finite_element::{ModelCache, PairCompliance, Settings};
use gearmesh::contact::{ContactFile, ContactSettings, ContactSolver, Warm};
use gearmesh::gear::Flank;
use gearmesh::pair::Pair;
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).unwrap();
    let steps: usize = std::env::args().nth(2).unwrap().parse()?;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let pair = Pair::read(folder.join(format!("resources/pairs/{name}.json")))?;
    let kept = format!("/tmp/h12-{name}.bin");
    let force = std::env::args().nth(3).is_some();
    let file = match std::fs::read(&kept).ok().filter(|_| !force).map(|b| ContactFile::from_bytes(&b)) {
        Some(Ok(file)) => file,
        _ => {
            let settings = Settings::for_pair(&pair);
            let cache = ModelCache::new(folder.join("target/finite-elements"), ModelCache::DEFAULT_LIMIT);
            let models = PairCompliance::new(&pair.geometry, &settings, Some(&cache), &|_, _, _| true)?;
            let [first, second] = models.gears;
            let solver = ContactSolver::new(&pair, [first, second], ContactSettings::for_pair(&pair))?;
            let file = ContactFile::new(&pair, &solver)?;
            std::fs::write(&kept, file.to_bytes())?;
            file
        }
    };
    let contact = file.flank(Flank::Drive).unwrap();
    let torque = pair.operating.nominal_torque / pair.geometry.gears[0].base_radius();
    // approach for the nominal force at 0, by secant
    let mut a = 10e-6;
    for _ in 0..30 {
        let f = contact.potential([a, 0.0, 0.0, 0.0], &mut Warm::default())?;
        if f.gradient[0] == 0.0 { a *= 2.0; continue; }
        a -= (f.gradient[0] - torque) / f.tangent.force_by_approach;
    }
    let mut warm = Warm::default();
    let begin = std::time::Instant::now();
    let mut sum = [0.0f64; 5];
    for i in 0..steps {
        let p = contact.potential([a, 0.0, 0.0, i as f64 * 1e-3], &mut warm)?;
        sum[0] += p.energy;
        for k in 0..4 { sum[k + 1] += p.gradient[k].abs(); }
    }
    let each = begin.elapsed().as_secs_f64() / steps as f64;
    println!("{name} approach {a:.4e} {:.1} us {:?}", 1e6 * each, sum.map(|s| s / steps as f64));
    Ok(())
}
