//! Parsing of shares of a job divided among machines.

/// Parses `3/16`: number of the share, from 1, and number of shares; `None` if invalid.
pub fn share(text: &str) -> Option<(u32, u32)> {
    let (number, of) = text.split_once('/')?;
    let both = (number.trim().parse().ok()?, of.trim().parse().ok()?);
    Some(both).filter(|(number, of)| (1..=*of).contains(number))
}
