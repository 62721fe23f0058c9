// Fur in ink: fins along the outline and the outer shells as dry strokes of a brush, over what `ink_composite` painted.

struct StrokeVarying {
    @invariant @builtin(position) position: vec4<f32>,
    // Along and up the slab, or tile coordinates.
    @location(0) uv: vec2<f32>,
    @location(1) tint: vec4<f32>,
    @location(2) base_uv: vec2<f32>,
    // Share of the strokes, and of height: 0 on the skin, 1 at the outermost; height of the fur, metres; along a fin's edge, 0 to 1.
    @location(3) share_height: vec4<f32>,
    @location(4) position_ws: vec3<f32>,
    @location(5) normal_ws: vec3<f32>,
}

// What ink_normals drew.
@group(2) @binding(7) var bodies: texture_2d<f32>;

// Shells that strokes are drawn on, from the outermost inwards.
const STROKE_SHELLS: u32 = 2u;
// Strokes of shells are lifted off the skin by this many of their widths at most: higher ones hang in the air.
const LIFT: f32 = 3.0;
// How far strokes on fins lie over towards the comb, heights of the fur, as the default coat does.
const STROKE_LEAN: f32 = 0.4;
// How far a fin's root reaches onto the skin, pixels along each axis.
const ROOT: i32 = 2;
// Fins stand where the skin turns away from the eye by this or more.
const TURNED: f32 = 0.6;
// Below this there is nothing to see.
const LEAST_INK: f32 = 1.0 / 255.0;

@vertex
fn vs_ink_fins(@builtin(vertex_index) index: u32) -> StrokeVarying {
    let corner = fin_corner(index);
    let v = corner.vertex;
    let reach = v.fur_height * instance.scale;
    let position = hair_position(v, corner.tile, corner.height)
        + corner.tile.bitangent_ws * (STROKE_LEAN * corner.height * reach);
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
    out.share_height = vec4(share, corner.height, reach, corner.across);
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
    let reach = v.fur_height * instance.scale;
    let skin_w = (frame.clip_from_world * vec4(position_ws(v), 1.0)).w;
    let reach_px = reach * model.px_per_unit / max(skin_w, 1e-9);
    let lifted = height * min(LIFT * model.stroke_px / max(reach_px, 1e-9), 1.0);
    let position = hair_position(v, tile, mix(-0.1, lifted, smoothstep(0.25, 0.45, turned)));
    var out: StrokeVarying;
    out.position = frame.clip_from_world * vec4(position, 1.0);
    out.uv = v.tile_uv;
    out.tint = v.color * material.base_color;
    out.base_uv = v.base_uv;
    out.share_height = vec4(select(0.0, 1.0 - v.groom.x, v.fur_height > 0.0), height, reach, 0.0);
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

// How free a fin stands of the skin that is seen at a pixel: 1 over paper and over what is farther than its hair is long.
fn free_at(p: vec2<i32>, nearness: f32, reach: f32) -> f32 {
    let skin = textureLoad(bodies, p, 0).w;
    let gap = 1.0 / max(skin, 1e-9) - 1.0 / nearness;
    return select(smoothstep(1.0, 2.0, gap / max(reach, 1e-9)), 1.0, skin <= 0.0);
}

// How free a fin stands: 0 right before the skin, where it would lie on it as a blot. Its root reaches onto the outline, or paper would show between them.
fn free_of_skin(position: vec4<f32>, reach: f32) -> f32 {
    let p = vec2<i32>(position.xy);
    let near = vec4(
        free_at(p + vec2(-ROOT, -ROOT), position.w, reach), free_at(p + vec2(-ROOT, ROOT), position.w, reach),
        free_at(p + vec2(ROOT, -ROOT), position.w, reach), free_at(p + vec2(ROOT, ROOT), position.w, reach),
    );
    return max(free_at(p, position.w, reach), min(dot(near, vec4(0.5)), 1.0));
}

// A fin is a tuft: as wide as its edge at the skin, pointed at the tips. Its sides would cut strokes off.
fn tuft(across: f32, height: f32) -> f32 {
    return 1.0 - smoothstep(0.9, 1.3, abs(2.0 * across - 1.0) + 0.75 * height);
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
    let whole = tuft(in.share_height.w, in.share_height.y) * free_of_skin(in.position, in.share_height.z);
    // The brush lifts towards the tip.
    return painted(whole * smoothstep(0.2, 0.6, ink) * min(2.0 * in.share_height.x, 1.0) * (0.85 - 0.3 * in.share_height.y), 0.4 * in.share_height.y, in.position.xy);
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
