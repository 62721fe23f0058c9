//! uses hair/constants, hair/strand, shared/skinning, surface/place
// Posed strands of a part, for passes that run after the posing pass.

@group(2) @binding(0) var<storage, read> posed: array<vec4<f32>>;
@group(2) @binding(1) var<storage, read> strands: array<Strand>;
// Data of a tile point: offset; height and radius; colour; visibility.
@group(2) @binding(2) var<storage, read> tile: array<vec4<u32>>;
@group(2) @binding(3) var<uniform> constants: StrandConstants;

// Returns the world-space position of an element of `posed` that holds a point.
fn world_place(index: u32) -> vec3<f32> {
    return (instance.world_from_model * vec4(posed[index].xyz, 1.0)).xyz;
}

// Returns the world-space unit normal of an element of `posed` that holds a normal.
fn world_normal(index: u32) -> vec3<f32> {
    let normal = mat3x3(instance.normal_x.xyz, instance.normal_y.xyz, instance.normal_z.xyz) * posed[index].xyz;
    return normalize_or(normal, vec3(0.0, 1.0, 0.0));
}

// Returns the strand index of a thread, for workgroups of 64 threads.
fn number_of(id: vec3<u32>, groups: vec3<u32>) -> u32 {
    return constants.first + id.y * groups.x * 64u + id.x;
}
