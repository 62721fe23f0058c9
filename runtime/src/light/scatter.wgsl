// Hair as fibres that scatter light, and hand it on to each other: in the place of Kajiya-Kay's two lobes where the package has tables of its fibres.

// It has, and the frame wants them.
override SCATTERING: bool = false;
// Light goes on from hair to hair.
override MULTIPLE: bool = false;
// It hangs far from the skin that it grows from, as hair on guides does.
override HANGS: bool = false;
// Which of the package's fibres hair on guides is; the coat's hangs on the material.
override FIBRE: u32 = 0u;

@group(1) @binding(4) var fibre_tables: texture_2d_array<f32>;
@group(1) @binding(5) var<uniform> fibres: array<Fibre, 64>;

fn fibre_number() -> u32 {
    return select(material.fibre, FIBRE, HANGS);
}

// A texel between those of a layer of the fibre's tables, by its place, 0..=1.
fn fibre_texel(place: vec2<f32>, layer: u32) -> vec4<f32> {
    let size = f32(textureDimensions(fibre_tables).x);
    return textureSampleLevel(fibre_tables, map_sampler, (place * (size - 1.0) + 0.5) / size, 2u * fibre_number() + layer, 0.0);
}

// What falls on a mat below a coat of that colour, over what falls on the coat: light that comes past the fibres, of which the share `direct` does, by the
// cosine of light and skin, and light that they hand on.
fn reaches_mat(n_dot_l: f32, color: vec3<f32>, direct: f32) -> vec3<f32> {
    let straight = vec3(direct * max(n_dot_l, 0.0));
    if !MULTIPLE {
        return straight;
    }
    let number = fibre_number();
    let optics = fibres[number].optics;
    let left = fibre_left(1.0, optics, fibre_absorption(color, optics.y));
    let sides = fibre_sides(fibres[number], 1.0, left);
    let d = diffused(sides[0], sides[1], direct);
    return straight + (d.sent_on + d.from_light) * max(n_dot_l, 0.0);
}

// What a fibre of that colour, over others that are `deeper` in colour, sends to the eye of a light of colour 1, which brings an irradiance of pi. `direct`: share of the light that comes past
// other fibres, `past` that comes past all else; above: sine of the light's height above the skin, as above_rim has it. All in one frame, the fibre towards its tip.
fn scatter(direction: vec3<f32>, light: vec3<f32>, eye: vec3<f32>, color: vec3<f32>, deeper: vec3<f32>, above: f32, direct: f32, past: f32) -> vec3<f32> {
    let number = fibre_number();
    let optics = fibres[number].optics;
    let tip = direction * inverseSqrt(max(dot(direction, direction), 1e-12));
    let angles = fibre_angles(tip, light, eye);
    let absorbed = fibre_absorption(color, optics.y);
    let left = fibre_left(angles.cos_d, optics, absorbed);
    var sent = direct * fibre_scatters(fibre_texel(angles.along, 0u), fibre_texel(angles.around, 1u), absorbed, left);
    if MULTIPLE {
        // Light that went from hair to hair went through those below. The difference angle is at hand, and serves for the light's own.
        let sides = fibre_sides(fibres[number], angles.cos_i, fibre_left(angles.cos_d, optics, fibre_absorption(deeper, optics.y)));
        var met = sides;
        var cones = vec2(1.0);
        if HANGS {
            met = hanging_sides(sides);
            cones = hanging_cones(fibres[number], angles.cos_i, dot(left, vec3(1.0 / 3.0)), direct, dot(tip, light), dot(tip, eye));
        }
        let d = diffused(met[0], met[1], direct);
        // Light that comes from half of all azimuths: from the light's side, and from the other.
        let turned = angles.around.x;
        let to_here = mix(sides[1], sides[0], turned);
        let to_there = mix(sides[0], sides[1], turned);
        let spread = d.from_light * to_here + d.from_below * to_there;
        // What was sent on has kept about a quarter turn of its way.
        let straight = mix(sides[1], sides[0], smoothstep(0.15, 0.85, turned));
        // A coat gets no more of light that grazes it than falls on its skin. What was sent on is at the tips, which such light meets from the side, and the less is lost the
        // farther it goes.
        let falls = falls_in(d.root_lost, above);
        let reached = pow(falls, min(0.15 + d.root_lost, vec3(0.5)));
        sent += (cones.x * d.sent_on * straight * reached + cones.y * spread * falls) / PI;
    }
    return sent * (PI * past);
}
