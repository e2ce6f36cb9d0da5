//! Evaluates one case of the benchmarks again and again, for instruction counts.
//!
//! `instructions` lists the cases; `instructions CASE N` evaluates one N times.
//! scripts/callgrind.py runs it under valgrind.

#[rustfmt::skip] // formatted where it stands
#[path = "../../../benches/cases/mod.rs"]
mod cases;

fn main() -> Result<(), String> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let cases = cases::all();
    match arguments.as_slice() {
        [] => {
            for case in cases {
                println!("{}", case.name);
            }
            Ok(())
        }
        [name, times] => {
            let case = cases
                .into_iter()
                .find(|c| c.name == *name)
                .ok_or_else(|| format!("no case {name}"))?;
            let times: usize = times.parse().map_err(|e| format!("{times}: {e}"))?;
            let mut run = (case.make)();
            for i in 0..times {
                run(i);
            }
            Ok(())
        }
        _ => Err("give CASE and N, or nothing for a list".into()),
    }
}
