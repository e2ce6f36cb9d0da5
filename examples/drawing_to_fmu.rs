//! From a drawing to an FMU in five calls: the pair file, the elastic models of its gears, static contact over one mesh
//! cycle, tables over the operating range, and the archive that a simulator imports.
//!
//! `cargo run --release --example drawing_to_fmu [PAIR.json [PAIR.fmu]]`, after `make build`, which leaves the library of
//! the FMU in target/release.

use std::path::Path;

use gearmesh::gear::Flank;
use gearmesh_preprocessor::contact::{
    CycleInput, ElasticModels, LoadCase, MeshCycle, ModelSettings,
};
use gearmesh_preprocessor::gear::{Pair, Refinement};
use gearmesh_preprocessor::package::{self, Contents, Library, Starts};
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::table::{Recipe, size_and_error};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let drawing = arguments.next();
    let fmu = arguments
        .next()
        .unwrap_or("target/drawing_to_fmu.fmu".into());

    // 1. The pair: checked, SI units, defaults filled in.
    let pair = Pair {
        refinement: Refinement::Coarse, // seconds; docs/choosing.md has the error of each level
        ..pair::read(drawing.unwrap_or("resources/pairs/palermo2013.json".into()))?
    };

    // 2. Finite elements of both gears, the longest part; ModelSettings::cache keeps them.
    let progress = &|stage: &str, share: f64| eprint!("\r{stage}: {:3.0} %  ", 100.0 * share);
    let models = ElasticModels::new(&pair, &ModelSettings::default(), progress)?;

    // 3. One mesh cycle of the drive flank: nominal centre distance and torque, parallel axes.
    let input = CycleInput {
        flank: Flank::Drive,
        center_distance_offset: 0.0,
        positions: 32,
    };
    let load = LoadCase {
        torque: pair.operating.nominal_torque, // N m on gear 1
        misalignment: 0.0,
    };
    let cycle = MeshCycle::solve(&models.solver, &input, load)?;
    let [mean, range] = [cycle.mean_ste(), cycle.peak_to_peak_ste()].map(|m| 1e6 * m);
    println!("\nstatic transmission error: mean {mean:.2} um, peak to peak {range:.3} um");
    println!("largest pressure {:.0} MPa", 1e-6 * cycle.max_pressure());

    // 4. Tables over the operating range of the pair file, without the centre distance.
    let recipe = Recipe {
        center_distance: false,
        ..Recipe::default()
    };
    let made = recipe.compute(&models, progress)?;
    let solves = made.account.quality.solves;
    println!("\n{solves} static solves: {}", size_and_error(&made.file));

    // 5. The archive, with every effect on that the tables hold.
    let contents = Contents {
        name: &pair.name,
        geometry: &pair.geometry,
        contact: made.contact.as_ref(),
        starts: &Starts::of_tables(&made.file)?,
    };
    let library = Library::read(Path::new("target/release/libgearmesh.so"))?;
    let packed = package::pack(&contents, &[library], Path::new(&fmu))?;
    println!("{fmu}: {} bytes, GUID {}", packed.bytes, packed.guid);
    Ok(())
}
