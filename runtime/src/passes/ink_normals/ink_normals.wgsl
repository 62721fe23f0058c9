//! uses ink/model, ink/surface_forms, shared/frame, shared/ink, shared/skinning, surface/place
// Drawing of the input textures for the other ink passes. They hold normals in the frame perpendicular to the view, and
// wash and line parameters of the surface.

// Vertex attributes that only this pass reads.
struct InkVertex {
    // Stored position, independent of the pose; surface textures are attached to it.
    @location(9) rest_position: vec3<f32>,
    @location(10) rest_normal: vec3<f32>,
    // The two terms of the wash (formulas 5.3): half of its product, and its normalised product.
    @location(11) wash: vec2<f32>,
    // Amounts of wash, of full ink and of lines.
    @location(12) load: vec4<f32>,
}

// Software rasterisers pay for each interpolant at every triangle, so there are few.
struct InkVarying {
    @invariant @builtin(position) position: vec4<f32>,
    // World-space position; product of the wash (formulas 5.3).
    @location(0) position_product: vec4<f32>,
    // World-space normal; amount of wash.
    @location(1) normal_amount: vec4<f32>,
    // Stored position in periods of the wash tile; amount of full ink.
    @location(2) rest_position_solid: vec4<f32>,
    // Stored normal; factor on line width.
    @location(3) rest_normal_line: vec4<f32>,
    @location(4) tint: vec4<f32>,
    @location(5) base_tile_uv: vec4<f32>,
    // Share of the fur that grows, and fur height, metres.
    @location(6) fur: vec2<f32>,
}

struct Surface {
    // Face normal. The w component holds 1 / clip w, which is linear on planes; 0 for the background.
    @location(0) normal: vec4<f32>,
    // Grey of the wash, grey of the sphere map's stroke, a quarter of the factor on line width, dryness of lines.
    @location(1) surface: vec4<f32>,
}

// Whether the part has fur, and the package has strokes for it.
override FUR_STROKES: bool = false;

// Weight of a tile sample at a normal with equal components along all three axes: 1 / sqrt(3) (formulas 5.4).
const EQUALLY_NEAR: f32 = 0.5773;
// Offsets of the tile for the projections along y and along z. Without them, the projections would mirror each other.
const OFFSET_Y: f32 = 0.37;
const OFFSET_Z: f32 = 0.71;
// Displacement of the wash's edge by blotches of the tile.
const BLOTCH_SHIFT: f32 = 0.5;
// Variation of the wash's density by the grain.
const GRAIN_DENSITY: f32 = 0.7;
// Densities of the wash at which its edge begins, peaks and ends.
const EDGE_DENSITY: vec3<f32> = vec3(0.0, 0.07, 0.3);
// Density added by pigment that gathers at the edge of the wash.
const EDGE_PIGMENT: f32 = 0.07;
// Luminance weights of linear sRGB (ITU-R BT.709).
const LUMINANCE: vec3<f32> = vec3(0.2126, 0.7152, 0.0722);
// Exponent from luminance to display brightness.
const DISPLAY_EXPONENT: f32 = 1.0 / 2.2;
// Range of brightness over which the ink for dark surfaces goes from all to none.
const DARK_SURFACE: vec2<f32> = vec2(0.06, 0.42);
// Amount of ink for dark surfaces, and its variation.
const DARK_INK: vec2<f32> = vec2(0.75, 0.4);
// Density of full ink, and its variation.
const FULL_INK: vec2<f32> = vec2(0.88, 0.3);
// Density of inner fur strokes: factor on the square of the turn away from the eye, and factor on the square of the
// wash.
const FUR_DENSITY: vec2<f32> = vec2(0.45, 0.5);
// Opacity of inner fur strokes that face the eye, and its gain where the fur turns away.
const FUR_OPACITY: vec2<f32> = vec2(0.25, 0.4);
// Loss of line width beside short fur and beside long fur.
const LINE_BY_FUR: vec2<f32> = vec2(0.3, 0.75);
// Heights of fur on screen that count as short and as long, pixels.
const FUR_PX: vec2<f32> = vec2(5.0, 20.0);
// Range of the tile's pressure channel over which the brush goes from lightest to full pressure.
const PRESSURE_RANGE: vec2<f32> = vec2(0.25, 0.75);
// Loss of line width at the lightest pressure.
const PRESSURE_LOSS: f32 = 0.6;
// Range of the tile's blotch channel over which the brush goes from wet to dry.
const DRY_BLOTCHES: vec2<f32> = vec2(0.4, 0.8);
// Stored value for a line width factor of 1, as ink_features expects it.
const STORED_WIDTH: f32 = 0.25;

