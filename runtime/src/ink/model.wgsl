// Uniform block and textures shared by the ink passes that draw a model's surface.

struct InkModel {
    // Right vector of the view.
    right_ws: vec3<f32>,
    wash_speed: f32,
    // Up vector of the view.
    up_ws: vec3<f32>,
    wash_range: f32,
    // Number of wash tile periods per unit of the stored mesh.
    periods: f32,
    // 1 if the wash depends only on the angle between the normal and the direction to the eye; otherwise 0.
    normalised: f32,
    // Weight of the wash tile.
    grain: f32,
    // Weight of the base colour's darkness.
    tone: f32,
    // Weight of fur strokes.
    fur: f32,
    // Factor on the line width.
    line: f32,
    // Variation of brush pressure.
    pressure: f32,
    // Factor on the breadth of the sphere map's rim.
    swell: f32,
    // Ink colour, sRGB-encoded.
    ink: vec3<f32>,
    // Period of the paper, pixels.
    paper_period: f32,
    // Width of a fur stroke, pixels.
    stroke_px: f32,
    // Pixels per metre at clip-space w = 1.
    px_per_unit: f32,
    reserved1: f32,
    reserved2: f32,
}

@group(2) @binding(0) var<uniform> model: InkModel;
@group(2) @binding(1) var stroke_map: texture_2d<f32>;
@group(2) @binding(2) var wash_tile: texture_2d<f32>;
@group(2) @binding(3) var fur_strokes: texture_2d_array<f32>;
@group(2) @binding(4) var paper_tile: texture_2d<f32>;
@group(2) @binding(5) var tile_sampler: sampler;
@group(2) @binding(6) var clamp_sampler: sampler;

// Width of a stroke in the texture, as a fraction of the tile.
const STROKE_TILES: f32 = 0.022;

// Samples fur strokes so that they never get thinner on screen than a brush (formulas 5.5). As the fur gets small on
// screen, the texture is enlarged by powers of 2. Adjacent scales are blended, so that strokes neither blur into grey
// nor jump. `along`: 1 for the texture axes that are scaled, 0 for the others.
fn fur_strokes_at(uv: vec2<f32>, along: vec2<f32>, layer: u32) -> vec4<f32> {
    let dx = dpdx(uv) * along;
    let dy = dpdy(uv) * along;
    let tiles_per_px = sqrt(max(dot(dx, dx), dot(dy, dy)));
    let octave = min(log2(STROKE_TILES / max(model.stroke_px * tiles_per_px, 1e-9)), 0.0);
    let whole = floor(octave);
    let fine = mix(vec2(1.0), vec2(exp2(min(whole + 1.0, 0.0))), along);
    let coarse = mix(vec2(1.0), vec2(exp2(whole)), along);
    return mix(
        textureSampleGrad(fur_strokes, tile_sampler, uv * coarse, layer, dpdx(uv) * coarse, dpdy(uv) * coarse),
        textureSampleGrad(fur_strokes, tile_sampler, uv * fine, layer, dpdx(uv) * fine, dpdy(uv) * fine),
        octave - whole,
    );
}
