//! Runs the fuzz targets on mutations of the golden packages and of a package with morph targets. Unlike the fuzzer,
//! this works on stable Rust, makes a fixed number of mutations, and gives the same result on every machine.

use crate::bodies;
use crate::common::{self, random::Random};

const GOLDEN: [&[u8]; 3] = [
    include_bytes!("../golden/v1.pelage"),
    include_bytes!("../golden/v2.pelage"),
    include_bytes!("../golden/v3.pelage"),
];

/// Returns the golden packages, and a package with morph targets.
fn bases() -> Vec<Vec<u8>> {
    let morphed = common::morphed_package(&common::sample_morphs()).unwrap();
    GOLDEN.iter().map(|golden| golden.to_vec()).chain([morphed]).collect()
}

/// Returns the package with one to four mutations of the kinds that a fuzzer makes.
fn mutate(golden: &[u8], random: &mut Random) -> Vec<u8> {
    const NUMBERS: [u64; 12] = [
        0,
        1,
        2,
        0x7f,
        0xffff,
        0x7f80_0000, // infinity
        0x7fc0_0000, // NaN
        u32::MAX as u64,
        1 << 32,
        i64::MAX as u64,
        1 << 63,
        u64::MAX,
    ];
    let mut bytes = golden.to_vec();
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len().max(1));
        let count = random.below(64).min(bytes.len() - at.min(bytes.len()));
        match random.below(8) {
            0 | 1 => bytes[at] ^= 1 << random.below(8),
            2 => bytes[at] = random.next_u64() as u8,
            3 => {
                // Most fields are at multiples of four.
                let (at, number) = (at & !3, NUMBERS[random.below(NUMBERS.len())].to_le_bytes());
                for (byte, new) in bytes[at..].iter_mut().zip(&number[..[4, 8][random.below(2)]]) {
                    *byte = *new;
                }
            }
            4 => bytes.truncate(bytes.len() - count),
            5 => drop(bytes.drain(at..at + count)),
            6 => bytes.extend_from_within(at..at + count),
            _ => {
                let piece = bytes[at..at + count].to_vec();
                let to = random.below(bytes.len() - count + 1);
                bytes[to..to + count].copy_from_slice(&piece);
            }
        }
        if bytes.is_empty() {
            break;
        }
    }
    bytes
}

#[test]
fn twenty_thousand_mutations_do_not_panic() {
    let bases = bases();
    for base in &bases {
        assert!(bodies::open(base) && bodies::round_trip(base), "the package itself is valid");
    }
    let mut random = Random(0x70656c616765);
    let (mut valid, mut refused) = (0, 0);
    for i in 0..20_000 {
        let mut bytes = mutate(&bases[i % bases.len()], &mut random);
        bodies::open(&bytes);
        bodies::reseal(&mut bytes);
        if bodies::round_trip(&bytes) {
            bodies::open(&bytes);
            valid += 1;
        } else {
            refused += 1;
        }
    }
    // Valid and refused mutations must both occur; otherwise half of the test would be vacuous.
    assert!(valid > 1000 && refused > 1000, "{valid} valid and {refused} refused mutations");
}
