//! `gearmesh new`: a pair file to start from, with a comment on every field.

use std::cmp::Ordering;
use std::path::PathBuf;

use askama::Template;
use clap::{Args, Command};
use gearmesh::words::rounded;
use gearmesh_preprocessor::gear::Pair;
use gearmesh_preprocessor::import::rexs;
use gearmesh_preprocessor::pair::{self, PairError, Refusals};

use crate::error::{Error, Result};
use crate::{limits, output};

/// Write a commented pair file to start from.
///
/// What is not given gets usual values: centre distance from the tooth numbers, backlash after ISO/TR
/// 10064-2, profile shift where teeth would be undercut, faces centred on each other.
#[derive(Debug, Args)]
pub struct New {
    /// Numbers of teeth of gear 1 and gear 2; that of a ring may be negative, for a file in the signs of ISO 21771
    #[arg(long, num_args = 2, allow_negative_numbers = true, value_names = ["Z1", "Z2"], required_unless_present = "rexs")]
    teeth: Vec<i32>,

    /// Normal module, mm
    #[arg(long, required_unless_present = "rexs", value_parser = limits::positive)]
    module_mm: Option<f64>,

    /// Face widths of gear 1 and gear 2, mm
    #[arg(long, num_args = 2, value_names = ["B1", "B2"], required_unless_present = "rexs", value_parser = limits::finite)]
    face_width_mm: Vec<f64>,

    /// Nominal torque on gear 1, N m
    #[arg(long, required_unless_present = "rexs", value_parser = limits::finite)]
    torque_nm: Option<f64>,

    /// Take a cylindrical stage of this REXS file, .rexs (XML), .rexsj (JSON) or .rexsz (zip); lists what it took, derived, assumed and left out
    #[arg(long, value_name = "FILE", conflicts_with_all = ["teeth", "module_mm", "face_width_mm", "helix_angle_deg", "pressure_angle_deg", "internal", "name"])]
    rexs: Option<PathBuf>,

    /// Component of that stage [default: the only one]
    #[arg(long, value_name = "ID", requires = "rexs")]
    stage: Option<u64>,

    /// Helix angle at the reference cylinder, degrees; > 0: gear 1 right-handed
    #[arg(long, default_value_t = 0.0, value_parser = limits::finite)]
    helix_angle_deg: f64,

    /// Normal pressure angle, degrees
    #[arg(long, default_value_t = 20.0, value_parser = limits::finite)]
    pressure_angle_deg: f64,

    /// Gear 2 is a ring
    #[arg(long)]
    internal: bool,

    /// Name of the pair [default: that of the file]
    #[arg(long)]
    name: Option<String>,

    /// Pair file to write; one that is there is not overwritten [default: standard output]
    #[arg(short, long)]
    output: Option<PathBuf>,
}

#[derive(Template)]
#[template(path = "new.json", escape = "none")]
struct File<'a> {
    new: &'a New,
    name: serde_json::Value,
    derived: &'a str,
    module: f64,
    usual: &'a Usual,
    /// Between the z = 0 faces, which share their middle.
    offset: f64,
    torque: f64,
    most: f64,
    /// Centre distances in the tables over and under the nominal one, um.
    closer: f64,
    apart: f64,
}

/// What a file gets that follows from the pair without it.
struct Usual {
    backlash_um: f64,
    /// Of the tools, over the module; that of the pair file's default.
    tool_tip_radius: [f64; 2],
    /// Over the module.
    addendum: [f64; 2],
}

impl Usual {
    fn is_shortened(&self, i: usize) -> bool {
        self.addendum[i] < 1.0
    }
}

/// Least addendum that teeth are shortened to, over the module.
const LEAST_ADDENDUM: f64 = 0.5;

impl New {
    fn is_internal(&self) -> bool {
        self.internal || self.has_signs()
    }

    /// Whether the file is in the signs of ISO 21771.
    fn has_signs(&self) -> bool {
        self.teeth[1] < 0
    }

