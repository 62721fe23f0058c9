#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use super::*;
use pelage_bake::recipe::{Style, natural};

/// Returns a recipe with a small tile; `frizz` sets how much its hairs differ in direction.
fn recipe(format: &str, frizz: f32) -> Recipe {
    let mut recipe = natural();
    for set in ["hair.density=60", "slice.layers=6", "slice.tile_texels=32"] {
        recipe.set(set).unwrap();
    }
    recipe.set(&format!("pack.direction_format={format}")).unwrap();
    recipe.set(&format!("hair.frizz={frizz:?}")).unwrap();
    recipe.hair.style = Style::Straight;
    recipe
}

fn measured(format: &str, frizz: f32, lighting: LightingStage) -> LightingErrors {
    let configuration = LightingConfiguration {
        series: "",
        label: String::new(),
        lighting,
        sets: Vec::new(),
        recipe: recipe(format, frizz),
    };
    measure(&configuration, Lengths { tile_size_m: 0.05, length_m: 0.02 }).unwrap()
}

#[test]
fn every_strand_crosses_the_layers_below_its_tip() {
    let point = |h: f32| Vec3::new(0.5 * h, 2.0, h);
    let strands = Strands {
        points: vec![point(0.0), point(0.45), point(0.9), point(0.0), point(0.3)],
        radii: vec![0.01; 5],
        colors: vec![Vec3::ONE; 5],
        offsets: vec![0, 3, 5],
        height: 1.0,
        ..Strands::default()
    };
    let crossings = crossings(&strands, 5);
    let found: Vec<(u32, f32)> = crossings.iter().map(|c| (c.layer, c.u)).collect();
    assert_eq!(found, [(1, 0.125), (2, 0.25), (3, 0.375), (1, 0.125)]);
    let slope = DVec3::new(0.5, 0.0, 1.0).normalize();
    assert!(crossings.iter().all(|c| c.tangent.dot(slope) > 1.0 - 1e-9));
}

#[test]
fn direction_error_is_lower_per_pixel_than_per_vertex() {
    for format in ["rg8", "rgba8", "bc5"] {
        let (pixel, vertex) =
            (measured(format, 0.5, LightingStage::Pixel), measured(format, 0.5, LightingStage::Vertex));
        assert!(pixel.direction_error_deg < 0.8 * vertex.direction_error_deg, "{format}: {pixel:?}, {vertex:?}");
        assert!(pixel.light.rmse() < vertex.light.rmse(), "{format}: {pixel:?}, {vertex:?}");
        // If all hairs have the same direction, light per vertex uses the exact direction as well, up to rounding.
        let alike = measured(format, 0.0, LightingStage::Vertex);
        assert!(alike.direction_error_deg < 0.5 * vertex.direction_error_deg, "{format}: {alike:?}");
    }
}

#[test]
fn bc5_decoding_agrees_with_another_decoder() {
    let mut state = 1u32;
    let data: Vec<u8> = std::iter::repeat_with(|| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    })
    .take(2 * 4 * 16)
    .collect();
    // The data contain two layers of 8 * 8 texels.
    let ours = bc5(&data, 8);
    for (layer, blocks) in data.chunks_exact(64).enumerate() {
        let mut bgra = vec![0; 64];
        texture2ddecoder::decode_bc5(blocks, 8, 8, &mut bgra).unwrap();
        for (ours, theirs) in ours[64 * layer..].iter().zip(bgra) {
            let [_, g, r, _] = theirs.to_le_bytes();
            // The other decoder rounds to bytes.
            assert!((ours[0] * 255.0 - f32::from(r)).abs() <= 1.0, "{ours:?} {theirs:x}");
            assert!((ours[1] * 255.0 - f32::from(g)).abs() <= 1.0, "{ours:?} {theirs:x}");
        }
    }
}
