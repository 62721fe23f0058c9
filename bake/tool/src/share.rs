//! A share of something that several machines do.

/// Reads `3/16`: which share, from 1, and of how many, where both are numbers that can be.
pub fn share(text: &str) -> Option<(u32, u32)> {
    let (number, of) = text.split_once('/')?;
    let both = (number.trim().parse().ok()?, of.trim().parse().ok()?);
    Some(both).filter(|(number, of)| (1..=*of).contains(number))
}
