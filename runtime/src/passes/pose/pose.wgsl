//! uses passes/pose/morphed or passes/pose/still, shared/skinning, shared/tile_frame, surface/geometry
// Skinning of the base mesh (formulas 2.2, 2.3), once per frame; every later pass reads the posed vertices.

// Four u16 joint indices in two words, the low half first.
struct SkinVertex {
    joints_xy: u32,
    joints_zw: u32,
    weight_x: f32,
    weight_y: f32,
    weight_z: f32,
    weight_w: f32,
}

// Length of a tangent below which morph targets hide the vertex; as in formats/src/meaning/skinning.rs.
const HIDDEN_SIZE: f32 = 0.02;

@group(0) @binding(0) var<storage, read> joints: array<mat4x4<f32>>;
@group(1) @binding(0) var<storage, read> rest: array<GeometryVertex>;
@group(1) @binding(1) var<storage, read> skin: array<SkinVertex>;
@group(1) @binding(2) var<storage, read_write> posed: array<GeometryVertex>;

@compute @workgroup_size(64)
fn pose(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    if index >= arrayLength(&posed) {
        return;
    }
    let v = morphed(index, rest[index]);
    let s = skin[index];
    let weights = vec4(s.weight_x, s.weight_y, s.weight_z, s.weight_w);
    let m = blend(
        joints[s.joints_xy & 0xffffu],
        joints[s.joints_xy >> 16u],
        joints[s.joints_zw & 0xffffu],
        joints[s.joints_zw >> 16u],
        weights,
    );
    let linear = mat3x3(m[0].xyz, m[1].xyz, m[2].xyz);
    let normal = transform_normal(linear, v.normal);
    let tangent = orthonormal_tangent(linear * v.tangent.xyz, normal);
    var out: GeometryVertex;
    out.position = (m * vec4(v.position, 1.0)).xyz;
    // A vertex collapsed by a scale of zero or by morph targets has no hair.
    let shown = dot(v.tangent.xyz, v.tangent.xyz) >= HIDDEN_SIZE * HIDDEN_SIZE;
    let scaled = any(max(abs(m[0]), max(abs(m[1]), abs(m[2]))).xyz > vec3(0.0));
    out.fur_height = select(0.0, v.fur_height, shown && scaled);
    out.normal = normal;
    out.lean = v.lean;
    out.tangent = vec4(tangent, v.tangent.w * handedness_of(linear));
    posed[index] = out;
}
