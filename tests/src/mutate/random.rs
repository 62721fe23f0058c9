//! Random numbers that are the same on every machine.

/// The generator that damaged packages of the formats' own tests are made with.
#[path = "../../../formats/tests/formats/common/random.rs"]
mod numbers;

pub use numbers::Random;

impl Random {
    /// The numbers of one case: they hang on nothing but these three, so that a case can be repeated by itself.
    pub fn of_case(seed: u64, kind: u64, index: u64) -> Self {
        let mut out = Self(seed);
        out.0 = out.next_u64() ^ kind;
        out.0 = out.next_u64() ^ index;
        out
    }

    /// One of a list, which is not empty.
    pub fn pick<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.below(list.len())]
    }
}
