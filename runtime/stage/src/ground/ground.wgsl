// Level ground below the models: their soft shadow, on the picture's background or on that of a studio.

struct Ground {
    // From clip coordinates (x, y, 1, 0) to the direction of the view in world space, of any length.
    direction_from_clip: mat4x4<f32>,
    // From world space to the shadow-width map of the key light, as in ShadowReceiver; zero without a map.
    map_from_world: mat4x4<f32>,
    // Eye in world space, and height of the ground, metres.
    eye: vec3<f32>,
    height_m: f32,
    // Corner and width of the contact map, and height of the models, metres.
    corner: vec2<f32>,
    width_m: f32,
    models_m: f32,
    // Unit vector towards the key light, and its share of the light on the ground, 0..=1.
    towards: vec3<f32>,
    key_share: f32,
    // Distance between depth 0 and depth 1 of the map, metres; texel of the map, metres; width of the map, metres.
    range_m: f32,
    texel_m: f32,
    extent_m: f32,
    // 1 for the background of a studio, 0 for a transparent one.
    studio: f32,
    // Middle of the models on the ground.
    middle: vec2<f32>,
    reserved: vec2<f32>,
}

@group(0) @binding(0) var<uniform> ground: Ground;
// Share of the sky that the models hide from the ground.
@group(0) @binding(1) var contact: texture_2d<f32>;
@group(0) @binding(2) var contact_sampler: sampler;
// Shadow-width map: depth of the surface nearest to the light in z, transmittance of the hair above it in w.
@group(0) @binding(3) var width_map: texture_2d<f32>;

// Tangent of half the angle that the key light spans: a lamp with a soft box.
const LAMP: f32 = 0.09;
// Numbers of samples that find the occluder, and that measure its shadow.
const SEARCHES: u32 = 12u;
const SAMPLES: u32 = 32u;
// Colours of the studio's floor near the models, and of its wall, linear.
const FLOOR: vec3<f32> = vec3(0.62, 0.615, 0.605);
const WALL: vec3<f32> = vec3(0.30, 0.305, 0.315);
// Opacity of the darkest shadow.
const DARKEST: f32 = 0.85;

struct GroundVarying {
    @builtin(position) position: vec4<f32>,
    @location(0) clip: vec2<f32>,
}

@vertex
fn vs_ground(@builtin(vertex_index) index: u32) -> GroundVarying {
    let clip = vec2(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0);
    return GroundVarying(vec4(clip, 0.5, 1.0), clip);
}

// Returns the point of number i of n, spread evenly over the unit disc, turned by an angle.
fn disc(i: u32, n: u32, turn: f32) -> vec2<f32> {
    let angle = 2.399963 * f32(i) + turn;
    return sqrt((f32(i) + 0.5) / f32(n)) * vec2(cos(angle), sin(angle));
}

// Returns the texel of the shadow-width map at a position, 0..=1 across the map; unoccluded beyond its edge.
fn caster(uv: vec2<f32>) -> vec4<f32> {
    let size = vec2<f32>(textureDimensions(width_map));
    let inside = all(uv >= vec2(0.0)) && all(uv < vec2(1.0));
    let texel = textureLoad(width_map, vec2<i32>(clamp(uv, vec2(0.0), vec2(0.9999)) * size), 0);
    return select(vec4(0.0, 0.0, 1.0, 1.0), texel, inside);
}

// Returns the share of the key light that reaches a point of the ground: the mean over a disc as wide as the penumbra
// of the occluders around the point. `turn`: rotation of the samples, another for each pixel.
fn key_light(position: vec3<f32>, turn: f32) -> f32 {
    let at = ground.map_from_world * vec4(position, 1.0);
    if at.w <= 0.0 {
        return 1.0;
    }
    let uv = at.xy / at.w;
    // Metres along the map's axis, from the plane of depth 0.
    let depth_m = at.z * ground.range_m;
    let bias = 1.5 * ground.texel_m + 0.004 * ground.models_m;
    let reach = LAMP * ground.models_m / max(ground.towards.y, 0.2);
    var gap = 0.0;
    var found = 0.0;
    for (var i = 0u; i < SEARCHES; i++) {
        let first = caster(uv + reach / ground.extent_m * disc(i, SEARCHES, turn)).z;
        let above = depth_m - first * ground.range_m;
        if above > bias && first < 1.0 {
            gap += above;
            found += 1.0;
        }
    }
    if found == 0.0 {
        return caster(uv).w;
    }
    let radius = max(LAMP * gap / found, 1.5 * ground.texel_m);
    var light = 0.0;
    for (var i = 0u; i < SAMPLES; i++) {
        let texel = caster(uv + radius / ground.extent_m * disc(i, SAMPLES, turn));
        let hidden = texel.z < 1.0 && depth_m - texel.z * ground.range_m > bias;
        light += select(texel.w, 0.0, hidden);
    }
    return light / f32(SAMPLES);
}

@fragment
fn fs_ground(in: GroundVarying) -> @location(0) vec4<f32> {
    let direction = normalize((ground.direction_from_clip * vec4(in.clip, 1.0, 0.0)).xyz);
    let below = (ground.height_m - ground.eye.y) / min(direction.y, -1e-5);
    let position = ground.eye + below * direction;
    let hits = direction.y < 0.0 && below > 0.0;

    let uv = (position.xz - ground.corner) / ground.width_m;
    // The map fades out towards its edge, where it ends.
    let edge = min(min(uv.x, uv.y), min(1.0 - uv.x, 1.0 - uv.y));
    let hidden = textureSampleLevel(contact, contact_sampler, uv, 0.0).x * smoothstep(0.0, 0.15, edge);
    let pixel = floor(in.position.xy);
    let turn = 6.283185 * fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715))));
    let key = mix(1.0, key_light(position, turn), select(0.0, 1.0, hits));
    let light = ground.key_share * key + (1.0 - ground.key_share) * (1.0 - hidden);
    let shadow = select(0.0, DARKEST * (1.0 - light), hits);
    if ground.studio == 0.0 {
        return vec4(0.0, 0.0, 0.0, shadow);
    }
    // A curved backdrop: the floor darkens with the distance from the models and passes into the wall.
    let away = distance(position.xz, ground.middle) / max(ground.width_m, 1e-6);
    let wall = select(1.0, smoothstep(0.3, 1.6, away), hits);
    let color = mix(FLOOR, WALL, wall);
    return vec4(color * (1.0 - shadow), 1.0);
}
