//! REXS files: refused with words, or a pair file that is accepted as it stands.

use gearmesh_preprocessor::import::rexs;
use gearmesh_preprocessor::pair;
use serde_json::Value;

use super::{Target, change, pair_file};

/// A stage in XML, and an internal one in JSON.
pub const TARGET: Target = Target {
    seeds: || {
        vec![
            include_bytes!("../../command/tests/rexs/stage.rexs").to_vec(),
            first_stage(include_str!("../../command/tests/rexs/stages.rexsj")),
        ]
    },
    change: |data, random| match data.first() {
        Some(b'<') => change::xml(data, random),
        _ => change::json(data, random),
    },
    check,
};

/// The file without its stages but the first, so that none needs a name.
fn first_stage(text: &str) -> Vec<u8> {
    let mut file: Value = serde_json::from_str(text).expect("JSON");
    let components = file["model"]["components"].as_array_mut();
    let mut stages = 0;
    components.expect("components").retain(|component| {
        let is_stage = component["type"] == "cylindrical_stage";
        stages += usize::from(is_stage);
        !is_stage || stages == 1
    });
    file.to_string().into_bytes()
}

/// See [`Target::check`].
pub fn check(data: &[u8]) -> bool {
    match rexs::from_bytes(data.to_vec(), "stage") {
        Ok(imported) => {
            let made = pair::from_json(&imported.text);
            pair_file::assert_sound(&made.expect("an imported pair file is accepted"));
            true
        }
        Err(error) => {
            let message = error.to_string();
            assert!(!message.is_empty() && message.len() < 10_000, "{message}");
            false
        }
    }
}
