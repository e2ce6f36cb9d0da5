//! The short form of the fuzzing in fuzz/: changed inputs for every reader, the same ones in each run.
//!
//! `GEARMESH_FUZZ` sets the number of inputs for each of them; 2000 without it. docs/developers.md has the long form.

use gearmesh_fuzz::{TARGETS, Target, change, changed, random};

#[path = "../fuzz/src/lib.rs"]
#[allow(missing_docs)]
mod gearmesh_fuzz;

fn inputs() -> u32 {
    let inputs = std::env::var("GEARMESH_FUZZ");
    inputs.map_or(2000, |text| text.parse().expect("a number of inputs"))
}

/// Changes seeds, and what came of them and was accepted, over and over.
fn run(target: &Target) {
    let seeds = (target.seeds)();
    for seed in &seeds {
        assert!((target.check)(seed), "a seed is refused");
    }
    let mut kept = seeds.clone();
    let mut accepted = 0;
    for number in 0..inputs() {
        let mut random = random(number);
        let place = (random.next() * kept.len() as f64) as usize;
        let changed = changed(target, &kept[place], usize::MAX, number)
            .unwrap_or_else(|| change::bytes(&kept[place], &mut random));
        if (target.check)(&changed) {
            accepted += 1;
            // Half of all start from seeds, half from the last of those accepted.
            if kept.len() < 2 * seeds.len() {
                kept.push(changed);
            } else {
                let last = seeds.len() + place % seeds.len();
                kept[last] = changed;
            }
        }
    }
    println!("{}: {accepted} of {} accepted", target.name, inputs());
    assert!(accepted > inputs() / 50, "only {accepted} were accepted");
    assert!(
        accepted < inputs() - inputs() / 50,
        "all but {} were",
        inputs() - accepted
    );
}

#[test]
fn changed_pair_files_are_refused_by_field_or_give_pairs_that_mesh() {
    run(TARGETS[0]);
}

#[test]
fn changed_tables_are_refused_by_field_or_give_numbers() {
    run(TARGETS[1]);
}

#[test]
fn changed_samples_are_refused_by_line_or_become_tables() {
    run(TARGETS[2]);
}

#[test]
fn changed_states_are_refused_or_the_unit_goes_on_with_numbers() {
    run(TARGETS[3]);
}

#[test]
fn changed_units_are_refused_by_field_or_go_with_numbers() {
    run(TARGETS[4]);
}

#[test]
fn changed_contacts_are_refused_or_give_numbers() {
    run(TARGETS[5]);
}
