//! Time and memory as tables grow and as instances multiply, with one shared table and with their own.

use crate::document::{Document, Error};
use crate::plot::{Series, log_log};
use crate::setting::Setting;
use crate::timing::{Candidate, medians, timed};
use gearmesh::gear::Flank;
use gearmesh::random::Random;
use gearmesh::table::samples::Spring;
use gearmesh::table::{FlankGrid, FlankTable, Interpolation, Query, Table, TableFile};
use std::hint::black_box;

const POINTS: usize = 512;

/// Random points in the range of [`Spring`]'s grids.
fn points() -> Vec<Query> {
    let mut random = Random::new(0x9E37_79B9_7F4A_7C15);
    (0..POINTS)
        .map(|_| {
            let (c, m) = (random.within([-1e-4, 1e-4]), random.within([-3e-3, 3e-3]));
            Query {
                delta: 1e-6 * random.within([0.7, 6.7]) + 3e-3 * c - 0.2 * m * m,
                center_distance_offset: c,
                misalignment: m,
                mesh_position: random.next(),
            }
        })
        .collect()
}

/// The section.
pub fn report(
    document: &mut Document,
    setting: &Setting,
    samples: &FlankGrid,
) -> Result<(), Error> {
    document.section("Growth with table size and number of instances");
    let points = points();
    let counts = [
        [6, 4, 5, 8],
        [8, 5, 9, 16],
        [12, 9, 9, 32],
        [12, 9, 17, 32],
        [16, 9, 33, 64],
        [24, 17, 33, 96],
    ];
    let mut rows = vec![];
    let mut tables = vec![];
    for counts in counts {
        let mut grid = Spring::grid(counts);
        let text = setting.file(&grid).to_json();
        let (file, reading) = timed(|| TableFile::from_json(&text));
        let (table, fitting) = timed(|| Table::from_file(file?));
        let bytes = table?.flank(Flank::Drive).0.bytes();
        grid.moment = None;
        tables.push(FlankTable::new(&grid, Interpolation::Spline)?);
        rows.push((counts, text.len(), bytes, reading, fitting));
    }
    let mut candidates: Vec<Candidate> = tables
        .iter()
        .map(|t| {
            let points = &points;
            Candidate::new(POINTS, move || {
                for q in points {
                    black_box(t.evaluate(black_box(q), false));
                }
            })
        })
        .collect();
    let times = medians(&mut candidates);
    drop(candidates);
    document.paragraph(
        "4-D splines of formula samples at random points, one instance. Reading is parsing and checking \
         the file's text, preparing is fitting and the checks of monotony; an FMU does both once per process \
         and content.",
    );
    let cells: Vec<[String; 6]> = rows
        .iter()
        .zip(&times)
        .map(
            |(([nu, nc, nm, np], text, bytes, reading, fitting), time)| {
                [
                    format!("{nu} × {nc} × {nm} × {np}"),
                    format!("{:.2}", *text as f64 / 1e6),
                    format!("{:.2}", *bytes as f64 / 1e6),
                    format!("{:.0}", 1e3 * reading),
                    format!("{:.0}", 1e3 * fitting),
                    format!("{time:.0}"),
                ]
            },
        )
        .collect();
    document.table(
        [
            "grid",
            "file, MB",
            "memory, MB",
            "reading, ms",
            "preparing, ms",
            "evaluation, ns",
        ],
        &cells,
    );

    let instances = [1, 2, 4, 8, 16, 32, 64, 128];
    let largest = instances[instances.len() - 1];
    let own: Vec<FlankTable> = (0..largest)
        .map(|_| FlankTable::new(samples, Interpolation::Spline))
        .collect::<Result<_, _>>()?;
    let exact: Vec<Query> = setting
        .exact(&setting.ranges(4), POINTS)?
        .into_iter()
        .map(|x| x.query)
        .collect();
    let mut candidates = vec![];
    for n in instances {
        for shared in [true, false] {
            let (own, exact) = (&own, &exact);
            candidates.push(Candidate::new(POINTS, move || {
                for (i, q) in exact.iter().enumerate() {
                    let table = &own[if shared { 0 } else { i % n }];
                    black_box(table.evaluate(black_box(q), false));
                }
            }));
        }
    }
    let times = medians(&mut candidates);
    drop(candidates);
    let line = |label: &str, offset: usize| Series {
        label: label.to_owned(),
        points: instances
            .iter()
            .enumerate()
            .map(|(i, &n)| (n as f64, times[2 * i + offset]))
            .collect(),
        joined: true,
    };
    document.paragraph(&format!(
        "Instances that take turns, each with a 4-D table of {:.1} MB, shared (as in the FMU) or its own:",
        own[0].bytes() as f64 / 1e6
    ));
    let cells: Vec<[String; 4]> = instances
        .iter()
        .enumerate()
        .map(|(i, n)| {
            [
                n.to_string(),
                format!("{:.0}", times[2 * i]),
                format!("{:.0}", times[2 * i + 1]),
                format!("{:.1}", (n * own[0].bytes()) as f64 / 1e6),
            ]
        })
        .collect();
    document.table(
        [
            "instances",
            "shared, ns",
            "own, ns",
            "memory of own tables, MB",
        ],
        &cells,
    );
    let svg = log_log(
        "instances",
        "time of one evaluation, ns",
        &[line("shared table", 0), line("own tables", 1)],
        &[],
    )?;
    document.plot(
        "speed-instances",
        "Instances with a shared table and with their own",
        &svg,
    )
}
