//! The short form of the fuzzing in fuzz/: changed inputs for every reader, the same ones in each run.
//!
//! `GEARMESH_FUZZ` sets the number of inputs for each of them; 2000 without it. docs/developers.md has the long form.

use gearmesh_fuzz::{Target, change, changed, random};

#[path = "../fuzz/src/lib.rs"]
#[allow(missing_docs)]
mod gearmesh_fuzz;

/// Changes seeds, and what came of them and was accepted, over and over.
fn run(target: &Target) {
    let count = std::env::var("GEARMESH_FUZZ");
    let count = count.map_or(2000, |text| text.parse().expect("a number of inputs"));
    let seeds = (target.seeds)();
    for seed in &seeds {
        assert!((target.check)(seed), "a seed is refused");
    }
    let mut inputs = seeds.clone();
    let mut accepted = 0;
    for number in 0..count {
        let mut random = random(number);
        let i = change::below(inputs.len(), &mut random);
        let changed = changed(target, &inputs[i], usize::MAX, number)
            .unwrap_or_else(|| change::bytes(&inputs[i], &mut random));
        if (target.check)(&changed) {
            accepted += 1;
            // Half of all start from seeds, half from the last of those accepted.
            if inputs.len() < 2 * seeds.len() {
                inputs.push(changed);
            } else {
                inputs[seeds.len() + i % seeds.len()] = changed;
            }
        }
    }
    println!("{accepted} of {count} accepted");
    let some = count / 50;
    assert!((some + 1..count - some).contains(&accepted), "{accepted}");
}

macro_rules! claims {
    ($($claim:ident: $target:ident;)*) => {$(
        #[test]
        fn $claim() {
            run(&gearmesh_fuzz::$target::TARGET);
        }
    )*};
}

claims! {
    changed_pair_files_are_refused_by_field_or_give_pairs_that_mesh: pair_file;
    changed_rexs_files_are_refused_or_become_pair_files: rexs_file;
    changed_tables_are_refused_by_field_or_give_numbers: tables;
    changed_samples_are_refused_by_line_or_become_tables: samples;
    changed_states_are_refused_or_the_unit_goes_on_with_numbers: stored_state;
    changed_units_are_refused_by_field_or_go_with_numbers: unit_file;
    changed_contacts_are_refused_or_give_numbers: contact_file;
}
