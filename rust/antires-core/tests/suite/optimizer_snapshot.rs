//! A search taken up from a snapshot ends in the bits of one that was never stopped.

use antires_core::error::Result;
use antires_core::optimize::{Bounds, Hooks, IslandOptions, Outcome, minimize_objective};
use proptest::prelude::{any, prop, prop_assert, proptest};

use crate::common::{bits, config, rastrigin, sparse};

const N: usize = 7;

fn run(
    objective: fn(&[f64]) -> f64,
    options: &IslandOptions,
    seed: u64,
    hooks: &mut Hooks<'_>,
) -> Result<Outcome> {
    let bounds = Bounds::uniform(N, 0.0, 0.99)?;
    minimize_objective(&objective, &bounds, &[], options, seed, 1, hooks)
}

/// The outcome and the snapshot before each generation.
fn watched(objective: fn(&[f64]) -> f64, options: &IslandOptions, seed: u64) -> (Outcome, Vec<Vec<u8>>) {
    let mut snapshots = Vec::new();
    let mut keep = |bytes| snapshots.push(bytes);
    let hooks = &mut Hooks { keep: Some(&mut keep), ..Hooks::default() };
    let outcome = run(objective, options, seed, hooks).unwrap();
    (outcome, snapshots)
}

fn resumed(
    objective: fn(&[f64]) -> f64,
    options: &IslandOptions,
    seed: u64,
    bytes: &[u8],
) -> Result<Outcome> {
    let hooks = &mut Hooks { resume: Some(bytes), ..Hooks::default() };
    run(objective, options, seed, hooks)
}

fn options(polish: Option<bool>) -> IslandOptions {
    IslandOptions {
        polish,
        patience: 4,
        polish_interval: 3,
        polish_evaluations: 50,
        max_evaluations: 6000,
        ..IslandOptions::default()
    }
}

#[test]
fn every_snapshot_leads_to_the_same_end() {
    let mut migrations = 0;
    for (polish, objective) in [
        (None, sparse as fn(&[f64]) -> f64),
        (Some(true), sparse),
        (Some(true), rastrigin),
        (Some(false), rastrigin),
    ] {
        let options = options(polish);
        let (whole, snapshots) = watched(objective, &options, 5);
        assert!(snapshots.len() > 3);
        migrations += whole.migrations;
        for bytes in &snapshots {
            let part = resumed(objective, &options, 5, bytes).unwrap();
            assert_eq!((bits(&part), part.status), (bits(&whole), whole.status));
        }
    }
    assert!(migrations > 0);
}

#[test]
fn a_snapshot_of_another_search_is_refused() {
    let (_, snapshots) = watched(sparse, &options(Some(true)), 5);
    let bytes = &snapshots[2];
    assert!(resumed(sparse, &options(Some(true)), 5, bytes).is_ok());
    let error = resumed(sparse, &options(Some(true)), 6, bytes).unwrap_err();
    assert!(error.to_string().starts_with("checkpoint: got"), "{error}");
    assert!(resumed(sparse, &options(Some(false)), 5, bytes).is_err());
    for change in [|o: &mut IslandOptions| o.islands = 3, |o: &mut IslandOptions| o.population = 41] {
        let mut other = options(Some(true));
        change(&mut other);
        assert!(resumed(sparse, &other, 5, bytes).is_err());
    }
    let narrow = Bounds::uniform(N, 0.0, 0.98).unwrap();
    let hooks = &mut Hooks { resume: Some(bytes), ..Hooks::default() };
    let objective = sparse as fn(&[f64]) -> f64;
    let options = options(Some(true));
    assert!(minimize_objective(&objective, &narrow, &[], &options, 5, 1, hooks).is_err());
}

proptest! {
    #![proptest_config(config(200))]
    #[test]
    fn a_cut_or_garbled_snapshot_never_panics(at in any::<prop::sample::Index>(), byte in any::<u8>()) {
        let options = options(Some(true));
        let (_, snapshots) = watched(sparse, &options, 1);
        let mut bytes = snapshots[snapshots.len() / 2].clone();
        let cut = at.index(bytes.len());
        prop_assert!(resumed(sparse, &options, 1, &bytes[..cut]).is_err());
        bytes[cut] = byte;
        // What a checksum has to find may still be a search; it must come to an end.
        let _ = resumed(sparse, &options, 1, &bytes);
    }
}
