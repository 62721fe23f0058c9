// Fur in ink: fins along the outline and the outer shells as dry strokes of a brush, over what `ink_composite` painted.

struct StrokeVarying {
    @invariant @builtin(position) position: vec4<f32>,
    // Along and up the slab, or tile coordinates.
    @location(0) uv: vec2<f32>,
    @location(1) tint: vec4<f32>,
    @location(2) base_uv: vec2<f32>,
    // Share of the strokes, and of height: 0 on the skin, 1 at the outermost.
    @location(3) share_height: vec2<f32>,
    @location(4) position_ws: vec3<f32>,
    @location(5) normal_ws: vec3<f32>,
}

// Shells that strokes are drawn on, from the outermost inwards.
const STROKE_SHELLS: u32 = 2u;
// Fins stand where the skin turns away from the eye by this or more.
const TURNED: f32 = 0.6;
// Below this there is nothing to see.
const LEAST_INK: f32 = 1.0 / 255.0;

@vertex
fn vs_ink_fins(@builtin(vertex_index) index: u32) -> StrokeVarying {
    let corner = fin_corner(index);
    let v = corner.vertex;
    let position = hair_position(v, corner.tile, corner.height);
    var out: StrokeVarying;
    // The share of the fin's opacity is how wide a strip of skin it stands for: strokes need all of it.
    let eye = direction_to(frame.eye_ws, position_ws(v));
    // On the outline alone: inside it fins of coarse meshes show as flags.
    let turned = smoothstep(TURNED, 0.9, 1.0 - abs(dot(corner.tile.normal_ws, eye)));
    let share = min(corner.opacity * 1.5, 1.0) * turned * (1.0 - v.groom.x);
    out.position = frame.clip_from_world * vec4(position, 1.0);
    // The same at all corners, or the fin would reach to the middle of the picture.
    if corner.opacity < LEAST_INK || corner.turned < TURNED {
        out.position = vec4(0.0, 0.0, 0.0, 1.0);
    }
    out.uv = vec2(corner.along, corner.height);
    out.tint = v.color * material.base_color;
    out.base_uv = v.base_uv;
    out.share_height = vec2(share, corner.height);
    out.position_ws = position;
    out.normal_ws = corner.tile.normal_ws;
    return out;
}

@vertex
fn vs_ink_shells(v: Vertex, @builtin(instance_index) shell: u32) -> StrokeVarying {
    let height = f32(shell + 1u) / f32(STROKE_SHELLS);
    let tile = tile_frame_of(v, normal_ws(v));
    // Where the coat faces the eye nothing is drawn: there shells sink below the skin, and the depth test leaves them out.
    let turned = 1.0 - abs(dot(tile.normal_ws, direction_to(frame.eye_ws, position_ws(v))));
    let position = hair_position(v, tile, mix(-0.1, height, smoothstep(0.25, 0.45, turned)));
    var out: StrokeVarying;
    out.position = frame.clip_from_world * vec4(position, 1.0);
    out.uv = v.tile_uv;
    out.tint = v.color * material.base_color;
    out.base_uv = v.base_uv;
    out.share_height = vec2(select(0.0, 1.0 - v.groom.x, v.fur_height > 0.0), height);
    out.position_ws = position;
    out.normal_ws = tile.normal_ws;
    return out;
}

// Ink on paper: what stands out takes it, the drier the brush the less.
fn painted(amount: f32, dry: f32, position: vec2<f32>) -> vec4<f32> {
    let sheet = textureSampleLevel(paper_tile, tile_sampler, position / model.paper_period, 0.0);
    let opacity = amount * smoothstep(-0.15, 0.15, 1.0 - dry - 0.85 * sheet.a);
    if opacity < LEAST_INK {
        discard;
    }
    return vec4(linear_of(model.ink) * opacity, opacity);
}

@fragment
fn fs_ink_fins(in: StrokeVarying) -> @location(0) vec4<f32> {
    // The tile repeats upwards too: away from where the roots would fade into the tips.
    let strokes = fur_strokes_at(vec2(in.uv.x, mix(0.1, 0.96, in.uv.y)), vec2(1.0, 0.0), 1u);
    let base = base_color(in.tint, in.base_uv);
    if is_cut(base.a) {
        discard;
    }
    let ink = ink_nested(strokes, (0.15 + 0.35 * model.fur) * in.share_height.x) * model.fur;
    // The brush lifts towards the tip.
    return painted(smoothstep(0.2, 0.6, ink) * min(2.0 * in.share_height.x, 1.0) * (0.85 - 0.3 * in.share_height.y), 0.4 * in.share_height.y, in.position.xy);
}

@fragment
fn fs_ink_shells(in: StrokeVarying) -> @location(0) vec4<f32> {
    let strokes = fur_strokes_at(in.uv, vec2(1.0), 0u);
    let base = base_color(in.tint, in.base_uv);
    if is_cut(base.a) {
        discard;
    }
    let eye = direction_to(frame.eye_ws, in.position_ws);
    // Seen from above a stroke's shells would cover each other; they are there for where the coat turns away.
    let turned = 1.0 - abs(dot(normalize_or(in.normal_ws, eye), eye));
    let amount = in.share_height.x * model.fur * smoothstep(0.45, 0.95, turned);
    let ink = ink_nested(strokes, amount * 0.5);
    // A stroke is thinner the higher the shell: what is left of it is its middle.
    let tapered = smoothstep(0.25 + 0.5 * in.share_height.y, 0.6 + 0.4 * in.share_height.y, ink);
    return painted(tapered * amount * (0.75 - 0.3 * in.share_height.y), 0.3 + 0.3 * in.share_height.y, in.position.xy);
}
