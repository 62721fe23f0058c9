//! Runs a small part of the mutation run, so that the chore keeps working. The whole run is `cargo run --release -p
//! pelage-tests --bin chores -- mutate`.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_tests::mutate::{KINDS, Plan, run};

/// Number of cases of each kind, in the order of [`KINDS`]. Kinds that bake take longer.
const CASES: [u64; KINDS.len()] = [40, 28, 12, 8, 8, 8, 8];

#[test]
fn short_mutation_run_finds_no_fault() {
    let cases = CASES.iter().enumerate().flat_map(|(kind, count)| (0..*count).map(move |i| (kind, i))).collect();
    let report = run(&Plan { seed: 7, cases, jobs: 2 }, None, None).unwrap();
    let text = report.text(7);
    println!("{text}");
    assert_eq!(report.faulty(), 0, "{text}");
    // Both successful and rejected cases must occur, or else the cases test nothing.
    for word in ["unpack 0", "unpack 3", "pack 0", "pack 3", "bake 0", "bake 3", "validate 0", "validate 7"] {
        let count: u64 = report.tallies.iter().filter_map(|tally| tally.exits.get(word)).sum();
        assert!(count > 0, "no {word}: {text}");
    }
}
