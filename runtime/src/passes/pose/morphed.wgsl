//! uses shared/skinning, surface/geometry
// Application of morph targets: adds each target's deltas to a vertex, scaled by the difference of its weight from the
// rest weight. Counterpart of `morphed` in formats/src/meaning/skinning.rs.

// Size: ten words, without padding.
struct MorphDelta {
    morph: u32,
    position_x: f32,
    position_y: f32,
    position_z: f32,
    normal_x: f32,
    normal_y: f32,
    normal_z: f32,
    tangent_x: f32,
    tangent_y: f32,
    tangent_z: f32,
}

// Index of each vertex's first delta; one more entry marks the end.
@group(2) @binding(0) var<storage, read> first_delta: array<u32>;
@group(2) @binding(1) var<storage, read> deltas: array<MorphDelta>;
@group(3) @binding(0) var<storage, read> shifts: array<f32>;

// Returns a vertex with the morph targets applied.
fn morphed(index: u32, v: GeometryVertex) -> GeometryVertex {
    var out = v;
    var moves = false;
    for (var i = first_delta[index]; i < first_delta[index + 1u]; i++) {
        let d = deltas[i];
        let shift = shifts[d.morph];
        if shift != 0.0 {
            moves = true;
            out.position += vec3(d.position_x, d.position_y, d.position_z) * shift;
            out.normal += vec3(d.normal_x, d.normal_y, d.normal_z) * shift;
            out.tangent += vec4(vec3(d.tangent_x, d.tangent_y, d.tangent_z) * shift, 0.0);
        }
    }
    if moves {
        out.normal = normalize_or(out.normal, v.normal);
    }
    return out;
}
