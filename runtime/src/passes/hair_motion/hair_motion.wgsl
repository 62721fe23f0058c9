//! uses hair/triangle_frame, hair/wind, surface/geometry
// Motion of guided hair (formulas 2.6): each guide is a chain of particles whose root moves with the mesh surface.
// Counterpart of formats/src/meaning/hair_motion/mod.rs, which explains the method.

// Constants of a group's guides for a frame.
struct HairMotion {
    // Transform of directions from model to world space.
    world_from_model: mat3x3<f32>,
    model_from_world: mat3x3<f32>,
    // Model origin in world space.
    origin: vec3<f32>,
    points: u32,
    // Displacement of the model origin in this frame.
    went: vec3<f32>,
    steps: u32,
    gravity: vec3<f32>,
    step_s: f32,
    wind: Wind,
    // Duration of a step in the previous frame, s.
    before_s: f32,
    held: f32,
    free: f32,
    drag_per_s: f32,
    shape_hz: f32,
    bend_hz: f32,
    friction: f32,
    colliders: u32,
    guides: u32,
    // 1 if the hair starts from its groomed shape; otherwise 0.
    fresh: u32,
    reserved: vec2<u32>,
}

@group(0) @binding(0) var<storage, read> vertices: array<GeometryVertex>;
// Corners of each guide's triangle, and root weights of the second and third corner, unorm.
@group(0) @binding(1) var<storage, read> triangles: array<vec4<u32>>;
// Groomed points of each guide, in the frame of its triangle.
@group(0) @binding(2) var<storage, read> groomed: array<vec4<f32>>;
// Acceleration that keeps each guide point at its groomed position at rest. The w component holds the freedom of the
// guide.
@group(0) @binding(3) var<storage, read> ballast: array<vec4<f32>>;
// State of each guide: position and velocity of each particle, then the triangle frame (three vectors) and the root of
// the previous frame.
@group(0) @binding(4) var<storage, read_write> particles: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> posed_guides: array<vec4<f32>>;
// Colliders: both ends in the previous frame, then both ends in this frame, relative to the current model origin. The
// first end of each pair has the radius in w.
@group(0) @binding(6) var<storage, read> colliders: array<vec4<f32>>;
// A storage buffer, because Mesa's lavapipe recompiles a shader for each value of a uniform that it branches on.
@group(0) @binding(7) var<storage, read> motion: HairMotion;

// Maximum number of points of a guide.
const MOST_POINTS: u32 = 65u;
// Minimum number of steps per second (formulas 2.6).
const STEPS_PER_S: f32 = 120.0;
// Maximum number of solver iterations for the tensions (formulas 2.6).
const SOLVED: u32 = 16u;
// Relative length error at which the solver iterations stop early (formulas 2.6).
const WITHIN: f32 = 1e-4;
// Number of passes in which a particle is pushed out of the colliders.
const PUSHED: u32 = 3u;
// Cosine of the rotation within a step beyond which a segment's current direction replaces its direction at the start
// of the step.
const LEAST_TURN: f32 = 0.995;
// Damping ratio zeta of the springs that restore the groomed shape: 1 for critical damping (formulas 2.6).
const DAMPED: f32 = 0.3;
// Maximum speed of a particle relative to its root, in guide lengths per second.
const FASTEST: f32 = 25.0;
// Standard gravity, m/s²; the ballast is stored for this value.
const GRAVITY: f32 = 9.81;
const TAU: f32 = 6.2831853;
// Factor on the reach of a guide in the search for colliders, which compensates for rounding.
const NEAR_MARGIN: f32 = 1.001;

// Working state of the guide that a thread simulates.
var<private> first_particle: u32;
var<private> first_point: u32;
var<private> left: array<f32, MOST_POINTS>;
var<private> right: array<f32, MOST_POINTS>;
var<private> lengths: array<f32, MOST_POINTS>;
// Bit mask of the colliders that the guide may reach in this frame.
var<private> near: array<u32, 4>;

// Finds the colliders near a guide. It skips those farther away than the sum of their radius, the guide's length, and
// the motion of both.
fn find_near(root: vec3<f32>, old_root: vec3<f32>) {
    var reach = distance(root, old_root);
    for (var k = 1u; k < motion.points; k++) {
        reach += lengths[k];
    }
    near = array<u32, 4>();
    for (var c = 0u; c < motion.colliders; c++) {
        let from_end = colliders[4u * c + 2u];
        let to_end = colliders[4u * c + 3u].xyz;
        let moved = max(distance(from_end.xyz, colliders[4u * c].xyz), distance(to_end, colliders[4u * c + 1u].xyz));
        let axis = to_end - from_end.xyz;
        let on_axis = clamp(dot(root - from_end.xyz, axis) / max(dot(axis, axis), 1e-20), 0.0, 1.0);
        let off = distance(root, from_end.xyz + axis * on_axis);
        if off <= NEAR_MARGIN * (max(from_end.w, colliders[4u * c].w) + reach + moved) {
            near[c >> 5u] |= 1u << (c & 31u);
        }
    }
}

