//! uses light/baked, light/fibre, light/fills, light/gloss, light/point, light/scatter, light/visibility,
//! shared/environment, shared/frame, shared/kajiya_kay, shared/scattering, shared/skinning, shared/tile_frame,
//! shared/visibility, surface/place
// Light from an environment map (formulas 4.15). The environment is divided into a few parts. The light of each part
// from above the surface's horizon is treated as one light that is spread about its mean direction.

@group(0) @binding(6) var environment_map: texture_2d_array<f32>;
@group(0) @binding(7) var broad_tables: texture_2d_array<f32>;

// Whether the frame has an environment map.
override ENVIRONMENT: bool = false;
// Index of the first broad-light table for this package's fibres.
override BROAD_FIRST: u32 = 0u;
// Whether the key light is black; then only its direction is used.
override DARK_KEY: bool = false;

// Size of the broad-light tables, texels (formulas 4.15): mean cosine, angle to the eye, angle of the light, azimuth.
const BROAD_MEANS: f32 = 8.0;
const BROAD_TO: f32 = 24.0;
const BROAD_FROM: f32 = 24.0;
const BROAD_PHI: f32 = 16.0;

// Light of a part of the environment at a point of a surface.
struct Around {
    // Total light from above the horizon of the surface.
    whole: vec3<f32>,
    // Irradiance divided by pi.
    irradiance: vec3<f32>,
    // Mean direction of the light in the tile frame. The shorter the vector, the wider the light is spread.
    towards: vec3<f32>,
}

// Samples a layer of the environment map.
fn environment_texel(place: vec2<f32>, layer: u32) -> vec3<f32> {
    return textureSampleLevel(environment_map, map_sampler, place, layer, 0.0).rgb;
}

// Minimum open share of a body, relative to that of most bodies.
const LEAST_OPEN: f32 = 0.02;
// Minimum length of a mean light direction.
const LEAST_LONG: f32 = 0.05;

// Number of layers of the environment map per part of the environment: total light, mean direction, and irradiance
// divided by pi.
const LAYERS_OF_PART: u32 = 3u;

// Returns the number of parts of the environment.
fn environment_parts() -> u32 {
    return textureNumLayers(environment_map) / LAYERS_OF_PART;
}

// Openness of a body at a point, which is the same for all parts of the environment.
struct Openness {
    // Texture coordinates in the environment map.
    place: vec2<f32>,
    // Middle of the open directions, in the tile frame.
    middle: vec3<f32>,
    // Open share of all directions, relative to that of most bodies.
    share: f32,
    // Sine of the angle below the horizon up to which light reaches the tips of the hair.
    rim: f32,
}

// Returns the openness of a body at a point (formulas 4.15).
fn openness_at(spot: Spot, tile: TileFrame) -> Openness {
    let open = max(length(spot.open), 1e-6);
    let middle = spot.open / open;
    let facing = tile.tangent_ws * middle.x + tile.bitangent_ws * middle.y + tile.normal_ws * middle.z;
    let share = clamp(open, LEAST_OPEN, 1.0 / USUALLY_OPEN);
    return Openness(environment_place(facing), middle, share, rim_at(spot.open));
}

// Light of a part of the environment at a point, before the body hides it.
struct PartLight {
    // Mean direction in the tile frame. The shorter the vector, the wider the light is spread.
    towards: vec3<f32>,
    // Total light from above the horizon of the surface.
    whole: vec3<f32>,
    // Irradiance divided by pi.
    irradiance: vec3<f32>,
    // Share that the body leaves open, relative to most bodies.
    share: f32,
}

