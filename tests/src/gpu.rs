//! The device that GPU tests share, and the rule that they never vanish.

use crate::support::headless::Gpu;
use pelage_runtime::wgpu;
use std::io::Write;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

static SHARED: OnceLock<Gpu> = OnceLock::new();
static RAN: AtomicU32 = AtomicU32::new(0);

/// The device for the GPU test of that name, shared by the tests of one process.
///
/// No adapter is a failure, unless `PELAGE_NO_GPU=1` says by name that GPU tests are switched off: then `None`, and a line on
/// stderr that even the test harness's capture lets through. A line says likewise which GPU tests ran: `./run test` counts them.
pub fn gpu(test: &str) -> Option<&'static Gpu> {
    // Written to the handle: the harness captures only the print macros.
    let say = |line: String| writeln!(std::io::stderr(), "{line}").expect("stderr can be written");
    if std::env::var("PELAGE_NO_GPU").is_ok_and(|v| v == "1") {
        say(format!("SKIPPED (PELAGE_NO_GPU=1): GPU test {test}"));
        return None;
    }
    let gpu = SHARED.get_or_init(|| {
        Gpu::open(wgpu::Features::TEXTURE_COMPRESSION_BC)
            .unwrap_or_else(|e| panic!("{e}; or set PELAGE_NO_GPU=1 to leave the GPU tests out"))
    });
    let number = RAN.fetch_add(1, Ordering::Relaxed) + 1;
    say(format!("GPU test {number} ran: {test} on {}", gpu.info.name));
    Some(gpu)
}
