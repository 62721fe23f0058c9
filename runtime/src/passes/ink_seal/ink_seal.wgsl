// The seal: paste that covers what is below it where the image is coloured, and nothing where it is white.

struct StampedSeal {
    // Centre and half of the size, as shares of the picture from its upper left corner.
    center: vec2<f32>,
    half_size: vec2<f32>,
    // Texels of the image per pixel of the picture.
    texels_per_px: f32,
    // Period of the paper, pixels, and weight of its relief.
    paper_period: f32,
    paper_grain: f32,
    reserved: f32,
}

@group(0) @binding(0) var<uniform> stamped: StampedSeal;
@group(0) @binding(1) var image: texture_2d<f32>;
@group(0) @binding(2) var paper: texture_2d<f32>;
@group(0) @binding(3) var clamped: sampler;
@group(0) @binding(4) var paper_sampler: sampler;

struct SealVertex {
    @builtin(position) position: vec4<f32>,
    @location(0) uv: vec2<f32>,
}

@vertex
fn vs_seal(@builtin(vertex_index) corner: u32) -> SealVertex {
    let uv = vec2<f32>(f32(corner & 1u), f32(corner >> 1u));
    let at = stamped.center + (2.0 * uv - 1.0) * stamped.half_size;
    return SealVertex(vec4(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y, 0.0, 1.0), uv);
}

// Most samples of the image along each side of a pixel.
const MOST: f32 = 16.0;
// Share of the paste that the paper's hollows do not take.
const UNEVEN: f32 = 0.7;

@fragment
fn fs_seal(@builtin(position) position: vec4<f32>, @location(0) uv: vec2<f32>) -> @location(0) vec4<f32> {
    // The mean over the pixel, so that a large image keeps its thin lines.
    let steps = clamp(ceil(stamped.texels_per_px), 1.0, MOST);
    let span = stamped.texels_per_px / vec2<f32>(textureDimensions(image));
    var sum = vec3(0.0);
    for (var j = 0.5; j < steps; j += 1.0) {
        for (var i = 0.5; i < steps; i += 1.0) {
            let texel = textureSampleLevel(image, clamped, uv + span * (vec2(i, j) / steps - 0.5), 0.0);
            sum += mix(vec3(1.0), texel.rgb, texel.a);
        }
    }
    let relief = textureSampleLevel(paper, paper_sampler, position.xy / stamped.paper_period, 0.0).r;
    let taken = 1.0 - UNEVEN * stamped.paper_grain * smoothstep(0.55, 0.2, relief);
    let color = mix(vec3(1.0), sum / (steps * steps), taken);
    let white = min(color.r, min(color.g, color.b));
    return vec4(color - white, 1.0 - white);
}