// Returns the light of a part of the environment at a point (formulas 4.15).
fn part_light(at: Openness, tile: TileFrame, part: u32) -> PartLight {
    let first = LAYERS_OF_PART * part;
    var towards = to_tile(tile, environment_texel(at.place, first + 1u));
    // The body hides directions far from the middle of the open ones first: heights are spread evenly over a range of
    // 1 + BELOW about the mean.
    let raised = (dot(towards, at.middle) - LEAST_MEAN) / (1.0 + BELOW);
    let share = clamp((at.share + raised) / (1.0 + min(raised, 0.0)), 0.0, max(at.share, 1.0));
    // The smaller the open share, the narrower the spread of the light.
    let long = max(length(towards), 1e-6);
    towards *= max(1.0 - at.share * (1.0 - long), LEAST_LONG) / long;
    // Bodies that are more open than most receive more spread light from below the horizon.
    let more = mix(max(share, 1.0), 1.0, min(long, 1.0));
    let irradiance = environment_texel(at.place, first + 2u);
    return PartLight(towards, environment_texel(at.place, first) * more, irradiance, share);
}

// Returns that light at a point on a body of that colour (formulas 4.15).
fn around_at(light: PartLight, color: vec3<f32>) -> Around {
    // The surface receives no light from below its horizon. A body occludes low directions first, which contribute
    // least: the contribution of an open cone is the square of its sine.
    let below = max(1.0 - 2.0 * USUALLY_OPEN * light.share, 0.0);
    return Around(
        light.whole * environment_share(color, max(1.0 - light.share, 0.0)),
        light.irradiance * environment_share(color, below * below),
        light.towards,
    );
}

// Maximum number of parts of an environment.
const MOST_PARTS: u32 = 2u;

// Light of an environment at a point, which changes slowly over a surface.
struct Sky {
    parts: array<PartLight, MOST_PARTS>,
    // Sine of the angle below the horizon up to which light reaches the tips of the hair.
    rim: f32,
    // Direction towards the eye in the tile frame.
    eye: vec3<f32>,
}

// Returns the light of the environment at a point.
fn sky_at(spot: Spot, tile: TileFrame) -> Sky {
    var sky: Sky;
    if !ENVIRONMENT {
        return sky;
    }
    let at = openness_at(spot, tile);
    for (var part = 0u; part < min(environment_parts(), MOST_PARTS); part++) {
        sky.parts[part] = part_light(at, tile, part);
    }
    sky.rim = at.rim;
    sky.eye = to_tile(tile, direction_to(frame.eye_ws, spot.position_ws));
    return sky;
}

// Returns the irradiance of all parts of the environment, divided by pi. `place`: coordinates in the environment map.
fn irradiance_of_parts(place: vec2<f32>) -> vec3<f32> {
    var sum = vec3(0.0);
    for (var part = 0u; part < environment_parts(); part++) {
        sum += environment_texel(place, LAYERS_OF_PART * part + 2u);
    }
    return sum;
}

// Returns the texture coordinates in the environment map for a surface that faces `facing`.
fn environment_place(facing: vec3<f32>) -> vec2<f32> {
    let size = f32(textureDimensions(environment_map).x);
    return ((0.5 + 0.5 * octahedral(facing)) * (size - 1.0) + 0.5) / size;
}

// Returns the effective height (sine) of light above the surface, z' of formulas 4.15. `dip`: sine of the angle below
// the horizon up to which light reaches the point.
//
// The surface curves away below the light's path. With hair depth d and body radius R, the path through hair is R
// (sqrt(z^2 + 2 d / R) - z). Over a plane, light of the returned height has the same path.
fn over_curve(height: f32, dip: f32) -> f32 {
    return 0.5 * (height + sqrt(height * height + dip * dip));
}

// Sine of the angle below the horizon up to which light reaches the tips of the hair, relative to that at half their
// height (formulas 4.15).
const RIM_OF_HALF: f32 = 1.41;
// Range of that sine at the tips.
const LEAST_RIM: f32 = 0.05;
const MOST_RIM: f32 = 0.7;

