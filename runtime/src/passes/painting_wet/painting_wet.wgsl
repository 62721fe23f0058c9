//! uses painting/frame
// Wet washes: pigment and coverage blurred at a quarter of the picture's size.

@group(0) @binding(0) var<uniform> painting: PaintingFrame;
@group(0) @binding(1) var source: texture_2d<f32>;
@group(0) @binding(2) var clamped: sampler;

@vertex
fn vs_wet(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4(corner * 2.0 - 1.0, 0.0, 1.0);
}

// Share of the smaller of two overlapping densities that adds to the greater one.
const OVERLAP: f32 = 0.2;

fn density_and_coverage(uv: vec2<f32>) -> vec2<f32> {
    let s = textureSampleLevel(source, clamped, uv, 0.0);
    return vec2(s.x + OVERLAP * max(s.w - s.x, 0.0), s.y);
}

// Reduces the washes to a quarter of the size: density and coverage.
@fragment
fn fs_reduce(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let uv = position.xy * 4.0 / painting.size;
    let px = 1.0 / painting.size;
    let mean = 0.25 * (density_and_coverage(uv + px * vec2(-1.0, -1.0))
        + density_and_coverage(uv + px * vec2(1.0, -1.0))
        + density_and_coverage(uv + px * vec2(-1.0, 1.0)) + density_and_coverage(uv + px * vec2(1.0, 1.0)));
    return vec4(mean, mean);
}

// Blurs along one axis: pigment widely, by the wetness, in xy; narrowly in zw.
fn blurred(position: vec2<f32>, way: vec2<f32>) -> vec4<f32> {
    let size = vec2<f32>(textureDimensions(source));
    let reach = painting.unit_px * way / size;
    var sum = vec4(0.0);
    var weight = vec2(0.0);
    for (var k = -4; k <= 4; k++) {
        let t = f32(k);
        let w = vec2(exp(-t * t / 8.0), exp(-t * t / 1.2));
        let far = reach * t * (0.3 + 0.9 * painting.wetness);
        let wide = textureSampleLevel(source, clamped, position / size + far, 0.0).xy;
        let narrow = textureSampleLevel(source, clamped, position / size + reach * t * 0.7, 0.0).zw;
        sum += vec4(wide * w.x, narrow * w.y);
        weight += w;
    }
    return vec4(sum.xy / weight.x, sum.zw / weight.y);
}

@fragment
fn fs_blur_rows(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    return blurred(position.xy, vec2(1.0, 0.0));
}

@fragment
fn fs_blur_columns(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    return blurred(position.xy, vec2(0.0, 1.0));
}
