//! Time of one evaluation: every interpolant in one to four dimensions, and the whole element.
//!
//! *value* of a table: potential, first derivatives, tangent stiffness; *gradient*: the second
//! derivatives, too. For figures that do not depend on what else the machine does, see `make callgrind`.

mod cases;

use criterion::{Criterion, criterion_group, criterion_main};

fn evaluations(criterion: &mut Criterion) {
    for case in cases::all() {
        let mut run = (case.make)();
        let mut i = 0;
        criterion.bench_function(&case.name, |b| {
            b.iter(|| {
                i += 1;
                run(i);
            });
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(std::time::Duration::from_millis(200))
        .measurement_time(std::time::Duration::from_millis(500));
    targets = evaluations
}
criterion_main!(benches);