// Returns the sine of the angle below the horizon up to which light reaches the tips of the hair (formulas 4.15).
// `open`: openness of the body at the point. The sine of the whole body stands for one that is unknown.
fn rim_at(open: vec3<f32>) -> f32 {
    let share = length(open);
    if abs(share - 1.0) < 1e-4 {
        return material.rim;
    }
    return clamp(RIM_OF_HALF * (2.0 * USUALLY_OPEN * share - 1.0), LEAST_RIM, MOST_RIM);
}

// Returns the share of light with this mean direction that other strands let through (formulas 4.9, 4.15). The share is
// linear in the direction, so the share of the mean direction is the mean of the shares. `rim`: sine of the angle below
// the horizon up to which light reaches the tips.
fn visible_past_strands_around(b: Baked, towards_ts: vec3<f32>, rim: f32) -> f32 {
    if !BAKED_SHADOW {
        return 1.0;
    }
    var towards = towards_ts;
    if SHORT || LEAN {
        let way = normalize_or(towards, vec3(0.0, 0.0, 1.0));
        towards = light_in_tile(way, select(1.0, b.length, SHORT), b.slope) * length(towards);
    }
    towards.z = over_curve(towards.z, rim * b.texel.w);
    let t = visibility_towards(b.texel, towards, material.horizon);
    return b.within * (1.0 - b.kept * (1.0 - t));
}

// Mean of |z| of light that is spread evenly above the angle of BELOW, relative to the root of the mean of z squared.
const ABSOLUTE_MEAN: f32 = 0.83;

// Returns the mean height of spread light above the surface, weighted by the light's irradiance on the surface
// (formulas 4.15).
fn flux_height(towards: vec3<f32>) -> f32 {
    let long = length(towards);
    let square = mean_square(clamp(long, LEAST_MEAN, 1.0), towards.z / long);
    let risen = 0.5 * (towards.z + ABSOLUTE_MEAN * sqrt(square));
    return min(square / max(risen, 1e-3), 1.0);
}

// Directions of the light that one lobe of a fibre sends to the eye, in the tile frame: a cone about the fibre.
struct Cone {
    // Component along the fibre.
    along: vec3<f32>,
    // Component across the fibre, of the direction that sends most.
    ahead: vec3<f32>,
    // Mean cosine of the azimuth from there.
    mean: f32,
}

// Returns the share of the light of a cone that other strands let through (formulas 4.15). Part of a cone is often
// below the horizon, so that the share of its mean direction is not the mean share. The light arrives from the azimuth
// that sends most and from the opposite one, with the weights that keep its mean direction.
fn visible_on_cone(b: Baked, cone: Cone, rim: f32) -> f32 {
    let front = visible_past_strands_around(b, cone.along + cone.ahead, rim);
    let rear = visible_past_strands_around(b, cone.along - cone.ahead, rim);
    return mix(rear, front, 0.5 + 0.5 * cone.mean);
}

// Directions towards a light and towards the eye at a fibre.
struct AtFibre {
    // Sines of the angles from the perpendicular plane of the fibre to light and eye.
    sin_j: f32,
    sin_o: f32,
    // Cosine of that angle to the light.
    cos_j: f32,
    // Unit vectors across the fibre, towards light and eye.
    to_light: vec3<f32>,
    to_eye: vec3<f32>,
}

// Returns the directions at a fibre. All vectors are in the tile frame, with a length of 1.
fn at_fibre(tip: vec3<f32>, light: vec3<f32>, eye: vec3<f32>) -> AtFibre {
    let sin_j = clamp(dot(tip, light), -1.0, 1.0);
    let sin_o = clamp(dot(tip, eye), -1.0, 1.0);
    let cos_j = sqrt(1.0 - sin_j * sin_j);
    let to_eye = (eye - sin_o * tip) * inverseSqrt(max(1.0 - sin_o * sin_o, 1e-8));
    return AtFibre(sin_j, sin_o, cos_j, (light - sin_j * tip) / max(cos_j, 1e-4), to_eye);
}

