//! Register of all tests that require a resource, and the check of a log against it.

use crate::Need;
use std::collections::{BTreeMap, BTreeSet};

/// Committed list with one line per test: name of the resource, a space, name of the test.
pub const REGISTER: &str = include_str!("../register.txt");

/// Resource and name of a test.
pub type Entry = (Need, String);

/// Parses a register.
///
/// # Errors
///
/// The first line with an unknown resource, without a test name, or that repeats an earlier line.
pub fn entries(register: &str) -> Result<BTreeSet<Entry>, String> {
    let mut all = BTreeSet::new();
    for (number, line) in register.lines().enumerate() {
        let entry = line.split_once(' ').and_then(|(word, test)| Some((need_by_name(word)?, test.trim().to_owned())));
        let entry = entry.filter(|(_, test)| !test.is_empty());
        let entry = entry.ok_or_else(|| format!("line {}: {line:?}, expected a resource and a test", number + 1))?;
        if !all.insert(entry) {
            return Err(format!("line {}: {line:?} is listed twice", number + 1));
        }
    }
    Ok(all)
}

fn need_by_name(word: &str) -> Option<Need> {
    Need::ALL.into_iter().find(|n| n.name() == word)
}

/// Result of a complete test run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RunSummary {
    /// Number of tests whose resource was available, per resource.
    pub had: BTreeMap<Need, usize>,
    /// Registered tests whose resource was missing, with the logged reason.
    pub lacked: BTreeMap<Entry, String>,
}

/// Checks the log of a complete test run against a register.
///
/// # Errors
///
/// All faults: malformed log lines, registered tests that did not request their resource, and tests that did but are
/// not registered.
pub fn check(register: &str, log: &str) -> Result<RunSummary, Vec<String>> {
    let registered = entries(register).map_err(|e| vec![format!("register: {e}")])?;
    let (mut faults, mut had, mut lacked) = (Vec::new(), BTreeSet::new(), BTreeMap::new());
    for (number, line) in log.lines().enumerate() {
        let fields: Vec<&str> = line.split('\t').collect();
        match fields[..] {
            ["had", word, test, _] if need_by_name(word).is_some() => drop(had.insert((word, test))),
            ["lacked", word, test, why] if need_by_name(word).is_some() => drop(lacked.insert((word, test), why)),
            _ => faults.push(format!("log, line {}: found {line:?}, expected the line of a test", number + 1)),
        }
    }
    for (word, test) in had.iter().chain(lacked.keys()).collect::<BTreeSet<_>>() {
        let known = need_by_name(word).is_some_and(|n| registered.contains(&(n, (*test).to_owned())));
        if !known {
            faults.push(format!(
                "{word} test {test:?} is not registered: tests/needs/register.txt lacks `{word} {test}`"
            ));
        }
    }
    let mut roll = RunSummary::default();
    for (need, test) in registered {
        let key = (need.name(), test.as_str());
        // A test may request a resource several times. It counts as lacking the resource if any request failed.
        if let Some(why) = lacked.get(&key) {
            roll.lacked.insert((need, test.clone()), (*why).to_owned());
        } else if had.contains(&key) {
            *roll.had.entry(need).or_default() += 1;
        } else {
            faults.push(format!("{} test {test:?} did not run, or did not request its resource", need.name()));
        }
    }
    if faults.is_empty() { Ok(roll) } else { Err(faults) }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

    use super::*;

    const LIST: &str = "data reads models\ngpu draws\ngpu shines";
    const LOG: &str = "had\tgpu\tshines\tadapter\nhad\tdata\treads models\t/data\nhad\tgpu\tdraws\tadapter\n";

    #[test]
    fn complete_log_passes() {
        let roll = check(LIST, LOG).unwrap();
        assert_eq!(roll.had, BTreeMap::from([(Need::Gpu, 2), (Need::Data, 1)]));
        assert!(roll.lacked.is_empty());
        // Checks that repeated requests count once.
        assert_eq!(check(LIST, &format!("{LOG}{LOG}")), Ok(roll));
    }

    #[test]
    fn log_without_a_registered_test_fails() {
        for gone in ["shines", "reads models", "draws"] {
            let log: String = LOG.lines().filter(|l| !l.contains(gone)).map(|l| format!("{l}\n")).collect();
            let faults = check(LIST, &log).unwrap_err();
            assert!(faults.len() == 1 && faults[0].contains(gone) && faults[0].contains("did not run"), "{faults:?}");
        }
        assert_eq!(check(LIST, "").unwrap_err().len(), 3, "with an empty log, all tests must be missing");
    }

    #[test]
    fn test_that_requests_another_resource_fails() {
        let faults = check("gpu draws", "had\tdata\tdraws\t/data\n").unwrap_err();
        assert_eq!(faults.len(), 2, "{faults:?}");
    }

    #[test]
    fn unregistered_tests_fail() {
        for log in ["had\tgpu\tnew\tadapter\n", "lacked\tgpu\tnew\toff\n"] {
            let faults = check(LIST, &format!("{LOG}{log}")).unwrap_err();
            assert!(faults.len() == 1 && faults[0].contains("`gpu new`"), "{faults:?}");
        }
    }

    #[test]
    fn skipped_tests_are_listed_with_their_reason() {
        let roll = check(LIST, &format!("{LOG}lacked\tgpu\tdraws\tswitched off\n")).unwrap();
        assert_eq!(roll.lacked, BTreeMap::from([((Need::Gpu, "draws".to_owned()), "switched off".to_owned())]));
        assert_eq!(roll.had[&Need::Gpu], 1);
    }

    #[test]
    fn malformed_log_lines_fail() {
        for line in ["ran\tgpu\tdraws\tadapter", "had\tluck\tdraws\tadapter", "had gpu draws", "had\tgpu\tdraws"] {
            assert!(check(LIST, &format!("{LOG}{line}\n")).is_err(), "{line:?}");
        }
    }

    #[test]
    fn register_is_sorted_and_valid() {
        let lines: Vec<&str> = REGISTER.lines().collect();
        assert!(lines.is_sorted(), "tests/needs/register.txt is not sorted");
        assert_eq!(entries(REGISTER).unwrap().len(), lines.len());
        for wrong in ["draws", "luck draws", "gpu ", "gpu draws\ngpu draws"] {
            assert!(entries(wrong).is_err(), "{wrong:?}");
        }
    }
}
