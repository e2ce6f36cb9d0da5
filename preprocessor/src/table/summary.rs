//! What a tables file covers and how far it can be trusted, in words for `gearmesh inspect` and the FMU's page.

use gearmesh::gear::BodyOrders;
use gearmesh::table::{LoadAxes, TableFile, TeethRecord};
use gearmesh::words::{count, fixed, rounded};
use serde_json::Value;

/// Rows of name and value: origin, size and error, ranges, settings of the solver.
pub fn summary(file: &TableFile) -> Vec<(String, String)> {
    let axes = &file.axes;
    let [nominal, maximum] = [file.nominal_torque_nm, file.maximum_torque_nm].map(rounded);
    let fractions = &axes.displacement_fraction;
    let mut rows = vec![
        ("made by", file.generator.clone()),
        ("from", file.source.clone()),
        ("size and error", size_and_error(file)),
        (
            "torque on gear 1",
            format!("nominal {nominal} N m, up to {maximum} N m"),
        ),
        (
            "displacement",
            range(fractions, 1.0, "from no-load to top-load approach"),
        ),
        (
            "centre distance offset",
            range(&axes.center_distance_offset, 1e6, "um"),
        ),
        ("misalignment", range(&axes.misalignment, 1e3, "mrad")),
        (
            "mesh position",
            range(&axes.mesh_position, 1.0, "base pitches, periodic"),
        ),
        (
            "centre distance",
            format!("{:.4} mm", file.geometry.center_distance * 1e3),
        ),
        ("checksum", file.checksum_sha256.clone()),
    ];
    rows.extend(file.friction.as_ref().map(|friction| {
        let words = format!("{}; {}", friction.law, load_axes_in_words(&friction.axes));
        ("friction", words)
    }));
    rows.extend(file.root_stress.as_ref().map(|stress| {
        let words = format!(
            "{}, {}",
            load_axes_in_words(&stress.axes),
            stress.interpolation_error
        );
        ("root stress", words)
    }));
    rows.extend(
        (file.teeth.as_ref()).map(|teeth| ("tooth pairs one by one", teeth_in_words(teeth))),
    );
    rows.extend(
        file.bodies
            .as_ref()
            .map(|bodies| ("bodies", bodies_in_words(bodies))),
    );
    let settings = file.solver.iter().map(|(name, value)| {
        let is_of_gear = name.starts_with("modifications");
        let prefix = if is_of_gear { "" } else { "solver: " };
        // Strings without the quotation marks of JSON.
        let text = match value {
            Value::String(text) => text.clone(),
            Value::Number(number) if number.is_f64() => {
                format!("{:.1e}", number.as_f64().unwrap_or(f64::NAN))
            }
            other => other.to_string(),
        };
        let name = name.replace("kkt_residual", "residual of the contact conditions");
        (format!("{prefix}{}", name.replace('_', " ")), text)
    });
    let rows = rows
        .into_iter()
        .map(|(name, value)| (name.to_owned(), value));
    rows.chain(settings).collect()
}

/// The strongest order of each body under loads on the drive flank.
fn bodies_in_words(bodies: &BodyOrders) -> String {
    let gears = bodies.drive.iter().enumerate();
    let gears = gears.filter_map(|(gear, orders)| {
        let sized = orders.iter().map(|part| {
            let [cos, sin] = part.approach_m_per_n;
            (cos.hypot(sin), part.order)
        });
        let (size, order) = sized.max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(format!(
            "gear {} changes the compliance {} times a turn by {:.3} um/kN ({} orders)",
            gear + 1,
            order,
            1e9 * size,
            orders.len()
        ))
    });
    gears.collect::<Vec<_>>().join("; ")
}

/// Nodes, flanks and measured error in one line.
pub fn size_and_error(file: &TableFile) -> String {
    let error = file.interpolation_error;
    format!(
        "{}, {}, {}",
        in_words(file.axes.lengths(), &GRID),
        match file.coast {
            Some(_) => "each flank",
            None => "one flank for both",
        },
        error.map_or_else(|| "error not measured".into(), |error| error.to_string())
    )
}

const GRID: [&str; 4] = [
    "centre distance",
    "misalignment",
    "displacement",
    "mesh position",
];

/// `lengths` of axes with their `names`, displacement or load first.
fn in_words(lengths: [usize; 4], names: &[&str; 4]) -> String {
    [2, 0, 1, 3]
        .map(|i| count(lengths[i], names[i]))
        .join(" x ")
}

/// Nodes, coupling and error against contact at run time in one line.
pub fn teeth_in_words(record: &TeethRecord) -> String {
    // Least and largest at each distance.
    let coupling: Vec<String> = record
        .coupling_m_per_n
        .iter()
        .map(|values| {
            let [least, largest] = [f64::min, f64::max].map(|choose| {
                let value = values.iter().copied().reduce(choose);
                format!("{:.2}", value.map_or(f64::NAN, |c| 1e9 * c))
            });
            match least == largest {
                true => least,
                false => format!("{least} to {largest}"),
            }
        })
        .collect();
    let [c, m, u, _] = GRID;
    format!(
        "{} from {:.2} to {:.2} base pitches; coupling of tooth pairs, neighbours first, {} um/kN; {} against contact at run time",
        in_words(record.axes.lengths(), &[c, m, u, "place"]),
        record.first_place,
        record.last_place,
        coupling.join(", "),
        record.error
    )
}

fn load_axes_in_words(axes: &LoadAxes) -> String {
    let [c, m, _, p] = GRID;
    in_words(axes.lengths(), &[c, m, "force", p])
}

fn range(nodes: &[f64], scale: f64, unit: &str) -> String {
    match nodes {
        [] => "none".into(),
        [only] => format!("{} {unit}, no axis", fixed(only * scale, 4)),
        [first, .., last] => format!(
            "{} to {} {unit}, {}",
            fixed(first * scale, 4),
            fixed(last * scale, 4),
            count(nodes.len(), "node")
        ),
    }
}