// Fit of sin(x) / x relative to cos(x / 2), by powers of cos(x), with an error below 0.007 (formulas 4.15).
const SINC_FIT: vec3<f32> = vec3(0.8994, 0.1339, -0.0371);

// Returns the directions of the light that one lobe of a fibre sends to the eye, whose mean is d_p of formulas 4.15.
//
// `variance`: variance of the lobe along the fibre. `about_eye`: concentration of the lobe around the fibre, a von
// Mises distribution. The distribution is centred on the eye if the value is positive, and on the opposite side if it
// is negative.
fn lit_from(tip: vec3<f32>, at: AtFibre, concentration: f32, variance: f32, about_eye: f32) -> Cone {
    // Along the fibre, the lobe and the light are nearly Gaussian, and so is their product.
    let wide = concentration * variance;
    let sine = (at.sin_j * wide - at.sin_o) / (1.0 + wide);
    let cosine = sqrt(max(1.0 - sine * sine, 0.0));
    let across = max(cosine * at.cos_j, 1e-4);
    // Light arrives only from the hemisphere about its mean direction, and from slightly below that hemisphere's
    // horizon.
    let end = clamp(-(sine * at.sin_j + BELOW) / across, -1.0, 1.0);
    let mean = sqrt(0.5 + 0.5 * end) * (SINC_FIT.x + end * (SINC_FIT.y + end * SINC_FIT.z));
    let ahead = max(mean, mean_cosine_around(concentration * across));
    let narrow = ahead * (2.0 - ahead * ahead) / max(1.0 - ahead * ahead, 1e-3);
    let aside = narrow * at.to_light + about_eye * at.to_eye;
    let both = max(length(aside), 1e-4);
    return Cone(sine * tip, cosine * aside / both, mean_cosine_around(both));
}

// Returns the concentration kappa of light with this mean cosine (formulas 4.15).
fn broad_concentration(mean: f32) -> f32 {
    return 1.0 / max(broad_variance(mean), 1e-2);
}

// Variance of the angle along the fibre of the light that Kajiya-Kay's diffuse term collects: that of cos^3.
const DIFFUSE_VARIANCE: f32 = 0.24;

// Returns the share of the light that other strands let through, for Kajiya-Kay's diffuse term (formulas 4.15), which
// collects light from all azimuths around the fibre equally.
fn visible_to_diffuse(b: Baked, direction: vec3<f32>, towards: vec3<f32>, rim: f32) -> f32 {
    let tip = direction * inverseSqrt(max(dot(direction, direction), 1e-12));
    let long = length(towards);
    let at = at_fibre(tip, towards / long, vec3(0.0));
    return visible_on_cone(b, lit_from(tip, at, broad_concentration(long), DIFFUSE_VARIANCE, 0.0), rim);
}

// Samples the broad-light tables with interpolation (formulas 4.14, 4.15): R, TT, all internal reflections, and the
// path length of TT inside the fibre.
fn broad_texel(mean: f32, sin_i: f32, sin_o: f32, phi: f32) -> vec4<f32> {
    let size = vec2(BROAD_MEANS * BROAD_FROM, BROAD_TO * BROAD_PHI);
    let within = vec2(asin(sin_i) / PI + 0.5, phi) * vec2(BROAD_FROM - 1.0, BROAD_PHI - 1.0) + 0.5;
    let m = broad_coordinate(mean) * (BROAD_MEANS - 1.0);
    let o = (asin(sin_o) / PI + 0.5) * (BROAD_TO - 1.0);
    let picture = vec2(min(floor(m), BROAD_MEANS - 2.0), min(floor(o), BROAD_TO - 2.0));
    let share = vec2(m, o) - picture;
    let step = vec2(BROAD_FROM, BROAD_PHI);
    let place = (picture * step + within) / size;
    let next = step / size;
    let layer = BROAD_FIRST + fibre_number();
    let a = textureSampleLevel(broad_tables, map_sampler, place, layer, 0.0);
    let b = textureSampleLevel(broad_tables, map_sampler, place + vec2(next.x, 0.0), layer, 0.0);
    let c = textureSampleLevel(broad_tables, map_sampler, place + vec2(0.0, next.y), layer, 0.0);
    let d = textureSampleLevel(broad_tables, map_sampler, place + next, layer, 0.0);
    return mix(mix(a, b, share.x), mix(c, d, share.x), share.y);
}

