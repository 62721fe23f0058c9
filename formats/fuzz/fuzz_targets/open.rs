//! Fuzz target `cargo +nightly fuzz run open -- -max_len=8192` (in `formats/`): checks that no input makes the reader
//! panic.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pelage_formats_fuzz::{open, reseal};

fuzz_target!(|data: &[u8]| {
    open(data);
    let mut sealed = data.to_vec();
    reseal(&mut sealed);
    open(&sealed);
});