    pub fn run(self) -> Result<()> {
        if let Some(file) = &self.rexs {
            let taken = rexs::pair_file(file, self.stage, self.torque_nm)?;
            return self.write(&taken.text, &taken.account);
        }
        self.check_teeth()?;
        let mut addendum = [1.0; 2];
        let (text, pair) = loop {
            let error = match self.made(addendum) {
                Ok(made) => break made,
                Err(error) => error.downcast::<PairError>()?,
            };
            match *error {
                // Few teeth come to a point below the usual tip circle, or reach into the mate's root.
                PairError::Refused(refusals) if shorten(&mut addendum, &refusals) => {}
                error => return Err(self.explained(error)),
            }
        };
        let notes = pair.warnings.iter().map(|note| format!("note: {note}\n"));
        self.write(&text, &notes.collect::<String>())
    }

    /// The file of teeth with this addendum (over the module), and its pair.
    fn made(&self, addendum: [f64; 2]) -> Result<(String, Pair)> {
        let mut usual = Usual {
            backlash_um: 0.0,
            tool_tip_radius: [0.0; 2],
            addendum,
        };
        let mut bare = self.text(&usual, "")?;
        for field in ["\"backlash_um\"", "\"tool_tip_radius_coefficient\""] {
            bare = bare.replace(field, &format!("// {field}"));
        }
        let bare = pair::from_json(&bare)?;
        let gears = &bare.geometry.gears;
        usual.backlash_um = usual_backlash_um(&bare);
        usual.tool_tip_radius = gears
            .each_ref()
            .map(|gear| gear.tool_tip_radius_coefficient);
        let text = self.text(&usual, &derived(&bare))?;
        let pair = pair::from_json(&text)?;
        Ok((text, pair))
    }

    /// Refuses a ring that is not gear 2.
    fn check_teeth(&self) -> Result<()> {
        let [first, second] = [self.teeth[0], self.teeth[1]];
        let [one, two] = [first, second].map(i32::unsigned_abs);
        if first < 0 {
            let remedy = match one.cmp(&two) {
                Ordering::Greater if second > 0 => {
                    format!("give its teeth second: {second} {first}")
                }
                Ordering::Less if second < 0 => format!("give {one} {second} for gear 1 in a ring"),
                Ordering::Less => format!(
                    "give {one} -{two} for {one} teeth in a ring of {two}, or {one} {two} for external gears"
                ),
                _ => "give that of the smaller gear first, without a sign".into(),
            };
            refuse!("--teeth = {first} {second}: a ring is gear 2; {remedy}");
        }
        Ok(())
    }

    /// `error` of a file of this pair, with what can be done by options.
    fn explained(&self, error: PairError) -> Error {
        // Names of fields have those of their options in them.
        let command = New::augment_args(Command::new("new"));
        let is_option = |field: &str| {
            let mut options = command.get_arguments();
            options.any(|option| field.contains(option.get_id().as_str()))
        };
        match &error {
            PairError::Refused(refusals) if !refusals.all().iter().all(|r| is_option(&r.field)) => {
                let (one, two) = (self.teeth[0], self.teeth[1]);
                format!(
                    "--teeth = {one} {two}: usual values make no pair of these: {error}; give other teeth, or change these fields, \
                     which have no option, in a file of another pair"
                )
                .into()
            }
            _ => error.into(),
        }
    }

    /// Writes the pair file `text`; `summary` is printed with a file, and notes go beside a pair file on standard output.
    fn write(&self, text: &str, summary: &str) -> Result<()> {
        let Some(path) = &self.output else {
            output::print(text)?;
            // A file from REXS has its account in comments.
            if self.rexs.is_none() {
                eprint!("{summary}");
            }
            return Ok(());
        };
        let file = path.display();
        if path.exists() {
            refuse!("--output = {file}: the file is there already; name another one, or remove it");
        }
        output::write_whole(path, text.as_bytes())?;
        let next = format!("look at it with `gearmesh inspect {file}`");
        output::print(&format!("{summary}Wrote {file}; {next}\n"))
    }

