//! uses ink/screen, shared/srgb
// Fragment shader that shows one component of an ink painting, for measurement; joined after ink_composite.wgsl.

// Component to show. 1: lines, black on white; 2: features; 3: wash.
override SHOW: u32 = 1u;

@fragment
fn fs_show(@builtin(position) position: vec4<f32>) -> Painted {
    let p = clamp_to_target(vec2<i32>(position.xy));
    let uv = position.xy / ink.size;
    // When `SHOW` is 2, the features texture is bound as `strokes`.
    let stroke = textureLoad(strokes, p, 0);
    let depth = depth_at(p, feature_of(p, stroke), textureLoad(normals, p, 0).w > 0.0, stroke.x);
    if SHOW == 1u {
        return Painted(vec4(vec3(1.0 - line_at(uv, stroke).x), 1.0), depth);
    }
    if SHOW == 2u {
        return Painted(vec4(vec3(select(1.0, 0.0, stroke.x > 0.0)), 1.0), depth);
    }
    let sheet = textureSampleLevel(paper, paper_sampler, position.xy / ink.paper_period, 0.0);
    return Painted(vec4(linear_of(vec3(wash_at(uv, sheet))), 1.0), depth);
}
