#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]
//! Memory of the device while a stage shows one package after the other, as a window does while a recipe changes.

use crate::runtime::frames::furry_package;
use pelage_stage::{Cast, Framing, Gpu, Look, NamedPackage, Size, Stage};
use pelage_tests::gpu::gpu;

#[test]
fn new_packages_replace_the_memory_of_old_ones() {
    if gpu("new_packages_replace_the_memory_of_old_ones").is_none() {
        return;
    }
    // Other tests use the shared device at the same time.
    let gpu = Gpu::open().unwrap();
    let file = NamedPackage::new("fur".to_owned(), furry_package());
    let mut look = Look::of_picture();
    look.picture.size = Size { width: 32, height: 32 };
    let cast = || Cast::crowd(&file, file.open().unwrap(), None, 1, None, (&Framing::default(), 1.0)).unwrap();
    let mut stage = Stage::new(&cast(), &look.picture(), look.frame_params(), 0.0, || Ok(gpu.clone())).unwrap();
    let mut after = Vec::new();
    for _ in 0..12 {
        stage.set_cast(&cast(), 0.0).unwrap();
        stage.draw().unwrap();
        stage.draw().unwrap();
        // Not all backends count their memory.
        let Some(report) = gpu.device.generate_allocator_report() else { return };
        after.push(report.total_allocated_bytes);
    }
    assert!(after[11] < after[2] + (1 << 20), "bytes after each package: {after:?}");
}
