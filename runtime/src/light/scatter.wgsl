//! uses light/visibility, shared/scattering, surface/place
// Multiple scattering between hair fibres (formulas 4.12, 4.13). Replaces the two lobes of Kajiya-Kay if the package
// has tables for its fibres.

// Whether the package has fibre tables, and the frame uses them.
override SCATTERING: bool = false;
// Whether light is scattered from hair to hair.
override MULTIPLE: bool = false;
// Whether the hair hangs far from the surface at its root, as guided hair does.
override HANGS: bool = false;
// Index of the package's fibre for guided hair. For fur, the index is in the material.
override FIBRE: u32 = 0u;

@group(1) @binding(4) var fibre_tables: texture_2d_array<f32>;
@group(1) @binding(5) var<uniform> fibres: array<Fibre, 64>;

// Returns the index of the hair's fibre in the package.
fn fibre_number() -> u32 {
    return select(material.fibre, FIBRE, HANGS);
}

// Samples a layer of the fibre tables with interpolation, at coordinates 0..=1.
fn fibre_texel(place: vec2<f32>, layer: u32) -> vec4<f32> {
    let size = f32(textureDimensions(fibre_tables).x);
    let uv = (place * (size - 1.0) + 0.5) / size;
    return textureSampleLevel(fibre_tables, map_sampler, uv, 2u * fibre_number() + layer, 0.0);
}

// Returns the light that reaches a mat below hair of that colour, relative to the light on the hair (formulas 4.13).
// The result has two parts. One is the share `direct` that the fibres let through, times the cosine at the surface. The
// other is the light scattered forward by fibres.
fn reaches_mat(n_dot_l: f32, color: vec3<f32>, direct: f32) -> vec3<f32> {
    let straight = vec3(direct * max(n_dot_l, 0.0));
    if !MULTIPLE {
        return straight;
    }
    let number = fibre_number();
    let optics = fibres[number].optics;
    let left = fibre_transmittance(1.0, optics, fibre_absorption(color, optics.y));
    let sides = absorbing_fibre_shares(fibres[number], 1.0, left);
    let d = diffused(deep_fur(sides[0], sides[1]), direct);
    return straight + (d.sent_on + d.from_light) * max(n_dot_l, 0.0);
}

// Returns the light in deep fur at a point that the share `direct` of the light reaches past all fibres. The depth of
// hanging hair is measured, and needs no minimum.
fn diffused(fur: DeepFur, direct: f32) -> DiffusedLight {
    return diffused_light(fur, direct, select(LEAST_BAKED, LEAST_DIRECT, HANGS));
}

// Mean cosines of the difference angle and of the inclination at which the hair below scatters light (formulas 4.13).
const DEEP_COS_D: f32 = 0.87;
const DEEP_COS_I: f32 = 0.8;

// Fibre at a point and the hair below it. Both are the same for all lights.
struct Coat {
    // Absorption of the fibre per radius.
    absorbed: vec3<f32>,
    // Shares that the hair below scatters forward and backward.
    on: vec3<f32>,
    back: vec3<f32>,
    below: DeepFur,
}

// Returns the fibre of hair with the colour `color`, and the hair below it with the colour `deeper`.
fn coat_of(color: vec3<f32>, deeper: vec3<f32>) -> Coat {
    let number = fibre_number();
    let optics = fibres[number].optics;
    var out: Coat;
    out.absorbed = fibre_absorption(color, optics.y);
    if MULTIPLE {
        let left = fibre_transmittance(DEEP_COS_D, optics, fibre_absorption(deeper, optics.y));
        let sides = absorbing_fibre_shares(fibres[number], DEEP_COS_I, left);
        out.on = sides[0];
        out.back = sides[1];
        var met = sides;
        if HANGS {
            met = hanging_sheet_shares(sides);
        }
        out.below = deep_fur(met[0], met[1]);
    }
    return out;
}

