//! Benchmark `cargo bench -p pelage-formats`: measures the time to open a 50 MiB package, which reads only header,
//! section table and manifest. It also measures the first texture access, which verifies checksums. Prints minimum,
//! median and maximum time; fails if the median opening time exceeds the project's target.
#![allow(clippy::unwrap_used, reason = "in a benchmark a panic is the report")]

#[path = "../tests/formats/common/mod.rs"]
mod common;

use pelage_formats::*;
use std::time::{Duration, Instant};

const PROMISED: Duration = Duration::from_millis(2);

fn main() {
    // Realistic layout: shell colour and direction of 1024 x 1024 in 6 layers, base colour of 512 x 512, all with mips.
    let manifest = Manifest {
        fur: FurInfo { layers: 6, tile_texels: 1024, ..common::sample_manifest_v1().fur },
        ..common::sample_manifest_v1()
    };
    let bytes = PackageWriter::new(manifest)
        .mesh(&common::sample_mesh(true))
        .animation(&common::sample_animation())
        .texture(common::ktx2_file(TextureFormat::Rgba8Srgb, 1024, 1024, 6, 11, 0))
        .texture(common::ktx2_file(TextureFormat::Rg8Unorm, 1024, 1024, 6, 11, 0))
        .texture(common::ktx2_file(TextureFormat::Rgba8Srgb, 1024, 1024, 0, 11, 0))
        .finish()
        .unwrap();
    assert!(bytes.len() >= 50 << 20, "the package has {} bytes", bytes.len());

    let limits = Limits::default();
    let open = measure(1000, || Package::open(&bytes, &limits).unwrap().sections().len());
    let open_and_use = measure(20, || {
        let package = Package::open(&bytes, &limits).unwrap();
        (0..3).map(|k| package.texture(k).unwrap().level(0).len()).sum()
    });
    println!("package of {:.1} MiB", bytes.len() as f64 / f64::from(1 << 20));
    for (name, [least, median, greatest]) in [("open", open), ("open and verify all textures", open_and_use)] {
        println!("{name}: least {least:?}, median {median:?}, greatest {greatest:?}");
    }
    let median = open[1];
    assert!(median <= PROMISED, "opening took {median:?}, expected at most {PROMISED:?}");
}

fn measure(times: usize, mut f: impl FnMut() -> usize) -> [Duration; 3] {
    let mut seen: Vec<_> = (0..times)
        .map(|_| {
            let start = Instant::now();
            assert!(std::hint::black_box(f()) > 0);
            start.elapsed()
        })
        .collect();
    seen.sort();
    [seen[0], seen[times / 2], seen[times - 1]]
}