@vertex
fn vs_ink(v: Vertex, ink: InkVertex) -> InkVarying {
    return ink_varying(v, ink);
}

// The same for a model with bare normals.
@vertex
fn vs_ink_with_normals(v: Vertex, ink: InkVertex, @location(13) bare: vec2<f32>) -> InkVarying {
    return ink_varying(with_bare_normal(v, bare), ink);
}

fn ink_varying(v: Vertex, ink: InkVertex) -> InkVarying {
    let position = position_ws(v);
    var out: InkVarying;
    out.position = frame.clip_from_world * vec4(position, 1.0);
    out.position_product = vec4(position, mix(2.0 * ink.wash.x, ink.wash.y, model.normalised));
    out.normal_amount = vec4(normal_ws(v), ink.load.x);
    out.rest_position_solid = vec4(ink.rest_position * model.periods, ink.load.y);
    out.rest_normal_line = vec4(ink.rest_normal, ink.load.z);
    out.tint = v.color * material.base_color;
    out.base_tile_uv = vec4(v.base_uv, v.tile_uv);
    out.fur = vec2(select(0.0, 1.0 - v.groom.x, v.fur_height > 0.0), v.fur_height * instance.scale);
    return out;
}

// Samples the grain of the surface (formulas 5.4). Reads one tile twice, along the two model axes of the stored mesh
// that are nearest to the normal. The weight of a sample falls to zero where the third axis replaces its axis, so that
// no seam shows (Quilez's biplanar mapping).
fn grain_at(p: vec3<f32>, n: vec3<f32>) -> vec4<f32> {
    let m = abs(n);
    let dx = dpdx(p);
    let dy = dpdy(p);
    let without_x = m.x < min(m.y, m.z);
    let without_y = !without_x && m.y < m.z;
    let by_x = !without_x;
    let by_z = without_x || without_y;
    let first = select(vec3(p.xz + OFFSET_Y, m.y), vec3(p.zy, m.x), by_x);
    let second = select(vec3(p.xz + OFFSET_Y, m.y), vec3(p.xy + OFFSET_Z, m.z), by_z);
    let first_dx = select(dx.xz, dx.zy, by_x);
    let first_dy = select(dy.xz, dy.zy, by_x);
    let second_dx = select(dx.xz, dx.xy, by_z);
    let second_dy = select(dy.xz, dy.xy, by_z);
    let w = max(vec2(first.z, second.z) - EQUALLY_NEAR, vec2(0.0)) + 1e-4;
    let a = textureSampleGrad(wash_tile, tile_sampler, first.xy, first_dx, first_dy);
    let b = textureSampleGrad(wash_tile, tile_sampler, second.xy, second_dx, second_dy);
    return (a * w.x + b * w.y) / (w.x + w.y);
}

// Returns the frame perpendicular to the view direction at a point (formulas 5.1).
fn eye_frame(eye: vec3<f32>) -> mat3x3<f32> {
    let right = model.right_ws - eye * dot(eye, model.right_ws);
    let x = normalize_or(right, vec3(1.0, 0.0, 0.0));
    return mat3x3(x, cross(eye, x), eye);
}