// Range of azimuths phi / pi in which forward-scattered light changes from the far side to the light's side (formulas
// 4.13).
const SENT_ON_TURN: vec2<f32> = vec2(0.15, 0.85);
// Exponent of F for forward-scattered light: gamma plus the first value, at most the second (formulas 4.13).
const SENT_ON_FALLS: vec2<f32> = vec2(0.15, 0.5);

// Loss of direction of light along the fibres per scattering (formulas 4.13).
const TURNS: f32 = 0.1;

// Returns the multiply scattered light towards the eye, relative to its mean over all directions above the surface
// (formulas 4.13). Fibres keep light on its cone: light that entered the coat towards the roots leaves towards the
// roots. Each scattering by fibres that are not parallel widens the cone; the less the fibres absorb, the more often
// light is scattered.
//
// `sin_i`: mean sine between the fibre and the directions of the incident light; `sin_o`: sine towards the eye; `up`:
// sine between the fibre and the surface.
fn along_coat(sin_i: f32, sin_o: f32, up: f32, root_lost: vec3<f32>) -> vec3<f32> {
    let directed = 3.0 * sin_i * exp(-TURNS * (1.0 + 1.0 / root_lost));
    // Mean of the sine over the directions above the surface, weighted by their cosine.
    let mean = up / 1.5;
    return 1.0 - tanh(directed * (sin_o - mean));
}

// Light that a fibre sends to the eye.
struct Scattered {
    // Light that no other fibre has scattered.
    once: vec3<f32>,
    // Light that other fibres have scattered before.
    often: vec3<f32>,
}

// Returns the light that a fibre of the coat sends to the eye (formulas 4.12, 4.13). The light has the colour 1,
// which gives an irradiance of pi. All directions are in the tile frame; `direction` is that of the fibre, towards its
// tip.
//
// `direct`: share of the light that other fibres let through; `above`: sine of the light's height above the surface, as
// returned by above_rim.
fn scatter(
    direction: vec3<f32>,
    light: vec3<f32>,
    eye: vec3<f32>,
    coat: Coat,
    above: f32,
    direct: f32,
) -> Scattered {
    let number = fibre_number();
    let optics = fibres[number].optics;
    let tip = direction * inverseSqrt(max(dot(direction, direction), 1e-12));
    let angles = fibre_angles(tip, light, eye);
    let absorbed = coat.absorbed;
    let left = fibre_transmittance(angles.cos_d, optics, absorbed);
    var out: Scattered;
    out.once = fibre_scatters(fibre_texel(angles.along, 0u), fibre_texel(angles.around, 1u), absorbed, left);
    out.once *= PI * direct;
    if MULTIPLE {
        var cones = vec2(1.0);
        if HANGS {
            let grey = dot(left, vec3(1.0 / 3.0));
            cones = hanging_cones(fibres[number], angles.cos_i, grey, direct, dot(tip, light), dot(tip, eye));
        }
        let d = diffused(coat.below, direct);
        // Diffuse light arrives from two halves of all azimuths: the light's side and the opposite side.
        let turned = angles.around.x;
        let to_here = mix(coat.back, coat.on, turned);
        let to_there = mix(coat.on, coat.back, turned);
        let spread = d.from_light * to_here + d.from_below * to_there;
        // Forward-scattered light stays within about a quarter turn of its direction.
        let straight = mix(coat.back, coat.on, smoothstep(SENT_ON_TURN.x, SENT_ON_TURN.y, turned));
        // Fur receives no more grazing light than its surface does. Forward-scattered light decreases less with the
        // elevation, because it is at the tips, which grazing light meets from the side. The farther it travels, the
        // less it decreases.
        let falls = multiple_scattering_by_height(coat.below.root_lost, above);
        let reached = pow(falls, min(SENT_ON_FALLS.x + coat.below.root_lost, vec3(SENT_ON_FALLS.y)));
        out.often = cones.x * d.sent_on * straight * reached + cones.y * spread * falls;
        if !HANGS {
            out.often *= along_coat(dot(tip, light), dot(tip, eye), tip.z, coat.below.root_lost);
        }
    }
    return out;
}
