//! `body_matrix` of a gear: nodes on a cylinder below its teeth, and the stiffness of its body condensed to them.

use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::sync::Arc;

use crate::gear::{BodyShape, NodalStiffness, UnevenBody};
use gearmesh::gear::Gear;
use gearmesh::words::rounded;
use nalgebra::DMatrix;
use serde::Deserialize;

use super::checks::{Refusal, check, ensure, in_gear, refusal};
use super::file::{BodyMatrixFile, MM};
use super::{matrix_market, text};
use crate::finite_element::{body_basis, body_stiffness};
use crate::storage::csv_reader;

/// Deviation from the mean radius of the nodes that still is their rounding, over the radius.
const OFF_CYLINDER: f64 = 1e-4;
/// Least depth of the cylinder below the root, normal modules: nearer to it the teeth are felt.
const LEAST_DEPTH: f64 = 0.5;
/// Least length of the cylinder along the axis, normal modules.
const LEAST_LENGTH: f64 = 0.1;
/// Harmonics that nodes resolve at least: four nodes a wave.
const FEWEST_ORDERS: usize = 8;
/// Most nodes: the matrix has nine times their square as numbers.
const MOST_NODES: usize = 2000;
/// Longest file of a matrix, bytes: half of that of the most nodes with all digits.
const LONGEST_MATRIX: u64 = 512 << 20;
/// Difference of a number to its mirror image over the largest number that still is rounding.
const UNSYMMETRIC: f64 = 1e-6;
/// Least over largest stiffness in the basis: a body that is held nowhere has rounding.
const LEAST_STIFFNESS: f64 = 1e-9;
/// Largest number of the diagonal over Young's modulus times the distance of the nodes: other materials and meshes within, other units
/// beyond.
const USUAL_STIFFNESS: [f64; 2] = [0.01, 100.0];

/// The body of `body_matrix` in gear `i` of a file in `folder`.
pub(super) fn of_matrix(
    given: &BodyMatrixFile,
    gear: &Gear,
    i: usize,
    folder: &Path,
) -> Result<UnevenBody, Refusal> {
    let field = in_gear(i, "body_matrix.angle_deg");
    check(&field, given.angle_deg, [-360.0, 360.0])?;
    // The body is turned by the angle.
    let (sin, cos) = given.angle_deg.to_radians().sin_cos();
    let field = in_gear(i, "body_matrix.nodes_file");
    let cylinder = Cylinder::read(&field, &given.nodes_file, gear, folder)?;
    let points = cylinder.points.iter().map(|[x, y, z]| {
        [
            cos * x - sin * y,
            sin * x + cos * y,
            z.clamp(0.0, gear.face_width),
        ]
    });
    let points = points.collect();
    let field = in_gear(i, "body_matrix.stiffness_n_per_mm_file");
    let file = &given.stiffness_n_per_mm_file;
    let stiffness = read_stiffness(&field, file, gear, folder, &cylinder)?;
    let body = UnevenBody {
        radius: cylinder.radius,
        z: cylinder.ends.map(|z| z.clamp(0.0, gear.face_width)),
        shape: BodyShape::Nodes(Arc::new(NodalStiffness {
            points,
            stiffness: rotated(&stiffness, [sin, cos]) / MM,
            orders: cylinder.orders,
            stations: cylinder.stations,
        })),
    };
    let own = body_stiffness(gear, &body, &body_basis(gear, &body))
        .map_err(|error| refusal!(&field => file; "{error}"; "give another body"))?
        .symmetric_eigenvalues();
    let share = own.min() / own.amax();
    ensure!(share >= LEAST_STIFFNESS, &field => file;
        "is not positive definite: its least stiffness under smooth displacements of the cylinder is {share:.1e} of the largest";
        "give it with the body held where it is supported before it is condensed, and with the sign of a stiffness");
    Ok(body)
}

/// Nodes of a body on a cylinder about the axis, as their file has them.
struct Cylinder {
    /// m.
    points: Vec<[f64; 3]>,
    /// m.
    radius: f64,
    /// Lowest and highest z, m.
    ends: [f64; 2],
    /// Number of different z.
    stations: usize,
    /// Highest order of waves around the axis that the nodes resolve.
    orders: usize,
}

