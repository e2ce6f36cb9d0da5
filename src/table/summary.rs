//! What a tables file covers and how far it can be trusted, in words for `gearmesh inspect` and the FMU's page.

use super::{
    CouplingRecord, InterpolationError, LoadAxes, RootStressError, TableFile, TeethRecord,
};
use crate::words::{count, fixed, rounded};

impl TableFile {
    /// Rows of name and value: origin, size and error, ranges, settings of the solver.
    pub fn summary(&self) -> Vec<(String, String)> {
        let axes = &self.axes;
        let mut rows = vec![
            ("made by".to_owned(), self.generator.clone()),
            ("from".into(), self.source.clone()),
            ("size and error".into(), self.size_and_error()),
            (
                "torque on gear 1".into(),
                format!(
                    "nominal {} N m, up to {} N m",
                    rounded(self.nominal_torque_nm),
                    rounded(self.maximum_torque_nm)
                ),
            ),
            (
                "displacement".into(),
                range(
                    &axes.displacement_fraction,
                    1.0,
                    "from no-load to top-load approach",
                ),
            ),
            (
                "centre distance offset".into(),
                range(&axes.center_distance_offset, 1e6, "um"),
            ),
            (
                "misalignment".into(),
                range(&axes.misalignment, 1e3, "mrad"),
            ),
            (
                "mesh position".into(),
                range(&axes.mesh_position, 1.0, "base pitches, periodic"),
            ),
            (
                "centre distance".into(),
                self.geometry.pair_geometry().map_or_else(
                    |error| error.to_string(),
                    |pair| format!("{:.4} mm", pair.center_distance * 1e3),
                ),
            ),
            ("checksum".into(), self.checksum_sha256.clone()),
        ];
        if let Some(friction) = &self.friction {
            let nodes = friction.axes.in_words();
            rows.push(("friction".into(), format!("{}; {nodes}", friction.law)));
        }
        if let Some(root_stress) = &self.root_stress {
            let words = format!(
                "{}, {}",
                root_stress.axes.in_words(),
                root_stress.interpolation_error
            );
            rows.push(("root stress".into(), words));
        }
        if let Some(teeth) = &self.teeth {
            rows.push(("tooth pairs one by one".into(), teeth.in_words()));
        }
        for (name, value) in &self.solver {
            // Strings without the quotation marks of JSON.
            let value = value
                .as_str()
                .map_or_else(|| value.to_string(), str::to_owned);
            let name = name.replace('_', " ");
            rows.push(if name.starts_with("modifications") {
                (name, value)
            } else {
                (format!("solver: {name}"), value)
            });
        }
        rows
    }

    /// Nodes, flanks and measured error in one line.
    pub fn size_and_error(&self) -> String {
        let axes = &self.axes;
        let error = self
            .interpolation_error
            .map_or_else(|| "error not measured".into(), |error| error.to_string());
        format!(
            "{} x {} x {} x {}, {} flank{}, {error}",
            count(axes.displacement_fraction.len(), "displacement"),
            count(axes.center_distance_offset.len(), "centre distance"),
            count(axes.misalignment.len(), "misalignment"),
            count(axes.mesh_position.len(), "mesh position"),
            if self.coast.is_some() { "each" } else { "one" },
            if self.coast.is_some() {
                ""
            } else {
                " for both"
            },
        )
    }
}

impl std::fmt::Display for InterpolationError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "error at {} random points: force {:.2} % rms, {:.2} % at most, of the nominal force; shuttling \
             moment {:.2} % rms, {:.2} % at most, of that force at an end of the face",
            self.points,
            1e2 * self.force_rms,
            1e2 * self.force_maximum,
            1e2 * self.moment_rms,
            1e2 * self.moment_maximum
        )
    }
}

impl TeethRecord {
    /// Nodes, coupling and error against contact at run time in one line.
    pub fn in_words(&self) -> String {
        let axes = &self.axes;
        format!(
            "{} x {} x {} x {} from {:.2} to {:.2} base pitches; of the approach others take {} um/kN; {} against contact at run time",
            count(axes.displacement_fraction.len(), "displacement"),
            count(axes.center_distance_offset.len(), "centre distance"),
            count(axes.misalignment.len(), "misalignment"),
            count(axes.mesh_position.len(), "place"),
            self.first_place,
            self.last_place,
            self.coupling_m_per_n.in_words(),
            self.error
        )
    }
}

impl CouplingRecord {
    /// Least and largest at each distance, um/kN.
    fn in_words(&self) -> String {
        let at_distance = |values: &[f64]| {
            let um_per_kn = |of: fn(f64, f64) -> f64| {
                let value = values.iter().copied().reduce(of);
                format!("{:.2}", value.map_or(f64::NAN, |c| 1e9 * c))
            };
            match [f64::min, f64::max].map(um_per_kn) {
                [least, largest] if least == largest => least,
                [least, largest] => format!("{least} to {largest}"),
            }
        };
        let distances: Vec<String> = self.0.iter().map(|row| at_distance(row)).collect();
        distances.join(", ")
    }
}

impl LoadAxes {
    /// Nodes in one line.
    fn in_words(&self) -> String {
        let [c, m, f, p] = self.lengths();
        format!(
            "{} x {} x {} x {}",
            count(f, "force"),
            count(c, "centre distance"),
            count(m, "misalignment"),
            count(p, "mesh position")
        )
    }
}

impl std::fmt::Display for RootStressError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "error at {} random points: {:.2} % rms, {:.2} % at most, of the largest stress at nominal torque",
            self.points,
            1e2 * self.rms,
            1e2 * self.maximum
        )
    }
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
