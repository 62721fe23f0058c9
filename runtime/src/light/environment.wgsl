// Light from all around: what of it comes from above the skin's horizon is taken for one light that is spread about the mean of its directions.

@group(0) @binding(6) var environment_map: texture_2d_array<f32>;
@group(0) @binding(7) var broad_tables: texture_2d_array<f32>;

// There is an environment.
override ENVIRONMENT: bool = false;
// The first of the tables that are of this package's fibres.
override BROAD_FIRST: u32 = 0u;
// The key light is black, and only where it would shine from is looked at.
override DARK_KEY: bool = false;

// Texels of the tables of broad light: over mean cosine, angle to the eye, angle of the light, azimuth.
const BROAD_MEANS: f32 = 8.0;
const BROAD_TO: f32 = 24.0;
const BROAD_FROM: f32 = 24.0;
const BROAD_PHI: f32 = 16.0;

struct Around {
    // All that comes from above the horizon.
    whole: vec3<f32>,
    // Irradiance over pi.
    irradiance: vec3<f32>,
    // Mean of the directions that it comes from, in the tile frame: the shorter, the wider it is spread.
    towards: vec3<f32>,
}

fn environment_texel(place: vec2<f32>, layer: u32) -> vec3<f32> {
    return textureSampleLevel(environment_map, map_sampler, place, layer, 0.0).rgb;
}

fn around_at(tile: TileFrame) -> Around {
    let size = f32(textureDimensions(environment_map).x);
    let place = ((0.5 + 0.5 * octahedral(tile.normal_ws)) * (size - 1.0) + 0.5) / size;
    let towards = to_tile(tile, environment_texel(place, 1u));
    // None of it comes from below.
    return Around(environment_texel(place, 0u), environment_texel(place, 2u), vec3(towards.xy, max(towards.z, 0.05)));
}

// Share of light that is so spread that other strands let through.
fn visible_past_strands_around(b: Baked, towards_ts: vec3<f32>) -> f32 {
    if !BAKED_SHADOW {
        return 1.0;
    }
    var towards = towards_ts;
    if SHORT || LEAN {
        // The share is linear in directions: of the mean direction it is the mean.
        towards = light_in_tile(normalize_or(towards, vec3(0.0, 0.0, 1.0)), select(1.0, b.length, SHORT), b.slope) * length(towards);
    }
    return b.within * (1.0 - b.kept * (1.0 - visibility_towards(b.texel, towards, material.horizon)));
}