impl Cylinder {
    /// Reads the nodes in `file`, which `field` names, of a body below the teeth of `gear`.
    fn read(field: &str, file: &str, gear: &Gear, folder: &Path) -> Result<Cylinder, Refusal> {
        let text = text::read(&folder.join(file)).map_err(|error| {
            refusal!(field => file;
                "cannot be read: {error}"; "give a file beside the pair file, and that you may read")
        })?;
        let points = nodes(&text).map_err(|problem| {
            refusal!(field => file;
                "{problem}"; "give CSV with the columns x_mm, y_mm and z_mm, a row a node, in the order of the matrix")
        })?;
        let count = points.len();
        ensure!((24..=MOST_NODES).contains(&count), field => file;
            "has {count} nodes"; "give all nodes of the body on the cylinder, 24 to {MOST_NODES}");
        let radius = common_radius(field, file, gear, &points)?;
        let mut z: Vec<f64> = points.iter().map(|[.., z]| *z).collect();
        z.sort_by(f64::total_cmp);
        let ends = [z[0], z[count - 1]];
        let within = -1e-6 <= ends[0] && ends[1] <= gear.face_width + 1e-6;
        ensure!(within && ends[1] - ends[0] >= LEAST_LENGTH * gear.normal_module, field => file;
            "z runs from {:.4} to {:.4} mm, and the face from 0 to {:.4}", ends[0] / MM, ends[1] / MM, gear.face_width / MM;
            "give z from the gear's z = 0 face, over the part of the face where the body joins the rim");
        z.dedup_by(|a, b| (*a - *b).abs() < 1e-3 * (ends[1] - ends[0]));
        let mut angles: Vec<f64> = points.iter().map(|[x, y, _]| y.atan2(*x)).collect();
        angles.sort_by(f64::total_cmp);
        angles.push(angles[0] + TAU);
        let gap = angles.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
        let orders = (0.5 * PI / gap * (1.0 + 1e-6)) as usize;
        ensure!(orders >= FEWEST_ORDERS, field => file;
            "neighbouring nodes lie up to {:.2} deg apart", gap.to_degrees();
            "give nodes all around, at most {:.2} deg apart", 90.0 / FEWEST_ORDERS as f64);
        Ok(Cylinder {
            radius,
            ends,
            stations: z.len(),
            orders,
            points,
        })
    }
}

/// Radius, m, of the cylinder on which the `points` of `file` lie, far enough below the teeth of `gear`.
fn common_radius(
    field: &str,
    file: &str,
    gear: &Gear,
    points: &[[f64; 3]],
) -> Result<f64, Refusal> {
    let radii: Vec<f64> = points.iter().map(|[x, y, _]| x.hypot(*y)).collect();
    let radius = radii.iter().sum::<f64>() / radii.len() as f64;
    let (worst, off) = (radii.iter().enumerate())
        .map(|(node, r)| (node, (r - radius).abs()))
        .fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
    ensure!(off <= OFF_CYLINDER * radius, field => file;
        "node {} lies at the radius {:.4} mm, and the mean of all is {:.4}", worst + 1, radii[worst] / MM, radius / MM;
        "give nodes on one cylinder about the axis, to {:.4} mm", OFF_CYLINDER * radius / MM);
    let (root, least) = (gear.root_radius(), LEAST_DEPTH * gear.normal_module);
    let limit = root - gear.kappa() * least;
    let is_below = gear.kappa() * (limit - radius) >= 0.0 && (0.2..5.0).contains(&(radius / root));
    ensure!(is_below, field => file;
        "the cylinder has the radius {:.4} mm, and the root circle {:.4}", radius / MM, root / MM;
        "give coordinates in mm, and a cylinder {} {:.3} mm in radius", if gear.kappa() > 0.0 { "of at most" } else { "of at least" }, limit / MM);
    Ok(radius)
}