// Returns the current position of particle `k` of the guide.
fn particle_position(k: u32) -> vec3<f32> {
    return particles[first_particle + 2u * k].xyz;
}

fn set_particle_position(k: u32, value: vec3<f32>) {
    particles[first_particle + 2u * k] = vec4(value, 0.0);
}

// Returns the velocity of particle `k` of the guide, between steps.
fn velocity(k: u32) -> vec3<f32> {
    return particles[first_particle + 2u * k + 1u].xyz;
}

fn set_velocity(k: u32, value: vec3<f32>) {
    particles[first_particle + 2u * k + 1u] = vec4(value, 0.0);
}

// Returns the position of a particle at the start of the step. During a step, it is stored in the slot that holds the
// velocity between steps.
fn start_position(k: u32) -> vec3<f32> {
    return velocity(k);
}

// Returns how freely particle `k` moves: 0 where the guide is held, rising smoothly to the freedom of the guide.
fn freedom(k: u32) -> f32 {
    let share = f32(k) / f32(motion.points - 1u);
    if share <= motion.held {
        return 0.0;
    }
    let way = clamp((share - motion.held) / max(motion.free - motion.held, 1e-6), 0.0, 1.0);
    return way * way * (3.0 - 2.0 * way) * ballast[first_point + k].w;
}

// Returns the unit vector along `v`, or `other` if `v` is too short.
fn direction(v: vec3<f32>, other: vec3<f32>) -> vec3<f32> {
    let size = length(v);
    if size > 1e-9 {
        return v / size;
    }
    return other;
}

// Returns the groomed segment that ends at point `k`. `frame`: current frame of the triangle at the root.
fn groomed_segment(frame: mat3x3<f32>, k: u32) -> vec3<f32> {
    return frame * groomed[first_point + k].xyz - frame * groomed[first_point + k - 1u].xyz;
}

const UP: vec3<f32> = vec3(0.0, 1.0, 0.0);

// Returns the smallest rotation from one direction to another, as a quaternion.
fn rotation_between(from_way: vec3<f32>, to_way: vec3<f32>) -> vec4<f32> {
    let a = direction(from_way, UP);
    let b = direction(to_way, UP);
    let half = 1.0 + dot(a, b);
    if half < 1e-6 {
        return vec4(0.0, 0.0, 0.0, 1.0);
    }
    return normalize(vec4(cross(a, b), half));
}

// Rotates a vector by a unit quaternion.
fn rotate(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v);
}

// Returns the quaternion that rotates by `first`, then by `second`.
fn quaternion_product(second: vec4<f32>, first: vec4<f32>) -> vec4<f32> {
    let turn = second.w * first.xyz + first.w * second.xyz + cross(second.xyz, first.xyz);
    return vec4(turn, second.w * first.w - dot(second.xyz, first.xyz));
}

// Returns the current direction of the segment that ends at particle `k`.
fn direction_now(k: u32) -> vec3<f32> {
    return direction(particle_position(k) - particle_position(k - 1u), UP);
}

// Returns the direction, at the start of the step, of the segment that ends at particle `k`.
fn direction_at_start(k: u32) -> vec3<f32> {
    return direction(start_position(k) - start_position(k - 1u), UP);
}

// Returns the direction along which the tension of the segment that ends at particle `k` acts. This is the direction at
// the start of the step, or the current one if the segment has rotated too far.
fn constraint_direction(k: u32) -> vec3<f32> {
    let now = direction_now(k);
    let then = direction_at_start(k);
    return select(then, now, dot(now, then) < LEAST_TURN);
}

// Returns the greatest relative length error of the guide's segments.
fn length_error(held: u32) -> f32 {
    var off = 0.0;
    for (var k = held + 1u; k < motion.points; k++) {
        let here = abs(distance(particle_position(k), particle_position(k - 1u)) - lengths[k]);
        off = max(off, here / max(lengths[k], 1e-9));
    }
    return off;
}

