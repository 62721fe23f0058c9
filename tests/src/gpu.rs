//! Device that all GPU tests share.

use pelage_needs::{Need, gpu_is_wanted, log_available};
use pelage_runtime::wgpu;
use pelage_stage::Gpu;
use std::sync::OnceLock;

static SHARED: OnceLock<Gpu> = OnceLock::new();

/// Returns the device for the named GPU test. All tests of a process share it.
///
/// A missing adapter is a failure, unless `PELAGE_NO_GPU=1` is set. In that case returns `None` and prints a message to
/// stderr. The name must be in `tests/needs/register.txt`; `./run test` checks that the test had the device.
pub fn gpu(test: &str) -> Option<&'static Gpu> {
    if !gpu_is_wanted(test) {
        return None;
    }
    let gpu = SHARED.get_or_init(|| {
        Gpu::with(wgpu::Features::TEXTURE_COMPRESSION_BC, Some(wgpu::Limits::default()))
            .unwrap_or_else(|e| panic!("{e}; or set PELAGE_NO_GPU=1 to leave the GPU tests out"))
    });
    log_available(Need::Gpu, test, &gpu.info.name);
    Some(gpu)
}