@fragment
fn fs_ink(in: InkVarying, @builtin(front_facing) front: bool) -> Surface {
    let base = base_color(in.tint, in.base_tile_uv.xy);
    let on_surface = grain_at(in.rest_position_solid.xyz, normalize_or(in.rest_normal_line.xyz, vec3(0.0, 1.0, 0.0)));
    let grain = form_of_grain(on_surface, in.position.xy);
    var strokes = vec4(0.0);
    if FUR_STROKES {
        strokes = fur_strokes_at(in.base_tile_uv.zw, vec2(1.0), 0u);
    }
    let eye = direction_to(frame.eye_ws, in.position_product.xyz);
    let axes = eye_frame(eye);
    let facing = normalize_or(in.normal_amount.xyz, eye) * select(-1.0, 1.0, front);
    // A visible surface faces the eye, even if the interpolated vertex normal does not.
    var normal = facing * axes;
    normal = normalize_or(vec3(normal.xy, max(normal.z, 0.0)), vec3(0.0, 0.0, 1.0));
    let sphere_uv = form_of_sphere_uv(ink_sphere_uv(normal, model.swell), facing, eye);
    let stroke = textureSample(stroke_map, clamp_sampler, sphere_uv);
    // Lines use face normals: the bake smooths the vertex normals of furred surfaces, which would remove the creases.
    let across = cross(dpdx(in.position_product.xyz), dpdy(in.position_product.xyz));
    let face = normalize_or(across * sign(dot(across, eye)), facing) * axes;
    if is_cut(base.a) {
        discard;
    }

    // Wash (formulas 5.3). Blotches of the tile displace its edge, and pigment gathers there.
    let share = in.normal_amount.w;
    let product = ink_wash_product(in.position_product.w) + (grain.g - 0.5) * BLOTCH_SHIFT * model.grain;
    var density = 1.0 - ink_wash_grey(product, model.wash_speed, model.wash_range);
    let edge = smoothstep(EDGE_DENSITY.x, EDGE_DENSITY.y, density)
        * (1.0 - smoothstep(EDGE_DENSITY.y, EDGE_DENSITY.z, density));
    density = density * (1.0 + model.grain * GRAIN_DENSITY * (grain.r - 0.5)) + edge * EDGE_PIGMENT * model.grain;
    density = clamp(density, 0.0, 1.0) * share;
    // Dark surfaces take more ink; the darkness of the base colour is measured in display brightness.
    let light = pow(clamp(dot(base.rgb, LUMINANCE), 0.0, 1.0), DISPLAY_EXPONENT);
    let dark = model.tone * share * (1.0 - smoothstep(DARK_SURFACE.x, DARK_SURFACE.y, light))
        * (DARK_INK.x + DARK_INK.y * (grain.r - 0.5));
    density = 1.0 - (1.0 - density) * (1.0 - dark);
    // Full ink also varies, so that it is not uniformly black.
    density = max(density, in.rest_position_solid.w * (FULL_INK.x + FULL_INK.y * model.grain * (grain.r - 0.5)));

    var width = model.line * in.rest_normal_line.w;
    if FUR_STROKES {
        // Inner fur is wash; strokes appear where the fur turns away, and where the wash is heavy.
        let fur = in.fur.x * model.fur;
        let turned = 1.0 - normal.z;
        let dense = FUR_DENSITY.x * turned * turned + FUR_DENSITY.y * density * density;
        let ink = ink_nested(strokes, fur * dense) * fur;
        density = 1.0 - (1.0 - density) * (1.0 - ink * (FUR_OPACITY.x + FUR_OPACITY.y * turned));
        // Where hair strokes are long enough to be visible, they form the outline, so lines get thinner.
        let fur_px = in.fur.y * model.px_per_unit * in.position.w;
        width *= 1.0 - fur * mix(LINE_BY_FUR.x, LINE_BY_FUR.y, smoothstep(FUR_PX.x, FUR_PX.y, fur_px));
    }
    // Variation of brush pressure.
    let pressure = smoothstep(PRESSURE_RANGE.x, PRESSURE_RANGE.y, grain.b);
    width *= 1.0 - model.pressure * (1.0 - pressure) * PRESSURE_LOSS;
    let dry = smoothstep(DRY_BLOTCHES.x, DRY_BLOTCHES.y, grain.g);
    let rim = mix(stroke.r, stroke.g, dry);
    return Surface(
        vec4(face, in.position.w),
        vec4(1.0 - density, rim, clamp(width * STORED_WIDTH, 0.0, 1.0), dry),
    );
}