/// The matrix in `file`, N/mm, which `field` names: symmetric, of the size that the nodes of `cylinder` have, and about as stiff as a body of
/// the material of `gear`.
fn read_stiffness(
    field: &str,
    file: &str,
    gear: &Gear,
    folder: &Path,
    cylinder: &Cylinder,
) -> Result<DMatrix<f64>, Refusal> {
    let usual = "that of 2000 nodes is as long";
    let text = text::read_up_to(&folder.join(file), LONGEST_MATRIX, usual).map_err(|error| {
        refusal!(field => file; "cannot be read: {error}";
            "give a file beside the pair file, and that you may read; condense to fewer nodes, and write `symmetric`")
    })?;
    let stiffness = matrix_market::read(&text, 3 * MOST_NODES).map_err(|problem| {
        refusal!(field => file; "{problem}";
            "give a file of the Matrix Market, `coordinate` or `array`, `real`, `general` or `symmetric`")
    })?;
    let count = cylinder.points.len();
    let size = 3 * count;
    ensure!(stiffness.shape() == (size, size), field => file;
        "has {} rows and {} columns, and the {count} nodes have {size} displacements", stiffness.nrows(), stiffness.ncols();
        "give the stiffness condensed to x, y, z of the nodes of `nodes_file`, node by node in that order");
    let odd = (&stiffness - stiffness.transpose()).amax() / stiffness.amax();
    ensure!(odd <= UNSYMMETRIC, field => file;
        "is not symmetric: numbers differ from their mirror images by up to {odd:.1e} of the largest"; "give the whole matrix with all its digits, or its lower triangle as `symmetric`");
    let area = TAU * cylinder.radius * (cylinder.ends[1] - cylinder.ends[0]);
    let usual = gear.youngs_modulus * (area / count as f64).sqrt() * MM;
    let largest = stiffness.diagonal().amax();
    let share = largest / usual;
    ensure!((USUAL_STIFFNESS[0]..=USUAL_STIFFNESS[1]).contains(&share), field => file;
        "its largest number on the diagonal, {largest:.3e}, is {share:.1e} times Young's modulus times the distance of the nodes";
        "give it in N/mm: about {:.0e} there", rounded(usual));
    Ok(stiffness)
}

/// The nodes in `text`, m.
fn nodes(text: &str) -> Result<Vec<[f64; 3]>, String> {
    #[derive(Deserialize)]
    struct Row {
        x_mm: f64,
        y_mm: f64,
        z_mm: f64,
    }
    let rows = csv_reader(text).into_deserialize();
    let points = rows.map(|row| {
        let Row { x_mm, y_mm, z_mm } = row.map_err(|error: csv::Error| error.to_string())?;
        let point = [x_mm, y_mm, z_mm].map(|mm| mm * MM);
        match point.iter().all(|x| x.is_finite()) {
            true => Ok(point),
            false => Err(format!("holds the node {x_mm}, {y_mm}, {z_mm}")),
        }
    });
    points.collect()
}