// Performs one iteration of Newton's method for the tensions that restore the lengths of all segments (formulas 2.6).
fn solve_lengths(held: u32) {
    var before = vec3(0.0);
    left[held] = 0.0;
    right[held] = 0.0;
    for (var k = held + 1u; k < motion.points; k++) {
        let here = direction_now(k);
        let own = constraint_direction(k);
        let neighbour = -dot(here, before);
        let masses = select(2.0, 1.0, k == held + 1u);
        let pivot = masses * dot(here, own) - neighbour * left[k - 1u];
        var next = 0.0;
        if k + 1u < motion.points {
            next = -dot(here, constraint_direction(k + 1u));
        }
        let off = distance(particle_position(k), particle_position(k - 1u)) - lengths[k];
        left[k] = next / pivot;
        right[k] = (off - neighbour * right[k - 1u]) / pivot;
        before = own;
    }
    var tension = 0.0;
    var pull = vec3(0.0);
    for (var k = motion.points - 1u; k > held; k--) {
        let own = constraint_direction(k);
        tension = right[k] - left[k] * tension;
        set_particle_position(k, particle_position(k) + (pull - own * tension));
        pull = own * tension;
    }
}

// Returns the position nearest to `at` with distance `size` from `parent` and `radius` from `center` (formulas 2.6). If
// there is none, returns the point at distance `size` straight away from `center`.
fn pushed_out(parent: vec3<f32>, size: f32, at: vec3<f32>, center: vec3<f32>, radius: f32) -> vec3<f32> {
    let to_center = center - parent;
    let apart = length(to_center);
    let axis = direction(to_center, direction(parent - at, UP));
    let on_axis = (size * size - radius * radius + apart * apart) / (2.0 * max(apart, 1e-9));
    let squared = size * size - on_axis * on_axis;
    if squared <= 0.0 || apart <= 1e-9 {
        return parent - axis * size;
    }
    let off = (at - parent) - axis * dot(at - parent, axis);
    let other = select(vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), abs(axis.x) > 0.7);
    let beside = direction(off, normalize(cross(axis, other)));
    return parent + axis * on_axis + beside * sqrt(squared);
}

// Advances a guide by one step (formulas 2.6).
fn advance(
    old_frame: mat3x3<f32>,
    old_root: vec3<f32>,
    frame: mat3x3<f32>,
    root: vec3<f32>,
    share: f32,
    before_s: f32,
    time_s: f32,
) {
    let h = motion.step_s;
    let went = root - old_root;
    let per_s = select(0.0, 1.0 / h, h > 0.0);
    let shape_square = TAU * motion.shape_hz * TAU * motion.shape_hz;
    let shape = shape_square / (1.0 + shape_square * h * h);
    let kept_of_air = exp(-motion.drag_per_s * h);
    let kept_of_shape = exp(-2.0 * DAMPED * TAU * motion.shape_hz * h);
    let scale = pow(abs(determinant(motion.world_from_model)), 1.0 / 3.0);
    let weight = length(motion.gravity) / (GRAVITY * max(scale, 1e-9));
    var whole = 0.0;
    for (var k = 1u; k < motion.points; k++) {
        whole += lengths[k];
    }

    var held = 0u;
    for (var k = 0u; k < motion.points; k++) {
        let goal = frame * groomed[first_point + k].xyz;
        let begins = particle_position(k) - went;
        let free = freedom(k);
        if free <= 0.0 || k == 0u {
            set_particle_position(k, goal);
            held = k;
        } else {
            let air = wind_at(motion.wind, motion.origin + root + begins, time_s);
            var speed = air + (velocity(k) - air) * kept_of_air;
            let with_skin = (went + goal - old_frame * groomed[first_point + k].xyz) * per_s;
            let beside = (speed - with_skin) * kept_of_shape;
            speed = with_skin + beside * min(FASTEST * whole / max(length(beside), 1e-9), 1.0);
            let pulled = motion.gravity + frame * ballast[first_point + k].xyz * weight + (goal - begins) * shape;
            set_particle_position(k, begins + speed * h + pulled * (0.5 * h * (h + before_s)));
        }
        if h > 0.0 {
            set_velocity(k, begins);
        }
    }
    if h <= 0.0 {
        resolve_lengths_and_collisions(frame, root, share, held);
        return;
    }

    let bend_square = TAU * motion.bend_hz * TAU * motion.bend_hz * h * h;
    let bend = bend_square / (1.0 + bend_square);
    var turn = vec4(0.0, 0.0, 0.0, 1.0);
    var aside = vec3(0.0);
    for (var k = 1u; k < motion.points; k++) {
        let wanted = rotate(turn, groomed_segment(frame, k));
        let found = start_position(k) - start_position(k - 1u);
        if k > held {
            aside += (wanted - found) * bend;
            set_particle_position(k, particle_position(k) + aside);
        }
        turn = quaternion_product(rotation_between(wanted, found), turn);
    }

    for (var i = 0u; i < SOLVED && (i == 0u || length_error(held) > WITHIN); i++) {
        solve_lengths(held);
    }
    resolve_lengths_and_collisions(frame, root, share, held);
}

