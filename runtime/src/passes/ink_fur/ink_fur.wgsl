//! uses hair/fin_corner, ink/model, shared/frame, shared/ink, shared/skinning, shared/srgb, surface/place
// Fur strokes in ink: fins along the outline and outer shells as dry brush strokes, drawn over the result of
// `ink_composite`.

struct StrokeVarying {
    @invariant @builtin(position) position: vec4<f32>,
    // For fins: coordinates in the stroke texture, along the mesh edge and from root to tip. For shells: tile
    // coordinates.
    @location(0) uv: vec2<f32>,
    @location(1) tint: vec4<f32>,
    @location(2) base_uv: vec2<f32>,
    // Weight of the strokes; height, 0 on the mesh surface, 1 at the outermost layer; fur height, metres; position
    // along the fin's edge, 0..1.
    @location(3) share_height: vec4<f32>,
    @location(4) position_ws: vec3<f32>,
    @location(5) normal_ws: vec3<f32>,
}

// Normals target of the ink_normals pass.
@group(2) @binding(7) var bodies: texture_2d<f32>;

// Number of shells with strokes, counted from the outermost.
const STROKE_SHELLS: u32 = 2u;
// Maximum height of shell strokes above the mesh surface, in stroke widths; higher strokes would appear detached.
const LIFT: f32 = 3.0;
// Lean of fin strokes towards the comb direction, in fur heights, as in the default coat.
const STROKE_LEAN: f32 = 0.4;
// Distance that a fin's root extends onto the body, pixels along each axis.
const ROOT: i32 = 2;
// Turn of the surface away from the eye, 1 - |N.E|, at which fins begin to appear.
const TURNED: f32 = 0.6;
// Turn of the surface away from the eye, 1 - |N.E|, at which fins reach full opacity.
const FULLY_TURNED: f32 = 0.9;
// Factor from the opacity of a fin to the opacity of its strokes.
const FIN_STROKES: f32 = 1.5;
// Range of the surface's turn away from the eye, 1 - |N.E|, over which shells rise from below the mesh surface.
const SHELLS_RISE: vec2<f32> = vec2(0.25, 0.45);
// Height of the shells at the lower end of SHELLS_RISE.
const SUNKEN: f32 = -0.1;
// Range of the surface's turn away from the eye, 1 - |N.E|, over which the strokes of shells appear.
const SHELLS_APPEAR: vec2<f32> = vec2(0.45, 0.95);
// Half width of the edge of dry strokes; the dry brush is that of formulas 5.6, with constants of its own.
const DRY_EDGE: f32 = 0.15;
// Weight of the paper's threshold for dry strokes.
const DRY_PAPER: f32 = 0.85;
// Range of the gap behind a fin, in fur heights, over which the fin becomes separate from the body.
const SEPARATE: vec2<f32> = vec2(1.0, 2.0);
// Distances from the middle of a tuft at which its fade begins and ends.
const TUFT_END: vec2<f32> = vec2(0.9, 1.3);
// Narrowing of a tuft with height.
const TUFT_POINTED: f32 = 0.75;
// Range of rows of the stroke texture that fins show. It avoids the seam between roots and tips.
const FIN_ROWS: vec2<f32> = vec2(0.1, 0.96);
// Density of fin strokes without fur weight, and its gain with fur weight.
const FIN_DENSITY: vec2<f32> = vec2(0.15, 0.35);
// Range of values in a fin's stroke texture over which strokes go from none to full.
const FIN_INK: vec2<f32> = vec2(0.2, 0.6);
// Opacity at the root of a fin, and its loss at the tip.
const FIN_OPACITY: vec2<f32> = vec2(0.85, 0.3);
// Dryness at the tip of a fin.
const FIN_DRY: f32 = 0.4;
// Density of strokes on shells.
const SHELL_DENSITY: f32 = 0.5;
// Value in a shell's stroke texture at which strokes begin: at height 0, and its increase at full height. The next
// constant is the value at which strokes are full, in the same form.
const SHELL_BEGINS: vec2<f32> = vec2(0.25, 0.5);
const SHELL_FULL: vec2<f32> = vec2(0.6, 0.4);
// Opacity of shells at height 0, and its loss at full height.
const SHELL_OPACITY: vec2<f32> = vec2(0.75, 0.3);
// Dryness of shells at height 0, and its gain at full height.
const SHELL_DRY: vec2<f32> = vec2(0.3, 0.3);
// Minimum visible opacity.
const LEAST_INK: f32 = 1.0 / 255.0;

