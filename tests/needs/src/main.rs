//! Checks the log of a complete test run against the register: `needs LOG`.
//!
//! Exit code 0: the resource of every registered test was available. 77: some tests lacked their resource, and are
//! listed. 1: a test is missing or unknown, or the log cannot be read.

use pelage_needs::register::{REGISTER, check};
use std::process::ExitCode;

/// Exit code for skipped tests, as in harnesses of other projects; the script `run` reads it.
const WENT_WITHOUT: u8 = 77;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [path] = arguments.as_slice() else {
        eprintln!("expected one argument, the log of a run");
        return ExitCode::FAILURE;
    };
    let log = match std::fs::read_to_string(path) {
        Ok(log) => log,
        Err(error) => {
            eprintln!("{path}: {error}");
            return ExitCode::FAILURE;
        }
    };
    match check(REGISTER, &log) {
        Ok(roll) => {
            let counts: Vec<_> = roll.had.iter().map(|(need, n)| format!("{n} {}", need.name())).collect();
            println!("registered tests whose resource was available: {}", counts.join(", "));
            for ((need, test), why) in &roll.lacked {
                println!("resource missing: {} test {test} ({why})", need.name());
            }
            if roll.lacked.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(WENT_WITHOUT) }
        }
        Err(faults) => {
            faults.iter().for_each(|fault| eprintln!("{fault}"));
            ExitCode::FAILURE
        }
    }
}
