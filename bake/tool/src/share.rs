//! Parses shares of a job that is divided among machines.

/// Parses a share such as `3/16`: its number, counted from 1, and the number of shares. `None` if it is invalid.
pub fn share(text: &str) -> Option<(u32, u32)> {
    let (number, of) = text.split_once('/')?;
    let both = (number.trim().parse().ok()?, of.trim().parse().ok()?);
    Some(both).filter(|(number, of)| (1..=*of).contains(number))
}
