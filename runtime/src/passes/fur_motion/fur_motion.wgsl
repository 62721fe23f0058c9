//! uses hair/wind, shared/skinning, shared/tile_frame, surface/geometry
// Motion of fur (formulas 2.7): one particle per vertex, at its hair tip. Counterpart of
// formats/src/meaning/fur_motion.rs, which explains the method.

// Constants of a model for a frame.
struct FurMotion {
    // Transform of directions from model to world space.
    world_from_model: mat3x3<f32>,
    // Model origin in world space.
    origin: vec3<f32>,
    vertices: u32,
    // Displacement of the model origin in this frame.
    went: vec3<f32>,
    seconds: f32,
    wind: Wind,
    // Duration of the previous frame, s.
    before_s: f32,
    // Length scale of the character.
    scale: f32,
    // Strength of the lean; 1 is natural.
    strength: f32,
    // Reset state. 1: first frame of motion. 2: second frame, in which the previous velocity of the surface is unknown.
    // Otherwise 0.
    begins: u32,
}

@group(0) @binding(0) var<storage, read> vertices: array<GeometryVertex>;
// Six words per vertex; the first two bytes of the last word are bareness and wetness.
@group(0) @binding(1) var<storage, read> attributes: array<u32>;
// Tip particles, three vectors per vertex: offset of the tip from its groomed position; velocity of that offset;
// surface position relative to the model origin. Their w components hold the surface velocity.
@group(0) @binding(2) var<storage, read_write> tips: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> leaned: array<GeometryVertex>;
// A storage buffer, because Mesa's lavapipe recompiles a shader for each value of a uniform that it branches on.
@group(0) @binding(4) var<storage, read> motion: FurMotion;

// Stiffness s of long hair, m/s² (formulas 2.7).
const STIFFNESS: f32 = 60.0;
// Length at which hair is twice as stiff as long hair, metres (formulas 2.7).
const SHORT_M: f32 = 0.01;
// Drag rate c, 1/s (formulas 2.7).
const DRAG_PER_S: f32 = 4.0;
// Damping ratio zeta: 1 for critical damping (formulas 2.7).
const DAMPING: f32 = 0.35;
// Upper bound of the lean angle, radians (formulas 2.7).
const MOST_LEAN_RAD: f32 = 0.7;
// Maximum distance of a tip from its groomed position, in hair lengths.
const FARTHEST: f32 = 2.0;
// Length below which hair does not move, metres.
const SHORTEST_M: f32 = 1e-5;
// Share of its motion that fur loses where the hair lies flat (formulas 2.7).
const HELD_BY_LEAN: f32 = 0.5;
// Share of its motion that fur loses where it is wet (formulas 2.7).
const HELD_BY_WATER: f32 = 0.6;

// Limits the length of a vector to `most`.
fn limit_length(v: vec3<f32>, most: f32) -> vec3<f32> {
    return v * min(most / max(length(v), 1e-20), 1.0);
}

@compute @workgroup_size(64)
fn lean_fur(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    if index >= motion.vertices {
        return;
    }
    let v = vertices[index];
    var out = v;
    let size = v.fur_height * motion.scale;
    if size > SHORTEST_M {
        let aside = advance(index, v, size);
        let groom = unpack4x8unorm(attributes[6u * index + 5u]);
        let lying = clamp(v.lean, 0.0, 1.0);
        let freedom = (1.0 - HELD_BY_LEAN * lying) * (1.0 - HELD_BY_WATER * groom.y) * (1.0 - groom.x);
        let normal = transform_normal(motion.world_from_model, v.normal);
        let along = aside - normal * dot(normal, aside);
        let far = length(along);
        let wanted = motion.strength * freedom * far / size;
        if wanted > 1e-4 {
            let angle = wanted / sqrt(1.0 + (wanted / MOST_LEAN_RAD) * (wanted / MOST_LEAN_RAD));
            let axis = normal * cos(angle) + along * (sin(angle) / far);
            // Transform the leaned normal from world to model space. Normals transform in this direction by the
            // transposed matrix.
            out.normal = normalize_or(transpose(motion.world_from_model) * axis, v.normal);
            out.tangent = vec4(orthonormal_tangent(v.tangent.xyz, out.normal), v.tangent.w);
        }
    }
    leaned[index] = out;
}

// Advances the tip particle of a vertex and returns its offset (formulas 2.7).
fn advance(index: u32, v: GeometryVertex, size: f32) -> vec3<f32> {
    let root = motion.world_from_model * v.position;
    let air = wind_at(motion.wind, motion.origin + root, motion.wind.time_s);
    let square = STIFFNESS * (1.0 + SHORT_M / size) / size;
    let h = motion.seconds;
    if motion.begins == 1u {
        let held = limit_length(air * (DRAG_PER_S / square), FARTHEST * size);
        store(index, held, vec3(0.0), root, vec3(0.0));
        return held;
    }
    let was = tips[3u * index];
    let beside_was = tips[3u * index + 1u];
    let root_was = tips[3u * index + 2u];
    let of_skin_was = vec3(was.w, beside_was.w, root_was.w);
    if h <= 0.0 {
        store(index, was.xyz, beside_was.xyz, root, of_skin_was);
        return limit_length(was.xyz + beside_was.xyz * (0.5 * motion.before_s), FARTHEST * size);
    }
    let of_skin = (root - root_was.xyz + motion.went) / h;
    let faster = select((of_skin - of_skin_was) / (0.5 * (h + motion.before_s)), vec3(0.0), motion.begins == 2u);
    let goal = limit_length(((air - of_skin) * DRAG_PER_S - faster) / square, FARTHEST * size);
    let off = was.xyz - goal;
    let turns = sqrt(square);
    let damped = turns * sqrt(1.0 - DAMPING * DAMPING);
    let kept = exp(-DAMPING * turns * h);
    let sine = sin(damped * h) / damped;
    let cosine = cos(damped * h);
    let swung = (off * (cosine + DAMPING * turns * sine) + beside_was.xyz * sine) * kept;
    let aside = limit_length(goal + swung, FARTHEST * size);
    let beside = (beside_was.xyz * (cosine - DAMPING * turns * sine) - off * (square * sine)) * kept;
    store(index, aside, beside, root, of_skin);
    return limit_length(aside + beside * (0.5 * h), FARTHEST * size);
}

// Stores the tip particle of a vertex. `aside`: offset of the tip; `beside`: velocity of that offset; `root`: surface
// position; `of_skin`: velocity of the surface.
fn store(index: u32, aside: vec3<f32>, beside: vec3<f32>, root: vec3<f32>, of_skin: vec3<f32>) {
    tips[3u * index] = vec4(aside, of_skin.x);
    tips[3u * index + 1u] = vec4(beside, of_skin.y);
    tips[3u * index + 2u] = vec4(root, of_skin.z);
}
