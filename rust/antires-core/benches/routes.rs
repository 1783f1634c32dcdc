//! The two routes beside each other: 16 responses of a chain of 60 masses, in its lower third, and of a frame like the
//! exhaust system, to 260 Hz. The quotient of the two lines of a group is what the modal route saves.
#![allow(missing_docs)]

mod common;

use std::hint::black_box;

use antires_core::antiresonances::{Query, Route, antiresonances};
use criterion::{Criterion, criterion_group, criterion_main};

fn routes(criterion: &mut Criterion) {
    let chain_dofs: Vec<usize> = (0..16).map(|i| 3 * i + 2).collect();
    let cases = [
        ("chain60", common::chain(60), chain_dofs, 0, 35.0),
        ("exhaust_like", common::exhaust_like(), common::sensors(16), 1, 260.0),
    ];
    for (name, model, dofs, excitation, f_max_hz) in cases {
        let ends: Vec<_> = dofs.iter().map(|&dof| (dof, excitation).into()).collect();
        let mut group = criterion.benchmark_group(format!("routes/{name}"));
        group.sample_size(10);
        for route in [Route::Modal, Route::Pencil] {
            let query = Query { route, f_max_hz, include_cancelled: false };
            group.bench_function(format!("{route:?}"), |bench| {
                bench.iter(|| antiresonances(black_box(&model), &ends, &query).unwrap());
            });
        }
        group.finish();
    }
}

criterion_group!(benches, routes);
criterion_main!(benches);