// Concentration kappa_p around the fibre for the paths R and TRT, which are centred on the eye (formulas 4.15).
const REFLECTED_ABOUT: f32 = 0.7;
// Variance along the fibre of the paths R and TRT together, relative to that of R; theirs are 1 and 4 (formulas 4.15).
const REFLECTED_VARIANCE: f32 = 2.0;
// Concentration kappa_p around the fibre for the path TT, which is centred on the opposite side (formulas 4.15).
const THROUGH_ABOUT: f32 = -3.0;

// Mean cosines A_p towards the eye around the fibre (formulas 4.15), for R, TT, TRT and the rest.
const LEANS_TO_EYE: vec4<f32> = vec4(0.33, -0.85, 0.33, 0.0);

// Returns the light that a fibre sends to the eye, for uniform light from two half-spaces: above the surface, then
// below it (formulas 4.15). Directions are in the tile frame.
//
// Light that leaves along a fibre has entered along it from the other end. For upright hair, that end is below.
fn sent_of_halves(fibre: Fibre, tip: vec3<f32>, eye: vec3<f32>, sin_o: f32, left: vec3<f32>) -> array<vec3<f32>, 2> {
    // Share of light from above, for a directional density linear in z: 1/2 plus 3/4 of the mean z.
    let risen = -sin_o * tip.z + LEANS_TO_EYE * (eye.z - sin_o * tip.z);
    let above = clamp(0.5 + 0.75 * risen, vec4(0.0), vec4(1.0));
    let shares = fibre_shares(fibre, sqrt(max(1.0 - sin_o * sin_o, 0.0)));
    let all = max(shares[0] + shares[1], vec4(0.0));
    let here = all * above;
    let there = all - here;
    return array(
        vec3(here.x) + left * (vec3(here.y) + left * (vec3(here.z) + here.w * left)),
        vec3(there.x) + left * (vec3(there.y) + left * (vec3(there.z) + there.w * left)),
    );
}