/// `stiffness` of a body turned about the axis by the angle of this sine and cosine.
fn rotated(stiffness: &DMatrix<f64>, [sin, cos]: [f64; 2]) -> DMatrix<f64> {
    let mut rotated = stiffness.clone();
    // Symmetric: turned rows become columns, and then they are turned, too.
    for _ in 0..2 {
        for x in (0..rotated.nrows()).step_by(3) {
            for mut column in rotated.column_iter_mut() {
                let (a, b) = (column[x], column[x + 1]);
                (column[x], column[x + 1]) = (cos * a - sin * b, sin * a + cos * b);
            }
        }
        rotated.transpose_mut();
    }
    rotated
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;
    use gearmesh::gear::GearKind;
    use std::fs;

    /// Nodes on a cylinder of `radius` (mm), and springs of `stiffness` (N/mm) at each.
    fn files(radius: f64, stiffness: f64) -> (Vec<[f64; 3]>, DMatrix<f64>) {
        let nodes = (0..96 * 5).map(|k| {
            let (angle, z) = (
                TAU * f64::from(k % 96) / 96.0,
                5.0 * f64::from(k / 96) + 2.5,
            );
            [radius * angle.cos(), radius * angle.sin(), z]
        });
        (
            nodes.collect(),
            DMatrix::from_diagonal_element(1440, 1440, stiffness),
        )
    }

    fn read(
        nodes: &[[f64; 3]],
        matrix: &DMatrix<f64>,
        symmetric: bool,
    ) -> Result<UnevenBody, Refusal> {
        let folder = tempfile::tempdir().unwrap();
        let rows = nodes.iter().map(|[x, y, z]| format!("{x},{y},{z}\n"));
        let rows: String = rows.collect();
        fs::write(
            folder.path().join("nodes.csv"),
            format!("x_mm,y_mm,z_mm\n{rows}"),
        )
        .unwrap();
        let (rows, columns) = matrix.shape();
        let kind = if symmetric { "symmetric" } else { "general" };
        let entries: Vec<String> = (0..rows * columns)
            .map(|at| (at % rows, at / rows))
            .filter(|(i, j)| matrix[(*i, *j)] != 0.0 && (!symmetric || i >= j))
            .map(|(i, j)| format!("{} {} {}\n", i + 1, j + 1, matrix[(i, j)]))
            .collect();
        let head = format!(
            "%%MatrixMarket matrix coordinate real {kind}\n% springs\n{rows} {columns} {}\n",
            entries.len()
        );
        fs::write(folder.path().join("k.mtx"), head + &entries.concat()).unwrap();
        let gear = samples::gear(GearKind::External, 36, 1.0, 0.0, 0.0);
        let given = BodyMatrixFile {
            nodes_file: "nodes.csv".into(),
            stiffness_n_per_mm_file: "k.mtx".into(),
            angle_deg: 30.0,
        };
        of_matrix(&given, &gear, 0, folder.path())
    }

    #[test]
    fn springs_all_around_are_a_foundation() {
        let (nodes, matrix) = files(58.0, 1e6);
        for symmetric in [true, false] {
            let body = read(&nodes, &matrix, symmetric).unwrap();
            let BodyShape::Nodes(given) = &body.shape else {
                panic!()
            };
            assert_eq!((given.orders, given.stations), (24, 5));
            let gear = samples::gear(GearKind::External, 36, 1.0, 0.0, 0.0);
            let basis = body_basis(&gear, &body);
            let found = body_stiffness(&gear, &body, &basis).unwrap();
            // Springs per area of the cylinder, whose edges are the outermost nodes.
            let area = TAU * 58e-3 * 20e-3;
            let expected = 1e9 * 480.0 / area;
            let first = found[(0, 0)];
            assert!((first / expected - 1.0).abs() < 1e-9, "{first} {expected}");
            let off = (0..3).map(|i| found[(i, i + 3)].abs()).fold(0.0, f64::max);
            assert!(off < 1e-9 * expected, "{off}");
        }
    }

    #[test]
    fn a_matrix_or_nodes_that_cannot_be_are_refused_with_a_number_and_a_remedy() {
        let good = files(58.0, 1e6);
        let refused =
            |change: fn(&mut Vec<[f64; 3]>, &mut DMatrix<f64>), field: &str, words: &str| {
                let (mut nodes, mut matrix) = good.clone();
                change(&mut nodes, &mut matrix);
                let Err(refusal) = read(&nodes, &matrix, false) else {
                    panic!("{words}")
                };
                assert!(refusal.field.ends_with(field), "{refusal}");
                assert!(refusal.problem.contains(words), "{refusal}");
                assert!(refusal.remedy.starts_with("give"), "{refusal}");
            };
        let (nodes, stiffness) = ("nodes_file", "stiffness_n_per_mm_file");
        refused(
            |nodes, _| nodes[7][0] += 0.1,
            nodes,
            "node 8 lies at the radius",
        );
        refused(
            |nodes, _| *nodes = files(0.058, 0.0).0,
            nodes,
            "the cylinder has the radius 0.0580 mm",
        );
        refused(
            |nodes, _| *nodes = files(68.5, 0.0).0,
            nodes,
            "the root circle 67.0000",
        );
        refused(
            |nodes, _| nodes.iter_mut().for_each(|n| n[2] += 3.0),
            nodes,
            "z runs from 5.5000 to 25.5000 mm",
        );
        refused(
            |nodes, _| nodes.retain(|n| n[0] > -50.0),
            nodes,
            "deg apart",
        );
        refused(
            |_, matrix| matrix[(3, 9)] = 1e3,
            stiffness,
            "by up to 1.0e-3 of the largest",
        );
        refused(
            |_, matrix| *matrix *= 1e3,
            stiffness,
            "times Young's modulus",
        );
        refused(
            |_, matrix| *matrix = DMatrix::identity(9, 9),
            stiffness,
            "has 9 rows and 9 columns, and the 480 nodes have 1440",
        );
        refused(
            |_, matrix| matrix.fill_diagonal(-1e6),
            stiffness,
            "is not positive definite",
        );
        // Nothing holds it along the axis.
        refused(
            |_, matrix| (2..1440).step_by(3).for_each(|i| matrix[(i, i)] = 0.0),
            stiffness,
            "is not positive definite",
        );
    }
}