// Resolves the remaining length errors and collisions, from root to tip.
fn resolve_lengths_and_collisions(frame: mat3x3<f32>, root: vec3<f32>, share: f32, held: u32) {
    let h = motion.step_s;
    for (var k = 0u; k < motion.points; k++) {
        var touched = vec3(0.0);
        if k > held {
            let goal = frame * groomed[first_point + k].xyz;
            let nearer = goal + (particle_position(k) - goal) * pow(freedom(k), STEPS_PER_S * h);
            let parent = particle_position(k - 1u);
            let way = direction(nearer - parent, direction(groomed_segment(frame, k), UP));
            var at = parent + way * lengths[k];
            for (var i = 0u; i < PUSHED; i++) {
                for (var c = 0u; c < motion.colliders; c++) {
                    if (near[c >> 5u] & (1u << (c & 31u))) == 0u {
                        continue;
                    }
                    let from_end = mix(colliders[4u * c], colliders[4u * c + 2u], share);
                    let to_end = mix(colliders[4u * c + 1u].xyz, colliders[4u * c + 3u].xyz, share);
                    let axis = to_end - from_end.xyz;
                    let on_axis = clamp(dot(root + at - from_end.xyz, axis) / max(dot(axis, axis), 1e-20), 0.0, 1.0);
                    let center = from_end.xyz + axis * on_axis - root;
                    let off = at - center;
                    if dot(off, off) < from_end.w * from_end.w {
                        at = pushed_out(parent, lengths[k], at, center, from_end.w);
                        touched = direction(at - center, UP);
                    }
                }
            }
            set_particle_position(k, at);
        }
        if h > 0.0 {
            let speed = (particle_position(k) - start_position(k)) / h;
            let slide = speed - touched * dot(speed, touched);
            let lost = select(0.0, 1.0 - pow(1.0 - motion.friction, STEPS_PER_S * h), dot(touched, touched) > 0.0);
            set_velocity(k, speed - slide * lost);
        }
    }
}

// Returns the matrix at the share `share` of the way from `a` to `b`, column by column.
fn between(a: mat3x3<f32>, b: mat3x3<f32>, share: f32) -> mat3x3<f32> {
    return mat3x3(a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share, a[2] + (b[2] - a[2]) * share);
}

// Moves the guides, with one thread per guide.
@compute @workgroup_size(64)
fn move_guides(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let guide = id.y * groups.x * 64u + id.x;
    if guide >= motion.guides {
        return;
    }
    let points = motion.points;
    first_point = guide * points;
    first_particle = guide * (2u * points + 4u);
    let last = first_particle + 2u * points;
    let t = triangles[guide];
    let a = vertices[t.x].position;
    let b = vertices[t.y].position;
    let c = vertices[t.z].position;
    let w = unpack2x16unorm(t.w);
    let frame = motion.world_from_model * triangle_frame(a, b, c);
    let root = motion.world_from_model * (a * (1.0 - w.x - w.y) + b * w.x + c * w.y);
    if motion.fresh != 0u {
        for (var k = 0u; k < points; k++) {
            set_particle_position(k, frame * groomed[first_point + k].xyz);
            set_velocity(k, vec3(0.0));
        }
    } else {
        let old_frame = mat3x3(particles[last].xyz, particles[last + 1u].xyz, particles[last + 2u].xyz);
        // Make the root relative to the current model origin.
        let old_root = particles[last + 3u].xyz - motion.went;
        lengths[0] = 0.0;
        for (var k = 1u; k < points; k++) {
            lengths[k] = length(frame * (groomed[first_point + k].xyz - groomed[first_point + k - 1u].xyz));
        }
        find_near(root, old_root);
        for (var number = 1u; number <= motion.steps; number++) {
            let begins = f32(number - 1u) / f32(motion.steps);
            let ends = f32(number) / f32(motion.steps);
            let before_s = select(motion.step_s, motion.before_s, number == 1u);
            let time_s = motion.wind.time_s - f32(motion.steps - number) * motion.step_s;
            advance(
                between(old_frame, frame, begins),
                old_root + (root - old_root) * begins,
                between(old_frame, frame, ends),
                old_root + (root - old_root) * ends,
                ends,
                before_s,
                time_s,
            );
        }
    }
    particles[last] = vec4(frame[0], 0.0);
    particles[last + 1u] = vec4(frame[1], 0.0);
    particles[last + 2u] = vec4(frame[2], 0.0);
    particles[last + 3u] = vec4(root, 0.0);
    for (var k = 0u; k < points; k++) {
        posed_guides[first_point + k] = vec4(motion.model_from_world * particle_position(k), 0.0);
    }
}
