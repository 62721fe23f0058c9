//! uses debug/false_color, hair/packed_light
// Single strands: ribbons that face the eye, as wide as the hair, with light interpolated between their points.

struct Frame {
    clip_from_world: mat4x4<f32>,
}

@group(0) @binding(0) var<uniform> frame: Frame;

struct StrandVarying {
    @invariant @builtin(position) position: vec4<f32>,
    // Linear, because ribbons are too thin for visible perspective. Centroid, because a ribbon may cover samples but
    // not the pixel centre: light is then evaluated inside it. Extrapolation beyond its edge would give negative
    // values, or values too large for a floating-point target.
    @location(0) @interpolate(linear, centroid) light: vec3<f32>,
}

@vertex
fn vs_strands(@location(0) position: vec3<f32>, @location(1) light: u32) -> StrandVarying {
    return StrandVarying(frame.clip_from_world * vec4(position, 1.0), unpacked_light(light));
}

@fragment
fn fs_strands(in: StrandVarying) -> @location(0) vec4<f32> {
    return false_color_with(vec4(in.light, 1.0), geometry_color(4u), true);
}
