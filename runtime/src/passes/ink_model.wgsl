// What the ink passes over a model's surface share: its constants and textures.

struct InkModel {
    // Right of the picture.
    right_ws: vec3<f32>,
    wash_speed: f32,
    // Up of the picture.
    up_ws: vec3<f32>,
    wash_range: f32,
    // Periods of the wash's tile per unit of the stored mesh.
    periods: f32,
    // 1 where the wash follows the angle alone.
    normalised: f32,
    // Shares: of the wash's tile, of the base colour's darkness, of strokes of fur.
    grain: f32,
    tone: f32,
    fur: f32,
    // Factor on the width of lines, and how unevenly the hand presses.
    line: f32,
    pressure: f32,
    // Factor on the rim of the sphere map.
    swell: f32,
    // sRGB-encoded.
    ink: vec3<f32>,
    // Period of the paper, pixels.
    paper_period: f32,
}

@group(2) @binding(0) var<uniform> model: InkModel;
@group(2) @binding(1) var stroke_map: texture_2d<f32>;
@group(2) @binding(2) var wash_tile: texture_2d<f32>;
@group(2) @binding(3) var fur_strokes: texture_2d_array<f32>;
@group(2) @binding(4) var paper_tile: texture_2d<f32>;
@group(2) @binding(5) var tile_sampler: sampler;
@group(2) @binding(6) var clamp_sampler: sampler;
