//! Random numbers that are reproducible on all machines.

/// Random number generator shared with the formats' own tests of damaged packages.
#[path = "../../../formats/tests/formats/common/random.rs"]
mod numbers;

pub use numbers::Random;

impl Random {
    /// Returns the random numbers of one case. They depend only on the arguments, so a single case can be repeated.
    pub fn for_case(seed: u64, kind: u64, index: u64) -> Self {
        let mut out = Self(seed);
        out.0 = out.next_u64() ^ kind;
        out.0 = out.next_u64() ^ index;
        out
    }

    /// Returns a random element of a non-empty list.
    pub fn pick<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.below(list.len())]
    }
}
