//! The law of friction of the pair file.

use super::checks::{Range::Within, check};
use super::error::{Refusal, refusal};
use super::file::{FrictionFile, FrictionLawFile};
use super::resolve::UM;
use gearmesh::friction::FrictionLaw;

/// The law that `file` gives, or the default.
pub(super) fn friction(file: Option<&FrictionFile>) -> Result<FrictionLaw, Refusal> {
    let Some(file) = file else {
        return Ok(FrictionLaw::default());
    };
    let roughness = |i: usize| file.roughness_ra_um.map(|ra| ra[i]);
    #[rustfmt::skip]
    check("friction.", &[
        ("coefficient", file.coefficient, Within(0.0, 1.0), None),
        ("dynamic_viscosity_mpa_s", file.dynamic_viscosity_mpa_s, Within(1.01, 1e5), None),
        ("lubricant_factor", file.lubricant_factor, Within(0.1, 2.0), None),
        ("roughness_ra_um", roughness(0), Within(0.01, 20.0), None),
        ("roughness_ra_um", roughness(1), Within(0.01, 20.0), None),
    ])?;
    let missing = |name: &str, remedy: &str| {
        refusal!(format!("friction.{name}") => "none";
            "this law asks for it"; "{remedy}, or leave `law` at `constant`")
    };
    let oil = || -> Result<(f64, [f64; 2]), Refusal> {
        let viscosity = file.dynamic_viscosity_mpa_s.ok_or_else(|| {
            let remedy = "give the dynamic viscosity at the temperature of the oil";
            missing("dynamic_viscosity_mpa_s", remedy)
        })?;
        let ra = file
            .roughness_ra_um
            .ok_or_else(|| missing("roughness_ra_um", "give Ra of both gears as a list of two"))?;
        Ok((1e-3 * viscosity, ra.map(|r| r * UM)))
    };
    Ok(match file.law {
        FrictionLawFile::Constant => match file.coefficient {
            Some(coefficient) => FrictionLaw::Constant { coefficient },
            None => FrictionLaw::default(),
        },
        FrictionLawFile::Schlenk => {
            let (viscosity, ra) = oil()?;
            FrictionLaw::schlenk(viscosity, ra, file.lubricant_factor.unwrap_or(MINERAL_OIL))
        }
        FrictionLawFile::XuKahraman => {
            let (viscosity, ra) = oil()?;
            FrictionLaw::xu_kahraman(viscosity, ra)
        }
    })
}

/// X_L of a mineral gear oil: see [`FrictionLaw::Schlenk`].
const MINERAL_OIL: f64 = 0.846;

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<FrictionLaw, String> {
        let file: FrictionFile = serde_json::from_str(text).unwrap();
        friction(Some(&file)).map_err(|refusal| refusal.to_string())
    }

    #[test]
    fn laws_ask_for_what_they_need_and_ignore_the_rest() {
        assert_eq!(of("{}"), Ok(FrictionLaw::default()));
        assert_eq!(friction(None), Ok(FrictionLaw::default()));
        let constant = r#"{ "coefficient": 0.07, "dynamic_viscosity_mpa_s": 30.0 }"#;
        assert_eq!(
            of(constant),
            Ok(FrictionLaw::Constant { coefficient: 0.07 })
        );
        let dry = of(r#"{ "law": "schlenk", "roughness_ra_um": [0.4, 0.3] }"#).unwrap_err();
        assert!(dry.contains("friction.dynamic_viscosity_mpa_s"), "{dry}");
        let smooth =
            of(r#"{ "law": "xu_kahraman", "dynamic_viscosity_mpa_s": 10.0 }"#).unwrap_err();
        assert!(smooth.contains("friction.roughness_ra_um"), "{smooth}");
        let rough = of(r#"{ "roughness_ra_um": [0.4, 300.0] }"#).unwrap_err();
        assert!(rough.contains("300") && rough.contains("20"), "{rough}");
        let law = of(
            r#"{ "law": "schlenk", "dynamic_viscosity_mpa_s": 13.28, "roughness_ra_um": [0.4, 0.31] }"#,
        );
        let same = FrictionLaw::schlenk(13.28e-3, [0.4e-6, 0.31e-6], 0.846);
        assert_eq!(law, Ok(same));
    }
}
