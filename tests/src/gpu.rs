//! The device that GPU tests share.

use pelage_needs::{Need, gpu_is_wanted, had};
use pelage_runtime::wgpu;
use pelage_stage::Gpu;
use std::sync::OnceLock;

static SHARED: OnceLock<Gpu> = OnceLock::new();

/// The device for the GPU test of that name, shared by the tests of one process.
///
/// No adapter is a failure, unless `PELAGE_NO_GPU=1` says by name that GPU tests are left out: then `None`, with a loud word. The name
/// stands in `tests/needs/register.txt`, and `./run test` counts that the test had the device.
pub fn gpu(test: &str) -> Option<&'static Gpu> {
    if !gpu_is_wanted(test) {
        return None;
    }
    let gpu = SHARED.get_or_init(|| {
        Gpu::with(wgpu::Features::TEXTURE_COMPRESSION_BC, Some(wgpu::Limits::default()))
            .unwrap_or_else(|e| panic!("{e}; or set PELAGE_NO_GPU=1 to leave the GPU tests out"))
    });
    had(Need::Gpu, test, &gpu.info.name);
    Some(gpu)
}