// Returns the light that a fibre of that colour sends to the eye from environment light (formulas 4.15). `deeper`:
// colour of the hair below; `direct`: share of the light that other fibres let through; `rim`: as returned by rim_at.
// Directions are in the tile frame.
fn scatter_around(
    direction: vec3<f32>,
    around: Around,
    eye: vec3<f32>,
    coat: Coat,
    direct: f32,
    baked: Baked,
    rim: f32,
) -> Scattered {
    let number = fibre_number();
    let optics = fibres[number].optics;
    let tip = direction * inverseSqrt(max(dot(direction, direction), 1e-12));
    let long = length(around.towards);
    let light = around.towards / long;
    // Uniform light is the widest distribution; light from two opposite sides is treated as uniform.
    let mean = clamp(long, LEAST_MEAN, 1.0);
    let at = at_fibre(tip, light, eye);
    let sin_j = at.sin_j;
    let sin_o = at.sin_o;
    let cos_o = sqrt(1.0 - sin_o * sin_o);
    let phi = acos(clamp(dot(at.to_light, at.to_eye), -1.0, 1.0)) / PI;
    // Mean cosine of the light's inclination.
    let cos_i = sqrt(max(1.0 - mean_square(mean, sin_j), 0.0));
    // Mean cosine of the difference angle.
    let cos_d = sqrt(clamp(0.5 * (1.0 + cos_i * cos_o + mean * sin_j * sin_o), 0.0, 1.0));
    let absorbed = coat.absorbed;
    let left = fibre_transmittance(cos_d, optics, absorbed);
    let texel = broad_texel(mean, sin_j, sin_o, phi);
    let first_on = fibres[number].on[0];
    let first_back = fibres[number].back[0];
    let often = (first_on.w + first_back.w) / max(first_on.z + first_back.z + first_on.w + first_back.w, 1e-6);
    let within = left * left * texel.z * (1.0 - often + often * left);
    // Visibility for each lobe of the fibre, in the directions from which the lobe collects light.
    var visible = vec3(direct);
    if BAKED_SHADOW && !HANGS {
        let concentration = broad_concentration(mean);
        let reflected = lit_from(tip, at, concentration, REFLECTED_VARIANCE * optics.w, REFLECTED_ABOUT);
        let through = lit_from(tip, at, concentration, LOBE_VARIANCE.y * optics.w, THROUGH_ABOUT);
        visible = vec3(visible_on_cone(baked, reflected, rim));
        visible.y = visible_on_cone(baked, through, rim);
    }
    var out: Scattered;
    out.once = around.whole
        * (vec3(texel.x * visible.x) + texel.y * visible.y * exp(-absorbed * texel.w) + visible.z * within);
    if MULTIPLE {
        let reaches = dot(texel.xyz, visible) / max(texel.x + texel.y + texel.z, 1e-6);
        let d = diffused(coat.below, direct);
        // Light from directions that the fibre's lobes do not collect is scattered by other strands, with the
        // reflectance of deep fur.
        let sent_on = d.sent_on + max(direct - reaches, 0.0) * d.from_below;
        let halves = sent_of_halves(fibres[number], tip, eye, sin_o, left);
        let to_here = halves[0];
        let to_there = halves[1];
        // Same as multiple_scattering_by_height, but divided by the sine, which the irradiance already includes.
        let root = 2.0 * coat.below.root_lost;
        let falls = (1.0 + root) / (1.0 + flux_height(around.towards) * root);
        let returned = d.from_light * to_here + d.from_below * to_there;
        var spread = sent_on * to_here + returned * falls;
        if !HANGS {
            spread *= along_coat(dot(tip, around.towards), sin_o, tip.z, coat.below.root_lost);
        }
        out.often = around.irradiance * spread;
    }
    return out;
}

// Returns the terms of eq. (1) for environment light (formulas 4.1, 4.15). The sines are means over the light's
// directions, and the highlight is widened accordingly.
fn fibre_around(direction: vec3<f32>, towards: vec3<f32>, eye: vec3<f32>, wetness: f32) -> vec2<f32> {
    let tip = direction * inverseSqrt(max(dot(direction, direction), 1e-12));
    let long = length(towards);
    let light = towards / long;
    let mean = clamp(long, LEAST_MEAN, 1.0);
    var diffuse = max(1.0 - mean_square(mean, dot(tip, light)), 0.0);
    if !SQUARED_DIFFUSE {
        diffuse = pow(diffuse, instance.diffuse_half_exponent);
    }
    if !SPECULAR {
        return vec2(diffuse, 0.0);
    }
    let dry_or_wet = highlight(wetness);
    // The half vector H turns by half the light's angle.
    let wider = 1.0 / (1.0 + 0.5 * dry_or_wet.y * broad_variance(mean));
    let lobe = pow(max(sin_squared(tip, half_vector(light, eye)), 1e-12), dry_or_wet.y * wider);
    return vec2(diffuse, dry_or_wet.x * sqrt(wider) * lobe);
}

// Share of ambient light that reaches visible points of hanging hair past other strands (formulas 4.15).
const SEEN_HANGING: f32 = 0.2;
// Additional path of diffuse light through a layer, relative to the perpendicular path: diffusivity factor 1.66 minus 1
// (formulas 4.15).
const DIFFUSE_PATH: f32 = 0.66;