// A texel of the tables of broad light between its neighbours: R, TT, all that was reflected within, and how far TT goes within the fibre.
fn broad_texel(mean: f32, sin_i: f32, sin_o: f32, phi: f32) -> vec4<f32> {
    let size = vec2(BROAD_MEANS * BROAD_FROM, BROAD_TO * BROAD_PHI);
    let within = vec2(asin(sin_i) / PI + 0.5, phi) * vec2(BROAD_FROM - 1.0, BROAD_PHI - 1.0) + 0.5;
    let m = broad_place(mean) * (BROAD_MEANS - 1.0);
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

// What a fibre in a coat of that colour sends to the eye of such light, of which the share `direct` comes past other fibres. All in the tile frame.
fn scatter_around(direction: vec3<f32>, around: Around, eye: vec3<f32>, color: vec3<f32>, direct: f32) -> vec3<f32> {
    let number = fibre_number();
    let optics = fibres[number].optics;
    let tip = direction * inverseSqrt(max(dot(direction, direction), 1e-12));
    let mean = length(around.towards);
    let light = around.towards / mean;
    let sin_j = clamp(dot(tip, light), -1.0, 1.0);
    let sin_o = clamp(dot(tip, eye), -1.0, 1.0);
    let cos_o = sqrt(1.0 - sin_o * sin_o);
    let across = sqrt(1.0 - sin_j * sin_j) * cos_o;
    let cos_phi = clamp((dot(light, eye) - sin_j * sin_o) / max(across, 1e-6), -1.0, 1.0);
    let phi = acos(cos_phi) / PI;
    // Of the light's angle and of the difference angle on average.
    let cos_i = sqrt(max(1.0 - mean_square(mean, sin_j), 0.0));
    let cos_d = sqrt(clamp(0.5 * (1.0 + cos_i * cos_o + mean * sin_j * sin_o), 0.0, 1.0));
    let absorbed = fibre_absorption(color, optics.y);
    let left = fibre_left(cos_d, optics, absorbed);
    let texel = broad_texel(mean, sin_j, sin_o, phi);
    let first_on = fibres[number].on[0];
    let first_back = fibres[number].back[0];
    let often = (first_on.w + first_back.w) / max(first_on.z + first_back.z + first_on.w + first_back.w, 1e-6);
    let within = left * left * texel.z * (1.0 - often + often * left);
    var sent = around.whole * direct * (vec3(texel.x) + texel.y * exp(-absorbed * texel.w) + within);
    if MULTIPLE {
        let sides = fibre_sides(fibres[number], cos_i, left);
        var met = sides;
        if HANGS {
            met = hanging_sides(sides);
        }
        let d = diffused(met[0], met[1], direct);
        // The wider light is spread, the less it has a side.
        let turned = mix(0.5, phi, mean);
        let to_here = mix(sides[1], sides[0], turned);
        let to_there = mix(sides[0], sides[1], turned);
        // falls_in over the sine, which irradiance holds already.
        let root = 2.0 * d.root_lost;
        let falls = (1.0 + root) / (1.0 + around.towards.z * root);
        let spread = d.from_light * to_here + d.from_below * to_there;
        sent += around.irradiance * (d.sent_on * to_here + spread * falls);
    }
    return sent;
}

// The terms of eq. (1) under such light: sines are means over its directions, and the highlight is as much wider.
fn fibre_around(direction: vec3<f32>, towards: vec3<f32>, eye: vec3<f32>, wetness: f32) -> vec2<f32> {
    let tip = direction * inverseSqrt(max(dot(direction, direction), 1e-12));
    let mean = length(towards);
    let light = towards / mean;
    var diffuse = max(1.0 - mean_square(mean, dot(tip, light)), 0.0);
    if !SQUARED_DIFFUSE {
        diffuse = pow(diffuse, instance.diffuse_half_exponent);
    }
    if !SPECULAR {
        return vec2(diffuse, 0.0);
    }
    let dry_or_wet = highlight(wetness);
    // H turns half as far as the light.
    let wider = 1.0 / (1.0 + 0.5 * dry_or_wet.y * broad_variance(mean));
    let lobe = pow(max(sin_squared(tip, half_vector(light, eye)), 1e-12), dry_or_wet.y * wider);
    return vec2(diffuse, dry_or_wet.x * sqrt(wider) * lobe);
}

fn environment_on_hair(p: HairPoint) -> vec3<f32> {
    let tile = tile_of(p.spot);
    let around = around_at(tile);
    let eye = to_tile(tile, direction_to(frame.eye_ws, p.spot.position_ws));
    let color = p.color * p.tint;
    var direct = visible_past_strands_around(p.baked, around.towards);
    if !BAKED_SHADOW && (DEEP_SHADOW || SELF_SHADOW) {
        // How deep a point lies in such hair is known from the key light's side alone.
        direct = p.arriving.visible;
    }
    if SCATTERING {
        return p.opacity * scatter_around(p.direction, around, eye, color / max(p.opacity, 1e-6), direct);
    }
    let sent = fibre_around(p.direction, around.towards, eye, p.wetness);
    let lit = color * instance.diffuse_constant * sent.x + instance.specular_constant * (sent.y * p.opacity);
    return lit * around.whole * (direct / PI);
}

// On the mat of an undercoat of that colour.
fn environment_on_mat(p: HairPoint, color: vec3<f32>) -> vec3<f32> {
    let around = around_at(tile_of(p.spot));
    let direct = visible_past_strands_around(p.baked, around.towards);
    return around.irradiance * reaches_mat(1.0, color, direct);
}

// On bare skin, by Lambert's law. side: -1 for the back of a double-sided part.
fn environment_on_bare(color: vec3<f32>, spot: Spot, side: f32) -> vec3<f32> {
    if !ENVIRONMENT {
        return vec3(0.0);
    }
    let normal = normalize_or(spot.normal_ws, vec3(0.0, 1.0, 0.0)) * side;
    let size = f32(textureDimensions(environment_map).x);
    let place = ((0.5 + 0.5 * octahedral(normal)) * (size - 1.0) + 0.5) / size;
    return color * instance.diffuse_constant * environment_texel(place, 2u);
}
