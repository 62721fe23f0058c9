//! Fuzz target `cargo +nightly fuzz run round_trip -- -max_len=8192` (in `formats/`): checks that every valid package
//! is written back byte for byte.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pelage_formats_fuzz::{reseal, round_trip};

fuzz_target!(|data: &[u8]| {
    let mut sealed = data.to_vec();
    reseal(&mut sealed);
    round_trip(&sealed);
});