// Returns the light that hair sends to the eye from the environment (formulas 4.15).
fn environment_on_hair(p: HairPoint, coat: Coat) -> vec3<f32> {
    let full = p.color * p.tint / max(p.opacity, 1e-6);
    var sky = p.sky;
    var sum = vec3(0.0);
    for (var part = 0u; part < MOST_PARTS; part++) {
        let around = around_at(sky.parts[part], full);
        if any(around.whole > vec3(0.0)) {
            sum += part_on_hair(p, around, full, coat);
        }
    }
    return sum;
}

// Returns the light of a part of the environment that hair sends to the eye (formulas 4.15). `full`: tinted colour of
// the hair, not premultiplied.
fn part_on_hair(p: HairPoint, around: Around, full: vec3<f32>, coat: Coat) -> vec3<f32> {
    let eye = p.sky.eye;
    let rim = p.sky.rim;
    var direct = visible_past_strands_around(p.baked, around.towards, material.rim);
    if BAKED_SHADOW && !HANGS && !SCATTERING {
        direct = visible_to_diffuse(p.baked, p.direction, around.towards, rim);
    }
    if (HANGS && DEEP_SHADOW) || (!BAKED_SHADOW && (DEEP_SHADOW || SELF_SHADOW)) {
        // The depth of a point in hanging hair is known only in the direction of the key light. Diffuse light crosses
        // the hair at a slant.
        let long = length(around.towards);
        let spread = (1.0 - clamp(long, LEAST_MEAN, 1.0)) / (1.0 - LEAST_MEAN);
        direct = pow(p.arriving.visible, 1.0 + DIFFUSE_PATH * spread);
        if HANGS {
            direct *= p.arriving.past;
            // For light from other directions, assume the depth of visible hair.
            let facing = clamp(dot(p.spot.open, p.arriving.light_ts), 0.0, 1.0);
            direct = mix(direct, SEEN_HANGING, spread * (1.0 - facing));
        }
    }
    if SCATTERING {
        let sent = scatter_around(p.direction, around, eye, coat, direct, p.baked, rim);
        return p.opacity * (sent.once + sent.often);
    }
    let sent = fibre_around(p.direction, around.towards, eye, p.wetness);
    let lit = full * instance.diffuse_constant * sent.x + instance.specular_constant * sent.y;
    return p.opacity * lit * around.whole * (direct / PI);
}

// Returns the environment light that the mat of an undercoat with that colour reflects.
fn environment_on_mat(p: HairPoint, color: vec3<f32>) -> vec3<f32> {
    var sky = p.sky;
    var sum = vec3(0.0);
    for (var part = 0u; part < MOST_PARTS; part++) {
        let around = around_at(sky.parts[part], color);
        // A surface receives most of its light from above, where hair hides least.
        let from_above = vec3(around.towards.xy, flux_height(around.towards));
        let direct = visible_past_strands_around(p.baked, from_above, material.rim);
        sum += around.irradiance * reaches_mat(1.0, color, direct);
    }
    return sum;
}

// Returns the environment light on a bare surface, by Lambert's law. `side`: -1 for the back of a double-sided part.
fn environment_on_bare(color: vec3<f32>, spot: Spot, side: f32, gloss: GlossPoint) -> vec3<f32> {
    if !ENVIRONMENT {
        return vec3(0.0);
    }
    let enters = instance.diffuse_constant * past_gloss_around(gloss);
    if side < 0.0 {
        // The openness of a body is known only for its outer side.
        let normal = normalize_or(-spot.normal_ws, vec3(0.0, 1.0, 0.0));
        return color * enters * irradiance_of_parts(environment_place(normal));
    }
    var sky = sky_at(spot, tile_of(spot));
    var sum = vec3(0.0);
    for (var part = 0u; part < MOST_PARTS; part++) {
        sum += around_at(sky.parts[part], color).irradiance;
    }
    return color * enters * sum;
}
