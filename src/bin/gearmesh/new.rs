//! `gearmesh new`: a pair file to start from, with a comment on every field.

use std::path::PathBuf;

use clap::Args;
use gearmesh::pair::Pair;
use gearmesh::words::rounded;

use crate::output;

/// Write a commented pair file to start from.
///
/// What is not asked for gets usual values: centre distance from the tooth numbers, backlash after ISO/TR
/// 10064-2, profile shift where teeth would be undercut, faces centred on each other.
#[derive(Debug, Args)]
pub struct New {
    /// Numbers of teeth of gear 1 and gear 2
    #[arg(long, num_args = 2, value_names = ["Z1", "Z2"], required = true)]
    teeth: Vec<u32>,

    /// Normal module, mm
    #[arg(long)]
    module_mm: f64,

    /// Face widths of gear 1 and gear 2, mm
    #[arg(long, num_args = 2, value_names = ["B1", "B2"], required = true)]
    face_width_mm: Vec<f64>,

    /// Nominal torque on gear 1, N m
    #[arg(long)]
    torque_nm: f64,

    /// Helix angle at the reference cylinder, degrees; > 0: gear 1 right-handed
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    helix_angle_deg: f64,

    /// Normal pressure angle, degrees
    #[arg(long, default_value_t = 20.0)]
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

impl New {
    /// Writes the file, once it is a pair that works.
    pub fn run(self) -> Result<(), crate::Error> {
        // What is filled in follows from the pair without it.
        let bare = Pair::from_json(
            &self
                .text(0.0, "")
                .replace("\"backlash_um\"", "// \"backlash_um\""),
        )?;
        let text = self.text(usual_backlash_um(&bare), &derived(&bare));
        Pair::from_json(&text)?;
        let Some(path) = &self.output else {
            return Ok(output::print(&text)?);
        };
        if path.exists() {
            let there = path.display();
            return Err(format!(
                "--output = {there}: the file is there already; name another one, or remove it"
            )
            .into());
        }
        output::write_whole(path, text.as_bytes())?;
        let path = path.display();
        output::print(&format!(
            "Wrote {path}; look at it with `gearmesh inspect {path}`\n"
        ))?;
        Ok(())
    }

    /// The file; `derived` is a comment on what follows from it.
    fn text(&self, backlash_um: f64, derived: &str) -> String {
        let [b1, b2] = [self.face_width_mm[0], self.face_width_mm[1]];
        let [shift1, shift2] = self.profile_shifts();
        let stem = self.output.as_deref().and_then(|path| path.file_stem());
        let name = self.name.clone().unwrap_or_else(|| match stem {
            Some(stem) => stem.to_string_lossy().into_owned(),
            None => format!("pair-{}-{}", self.teeth[0], self.teeth[1]),
        });
        let (meshing, held2) = if self.internal {
            (
                "internal",
                "\"rim_diameter_mm\": 0.0, // where the ring is held; default: root diameter + 7 modules",
            )
        } else {
            (
                "external",
                "\"bore_diameter_mm\": 0.0, // where the body is held; default: half of the root diameter",
            )
        };
        format!(
            r#"// A gear pair for gearmesh; docs/pair-file.md has every field and its limits. Lines that begin with //
// are comments: remove the // to give the field a value of its own.
{derived}{{
  "name": {name},
  // "source": "number of the drawing",
  "meshing": "{meshing}",
  "normal_module_mm": {module},
  "normal_pressure_angle_deg": {alpha},
  "helix_angle_deg": {beta}, // > 0: gear 1 is right-handed
  // "center_distance_mm": 0.0, // default: from the profile shifts, without backlash
  "backlash_um": {backlash_um:.0}, // at the operating pitch circle, both gears together
  "face_offset_mm": {offset}, // z of gear 2's z = 0 face minus gear 1's; here the faces share their middle
  "gear1": {{
    "teeth": {z1},
    "profile_shift": {shift1},
    "face_width_mm": {b1},
    // "tip_diameter_mm": 0.0, // default: an addendum of one module
    // "dedendum_coefficient": 1.25,
    "tool_tip_radius_coefficient": {round}, // over the normal module
    // "bore_diameter_mm": 0.0, // where the body is held; default: half of the root diameter
    // "tip_relief": {{ "amount_um": 10.0, "start": "pitch_point", "shape": "parabolic" }},
    // "lead_crowning_um": 4.0,
  }},
  "gear2": {{
    "teeth": {z2},
    "profile_shift": {shift2},
    "face_width_mm": {b2},
    "tool_tip_radius_coefficient": {round},{of_ring}
    // {held2}
  }},
  "operating": {{
    "nominal_torque_nm": {torque}, // on gear 1
    "maximum_torque_nm": {most}, // highest torque in the tables
    "center_distance_offset_um": [-20.0, 50.0], // actual minus nominal; [0, 0] leaves the axis out
    "misalignment_mrad": [-1.0, 1.0], // in the plane of action; > 0 closes the large-z side
  }},
}}
"#,
            name = serde_json::Value::from(name),
            module = self.module_mm,
            alpha = self.pressure_angle_deg,
            beta = self.helix_angle_deg,
            offset = rounded(0.5 * (b1 - b2)),
            round = self.tool_tip_radius(),
            of_ring = if self.internal {
                " // a ring: of its fillet"
            } else {
                ""
            },
            z1 = self.teeth[0],
            z2 = self.teeth[1],
            torque = self.torque_nm,
            most = rounded(1.5 * self.torque_nm),
        )
    }

    /// 0.38, or the largest twentieth that the tip of a rack with a dedendum of 1.25 modules has room for.
    fn tool_tip_radius(&self) -> f64 {
        let (sin, cos) = self.pressure_angle_deg.to_radians().sin_cos();
        let room = (std::f64::consts::FRAC_PI_4 - 1.25 * sin / cos) * cos / (1.0 - sin);
        if room >= 0.38 {
            0.38
        } else {
            (20.0 * room).floor().max(0.0) / 20.0
        }
    }

    /// Shifts that keep a rack of one module's addendum from undercutting: (z_min - z / cos³ beta) / z_min with
    /// z_min = 2 / sin² alpha, rounded up to a twentieth. A ring takes the shift of its pinion, which leaves the
    /// centre distance.
    fn profile_shifts(&self) -> [f64; 2] {
        let least = 2.0 / self.pressure_angle_deg.to_radians().sin().powi(2);
        let cos = self.helix_angle_deg.to_radians().cos();
        let shift = |teeth: u32| {
            let short = (least - f64::from(teeth) / cos.powi(3)) / least;
            ((20.0 * short).ceil() / 20.0).clamp(0.0, 1.0)
        };
        let first = shift(self.teeth[0]);
        [
            first,
            if self.internal {
                first
            } else {
                shift(self.teeth[1])
            },
        ]
    }
}

/// Least backlash of ISO/TR 10064-2, Table 1, 2/3 (0.06 + 0.0005 a + 0.03 m_n) in mm normal to the flanks, as
/// circumferential backlash in um, rounded up to ten.
fn usual_backlash_um(pair: &Pair) -> f64 {
    let g = &pair.geometry;
    let (a, module) = (1e3 * g.center_distance, 1e3 * g.gears[0].normal_module);
    let normal = 2.0 / 3.0 * (0.06 + 0.0005 * a + 0.03 * module);
    let cosines = g.operating_pressure_angle(g.center_distance).cos() * g.base_helix_angle().cos();
    // The pair file allows a quarter of a module.
    10.0 * (100.0 * normal / cosines)
        .ceil()
        .min((25.0 * module).floor())
}

/// Comment on what follows from the pair.
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
