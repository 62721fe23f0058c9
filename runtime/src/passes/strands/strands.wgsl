// Strands one by one: ribbons that face the eye, as wide as the hair, with the light of their points.

struct Frame {
    clip_from_world: mat4x4<f32>,
}

@group(0) @binding(0) var<uniform> frame: Frame;

struct StrandVarying {
    @invariant @builtin(position) position: vec4<f32>,
    // A ribbon is too thin for perspective within it to be seen. Where it covers samples and not the pixel's middle, light is taken within it:
    // beyond its edge it runs on to less than nothing, and to more than a floating-point target should hold.
    @location(0) @interpolate(linear, centroid) light: vec3<f32>,
}

@vertex
fn vs_strands(@location(0) position: vec3<f32>, @location(1) light: u32) -> StrandVarying {
    return StrandVarying(frame.clip_from_world * vec4(position, 1.0), unpacked_light(light));
}

@fragment
fn fs_strands(in: StrandVarying) -> @location(0) vec4<f32> {
    return shown_as(vec4(in.light, 1.0), geometry_color(4u), true);
}