    /// The file; `derived` is a comment on what follows from it.
    fn text(&self, usual: &Usual, derived: &str) -> askama::Result<String> {
        let stem = self.output.as_deref().and_then(|path| path.file_stem());
        let name = self.name.clone().unwrap_or_else(|| match stem {
            Some(stem) => stem.to_string_lossy().into_owned(),
            None => format!("pair-{}-{}", self.teeth[0], self.teeth[1].abs()),
        });
        let torque = self.torque_nm.unwrap_or_default();
        let module = self.module_mm.unwrap_or_default();
        let file = File {
            new: self,
            name: name.into(),
            derived,
            module,
            usual,
            offset: rounded(0.5 * (self.face_width_mm[0] - self.face_width_mm[1])),
            torque,
            most: rounded(1.5 * torque),
            // A twentieth and an eighth of small modules.
            closer: rounded((50.0 * module).min(20.0)),
            apart: rounded((125.0 * module).min(50.0)),
        };
        Ok(file.render()? + "\n")
    }

    /// Shifts that keep a rack of one module's addendum from undercutting: (z_min - z / cos³ beta) / z_min with z_min = 2 / sin²
    /// alpha, rounded up to a twentieth. A ring takes the shift of its pinion, which leaves the centre distance; in the signs of
    /// ISO 21771 it is the opposite.
    fn profile_shifts(&self) -> [f64; 2] {
        let least = 2.0 / self.pressure_angle_deg.to_radians().sin().powi(2);
        let cos = self.helix_angle_deg.to_radians().cos();
        let own = if self.is_internal() { 0 } else { 1 };
        let [one, two] = [0, own].map(|i| {
            let short = 1.0 - f64::from(self.teeth[i]) / cos.powi(3) / least;
            ((20.0 * short).ceil() / 20.0).clamp(0.0, 1.0)
        });
        // No -0.
        [one, if self.has_signs() { 0.0 - two } else { two }]
    }
}

/// Whether some addendum became a twentieth less, as `refusals` name the tips of its gear.
fn shorten(addendum: &mut [f64; 2], refusals: &Refusals) -> bool {
    let mut is_shorter = false;
    for (gear, addendum) in ["gear1", "gear2"].into_iter().zip(addendum) {
        let names =
            ["tip_diameter_mm", "addendum_coefficient"].map(|name| format!("{gear}.{name}"));
        if *addendum > LEAST_ADDENDUM && refusals.all().iter().any(|r| names.contains(&r.field)) {
            *addendum = rounded(*addendum - 0.05);
            is_shorter = true;
        }
    }
    is_shorter
}

/// Least backlash of ISO/TR 10064-2, Table 1, 2/3 (0.06 + 0.0005 a + 0.03 m_n) in mm normal to the flanks, as
/// circumferential backlash in um, rounded up to ten.
fn usual_backlash_um(pair: &Pair) -> f64 {
    let g = &pair.geometry;
    let (a, module) = (1e3 * g.center_distance, 1e3 * g.gears[0].normal_module);
    let normal = 2.0 / 3.0 * (0.06 + 0.0005 * a + 0.03 * module);
    let cosines = g.operating_pressure_angle(g.center_distance).cos() * g.base_helix_angle().cos();
    let tens = (100.0 * normal / cosines).ceil();
    // The pair file allows half a module.
    10.0 * tens.min((50.0 * module).floor())
}

fn derived(pair: &Pair) -> String {
    let g = &pair.geometry;
    let c = g.center_distance;
    format!(
        "// Without backlash the centre distance is {:.4} mm; contact ratios {:.3} transverse, {:.3} overlap.\n",
        1e3 * c,
        g.transverse_contact_ratio(c),
        g.overlap_ratio()
    )
}