@vertex
fn vs_ink_fins(@builtin(vertex_index) index: u32) -> StrokeVarying {
    let corner = fin_corner(index);
    let v = corner.vertex;
    let reach = v.fur_height * instance.scale;
    let position = hair_position(v, corner.tile, corner.height)
        + corner.tile.bitangent_ws * (STROKE_LEAN * corner.height * reach);
    var out: StrokeVarying;
    // The opacity of a fin accounts for the width of the surface strip that it represents; strokes need full opacity
    // instead.
    let eye = direction_to(frame.eye_ws, position_ws(v));
    // Fins are drawn only along the outline: inside it, fins of coarse meshes look like flags.
    let turned = smoothstep(TURNED, FULLY_TURNED, 1.0 - abs(dot(corner.tile.normal_ws, eye)));
    let share = min(corner.opacity * FIN_STROKES, 1.0) * turned * (1.0 - v.groom.x);
    out.position = frame.clip_from_world * vec4(position, 1.0);
    // The condition is the same at all corners; otherwise the fin would stretch to the centre of the picture.
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
    // Shells must not show where the fur faces the eye: there, they sink below the mesh surface and fail the depth
    // test.
    let turned = 1.0 - abs(dot(tile.normal_ws, direction_to(frame.eye_ws, position_ws(v))));
    let reach = v.fur_height * instance.scale;
    let skin_w = (frame.clip_from_world * vec4(position_ws(v), 1.0)).w;
    let reach_px = reach * model.px_per_unit / max(skin_w, 1e-9);
    let lifted = height * min(LIFT * model.stroke_px / max(reach_px, 1e-9), 1.0);
    let risen = mix(SUNKEN, lifted, smoothstep(SHELLS_RISE.x, SHELLS_RISE.y, turned));
    let position = hair_position(v, tile, risen);
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

// Returns the ink on the paper (formulas 5.6). Only raised fibres take ink, and fewer of them if the brush is drier.
fn ink_on_paper(amount: f32, dry: f32, position: vec2<f32>) -> vec4<f32> {
    let sheet = textureSampleLevel(paper_tile, tile_sampler, position / model.paper_period, 0.0);
    let opacity = amount * smoothstep(-DRY_EDGE, DRY_EDGE, 1.0 - dry - DRY_PAPER * sheet.a);
    if opacity < LEAST_INK {
        discard;
    }
    return vec4(linear_of(model.ink) * opacity, opacity);
}

// Returns how far a fin is separate from the body at the pixel `p`, 0..1: 1 over paper, and over surfaces farther
// behind than the hair is long.
fn separation_at(p: vec2<i32>, nearness: f32, reach: f32) -> f32 {
    let skin = textureLoad(bodies, p, 0).w;
    let gap = 1.0 / max(skin, 1e-9) - 1.0 / nearness;
    return select(smoothstep(SEPARATE.x, SEPARATE.y, gap / max(reach, 1e-9)), 1.0, skin <= 0.0);
}

// Returns how far a fin is separate from the body: 0 directly in front of the surface, where the fin would look like a
// blot. The root of the fin extends onto the body's outline; otherwise paper would show between root and outline.
fn separation_from_body(position: vec4<f32>, reach: f32) -> f32 {
    let p = vec2<i32>(position.xy);
    let near = vec4(
        separation_at(p + vec2(-ROOT, -ROOT), position.w, reach),
        separation_at(p + vec2(-ROOT, ROOT), position.w, reach),
        separation_at(p + vec2(ROOT, -ROOT), position.w, reach),
        separation_at(p + vec2(ROOT, ROOT), position.w, reach),
    );
    return max(separation_at(p, position.w, reach), min(dot(near, vec4(0.5)), 1.0));
}

// Returns the shape of a fin as a tuft: as wide as its edge at the mesh surface, pointed at the tip. Straight sides
// would cut off strokes.
fn tuft(across: f32, height: f32) -> f32 {
    return 1.0 - smoothstep(TUFT_END.x, TUFT_END.y, abs(2.0 * across - 1.0) + TUFT_POINTED * height);
}

@fragment
fn fs_ink_fins(in: StrokeVarying) -> @location(0) vec4<f32> {
    // The tile also repeats vertically; this range avoids the seam, where roots would fade into tips.
    let row = mix(FIN_ROWS.x, FIN_ROWS.y, in.uv.y);
    let strokes = fur_strokes_at(vec2(in.uv.x, row), vec2(1.0, 0.0), 1u);
    let base = base_color(in.tint, in.base_uv);
    if is_cut(base.a) {
        discard;
    }
    let density = (FIN_DENSITY.x + FIN_DENSITY.y * model.fur) * in.share_height.x;
    let ink = ink_nested(strokes, density) * model.fur;
    let whole = tuft(in.share_height.w, in.share_height.y) * separation_from_body(in.position, in.share_height.z);
    // Strokes get drier and fainter with height, because the brush lifts towards the tip.
    let height = in.share_height.y;
    let amount = whole * smoothstep(FIN_INK.x, FIN_INK.y, ink) * min(2.0 * in.share_height.x, 1.0)
        * (FIN_OPACITY.x - FIN_OPACITY.y * height);
    return ink_on_paper(amount, FIN_DRY * height, in.position.xy);
}

@fragment
fn fs_ink_shells(in: StrokeVarying) -> @location(0) vec4<f32> {
    let strokes = fur_strokes_at(in.uv, vec2(1.0), 0u);
    let base = base_color(in.tint, in.base_uv);
    if is_cut(base.a) {
        discard;
    }
    let eye = direction_to(frame.eye_ws, in.position_ws);
    // Seen from above, the shells that make up a stroke would cover each other. Therefore, only surfaces that turn away
    // from the eye have strokes.
    let turned = 1.0 - abs(dot(normalize_or(in.normal_ws, eye), eye));
    let amount = in.share_height.x * model.fur * smoothstep(SHELLS_APPEAR.x, SHELLS_APPEAR.y, turned);
    let ink = ink_nested(strokes, amount * SHELL_DENSITY);
    // Strokes taper towards their middle line with the height of the shell.
    let height = in.share_height.y;
    let begins = SHELL_BEGINS.x + SHELL_BEGINS.y * height;
    let tapered = smoothstep(begins, SHELL_FULL.x + SHELL_FULL.y * height, ink);
    let dry = SHELL_DRY.x + SHELL_DRY.y * height;
    return ink_on_paper(tapered * amount * (SHELL_OPACITY.x - SHELL_OPACITY.y * height), dry, in.position.xy);
}
