//! uses ink/model, ink/surface_forms, shared/frame, shared/ink, shared/skinning, surface/place
// Input textures of the other ink passes: normals in the frame perpendicular to the view, and wash and line parameters
// of the surface.

// Vertex attributes that only this pass reads.
struct InkVertex {
    // Stored position, before any pose; surface textures are attached to it.
    @location(9) rest_position: vec3<f32>,
    @location(10) rest_normal: vec3<f32>,
    // Halved product and normalised product of the wash.
    @location(11) wash: vec2<f32>,
    // Amounts of wash, full ink and lines.
    @location(12) load: vec4<f32>,
}

// Few interpolants: software rasterisers pay for each at every triangle.
struct InkVarying {
    @invariant @builtin(position) position: vec4<f32>,
    // World-space position; product of the wash.
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
    // Face normal, and 1 / clip w, which is linear on planes; 0 for the background.
    @location(0) normal: vec4<f32>,
    // Grey of the wash, grey of the sphere map's stroke, a quarter of the factor on line width, dryness of lines.
    @location(1) surface: vec4<f32>,
}

// The part has fur, and the package has strokes for it.
override FUR_STROKES: bool = false;

@vertex
fn vs_ink(v: Vertex, ink: InkVertex) -> InkVarying {
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

// Samples the grain of the surface: two reads of one tile, along the two stored model axes nearest to the normal. The
// weight of a read falls to zero where the third axis takes over, so that no seam shows (Quilez's biplanar mapping).
fn grain_at(p: vec3<f32>, n: vec3<f32>) -> vec4<f32> {
    let m = abs(n);
    let dx = dpdx(p);
    let dy = dpdy(p);
    let without_x = m.x < min(m.y, m.z);
    let without_y = !without_x && m.y < m.z;
    let by_x = !without_x;
    let by_z = without_x || without_y;
    // Offsets within the tile, so that the projections do not mirror each other.
    let first = select(vec3(p.xz + 0.37, m.y), vec3(p.zy, m.x), by_x);
    let second = select(vec3(p.xz + 0.37, m.y), vec3(p.xy + 0.71, m.z), by_z);
    let first_dx = select(dx.xz, dx.zy, by_x);
    let first_dy = select(dy.xz, dy.zy, by_x);
    let second_dx = select(dx.xz, dx.xy, by_z);
    let second_dy = select(dy.xz, dy.xy, by_z);
    // 0 where all three axes are equally near.
    let w = max(vec2(first.z, second.z) - 0.5773, vec2(0.0)) + 1e-4;
    let a = textureSampleGrad(wash_tile, tile_sampler, first.xy, first_dx, first_dy);
    let b = textureSampleGrad(wash_tile, tile_sampler, second.xy, second_dx, second_dy);
    return (a * w.x + b * w.y) / (w.x + w.y);
}

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
    // A visible surface faces the eye, whatever the vertex normals say.
    var normal = facing * axes;
    normal = normalize_or(vec3(normal.xy, max(normal.z, 0.0)), vec3(0.0, 0.0, 1.0));
    let sphere_uv = form_of_sphere_uv(ink_sphere_uv(normal, model.swell), facing, eye);
    let stroke = textureSample(stroke_map, clamp_sampler, sphere_uv);
    // Lines follow face normals: the bake smooths the vertex normals of furred surfaces, which would remove the
    // creases.
    let across = cross(dpdx(in.position_product.xyz), dpdy(in.position_product.xyz));
    let face = normalize_or(across * sign(dot(across, eye)), facing) * axes;
    if is_cut(base.a) {
        discard;
    }

    // Wash. Blotches of the tile displace its edge, and pigment gathers there.
    let share = in.normal_amount.w;
    let product = ink_wash_product(in.position_product.w) + (grain.g - 0.5) * 0.5 * model.grain;
    var density = 1.0 - ink_wash_grey(product, model.wash_speed, model.wash_range);
    let edge = smoothstep(0.0, 0.07, density) * (1.0 - smoothstep(0.07, 0.3, density));
    density = density * (1.0 + model.grain * 0.7 * (grain.r - 0.5)) + edge * 0.07 * model.grain;
    density = clamp(density, 0.0, 1.0) * share;
    // Dark surfaces take more ink; darkness of the base colour is measured as displayed.
    let light = pow(clamp(dot(base.rgb, vec3(0.2126, 0.7152, 0.0722)), 0.0, 1.0), 1.0 / 2.2);
    let dark = model.tone * share * (1.0 - smoothstep(0.06, 0.42, light)) * (0.75 + 0.4 * (grain.r - 0.5));
    density = 1.0 - (1.0 - density) * (1.0 - dark);
    // Full ink is not uniformly black either.
    density = max(density, in.rest_position_solid.w * (0.88 + 0.3 * model.grain * (grain.r - 0.5)));

    var width = model.line * in.rest_normal_line.w;
    if FUR_STROKES {
        // Inner fur is wash; strokes appear where the fur turns away, and where the wash is heavy.
        let fur = in.fur.x * model.fur;
        let turned = 1.0 - normal.z;
        let ink = ink_nested(strokes, fur * (0.45 * turned * turned + 0.5 * density * density)) * fur;
        density = 1.0 - (1.0 - density) * (1.0 - ink * (0.25 + 0.4 * turned));
        // Where hair strokes are long enough to be visible, they form the outline, and lines get thinner.
        let fur_px = in.fur.y * model.px_per_unit * in.position.w;
        width *= 1.0 - fur * mix(0.3, 0.75, smoothstep(5.0, 20.0, fur_px));
    }
    // Variation of brush pressure.
    let pressure = smoothstep(0.25, 0.75, grain.b);
    width *= 1.0 - model.pressure * (1.0 - pressure) * 0.6;
    let dry = smoothstep(0.4, 0.8, grain.g);
    let rim = mix(stroke.r, stroke.g, dry);
    return Surface(
        vec4(face, in.position.w),
        vec4(1.0 - density, rim, clamp(width * 0.25, 0.0, 1.0), dry),
    );
}
