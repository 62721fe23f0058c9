// How a fibre scatters light (Marschner 2003; d'Eon 2011; Chiang 2016): where a package's tables are looked up, and what is made of their texels; and
// what becomes of light that goes from fibre to fibre.

// Two directions about a fibre.
struct FibreAngles {
    // Places in the tables, 0..=1: of what happens along the fibre, and around it.
    along: vec2<f32>,
    around: vec2<f32>,
    // Cosine of the light's angle from the plane across the fibre, and of the difference angle.
    cos_i: f32,
    cos_d: f32,
}

// What of a fibre needs no table (FORMAT.md, "FIBR").
struct Fibre {
    // 1 / eta^2, 1 / d, mean square of how far aside light falls on it, variance of the reflected lobe along the fibre.
    optics: vec4<f32>,
    on: array<vec4<f32>, 3>,
    back: array<vec4<f32>, 3>,
}

// Share of the axis of sin theta_h that is as it was, and the least cosine of the difference angle.
const DRAWN_OUT: f32 = 0.3;
const LEAST_COS_D: f32 = 0.1;
const PI: f32 = 3.14159265;

// Row of a table for a cosine of the difference angle, 0..=1.
fn fibre_row(cos_d: f32) -> f32 {
    return clamp((cos_d - LEAST_COS_D) / (1.0 - LEAST_COS_D), 0.0, 1.0);
}

// Of unit vectors: the fibre towards its tip, towards the light, towards the eye. A direction along the fibre has no azimuth: any is taken.
fn fibre_angles(tip: vec3<f32>, light: vec3<f32>, eye: vec3<f32>) -> FibreAngles {
    let sin_i = clamp(dot(tip, light), -1.0, 1.0);
    let sin_o = clamp(dot(tip, eye), -1.0, 1.0);
    let cos_i = sqrt(1.0 - sin_i * sin_i);
    let cos_o = sqrt(1.0 - sin_o * sin_o);
    let cos_d = sqrt(clamp(0.5 * (1.0 + cos_i * cos_o + sin_i * sin_o), 0.0, 1.0));
    let sin_h = clamp(0.5 * (sin_i + sin_o) / max(cos_d, 1e-4), -1.0, 1.0);
    let half_d = sqrt(max(1.0 - cos_d * cos_d, 0.0)) / (1.0 + cos_d);
    let tilted = select(-half_d, half_d, sin_o >= sin_i);
    let drawn_out = sin_h / (DRAWN_OUT + (1.0 - DRAWN_OUT) * abs(sin_h));
    let cos_phi = clamp((dot(light, eye) - sin_i * sin_o) / max(cos_i * cos_o, 1e-6), -1.0, 1.0);
    return FibreAngles(
        vec2(0.5 + 0.5 * drawn_out, 0.5 + 0.5 * tilted), vec2(acos(cos_phi) / PI, fibre_row(cos_d)), cos_i, cos_d,
    );
}

// What fibres absorb a radius of which a deep coat has that colour. per_depth: 1 / d of FORMAT.md, "FIBR".
fn fibre_absorption(color: vec3<f32>, per_depth: f32) -> vec3<f32> {
    let root = log(clamp(color, vec3(1e-3), vec3(1.0))) * per_depth;
    return root * root;
}

// What a fibre that absorbs so much a radius leaves of light that crosses it once, at a difference angle of that cosine.
fn fibre_left(cos_d: f32, optics: vec4<f32>, absorbed: vec3<f32>) -> vec3<f32> {
    let c = max(cos_d, LEAST_COS_D);
    // Squares of 1 / cos theta_t, and of the sine of the angle in the section that light is bent to, where it falls in so far aside.
    let slant = 1.0 / (1.0 - (1.0 - c * c) * optics.x);
    let bent = optics.z * c * c * optics.x * slant;
    return exp(-2.0 * sqrt(slant * (1.0 - bent)) * absorbed);
}

// What the tables' texels along and around a fibre come to, times the cosine of the light's angle: light a steradian, over its irradiance.
// left: as fibre_left has it. TRT crosses the fibre twice, and all other light three times.
fn fibre_scatters(along: vec4<f32>, around: vec4<f32>, absorbed: vec3<f32>, left: vec3<f32>) -> vec3<f32> {
    let ways = along.xyz * around.xyz;
    return vec3(ways.x) + ways.y * exp(-absorbed * around.w) + left * left * (vec3(ways.z) + along.w * left);
}

// Of light at an angle of that cosine to the plane across a fibre that absorbs nothing: what goes on, and what comes back, by R, TT, TRT and the rest.
fn fibre_shares(fibre: Fibre, cos_theta: f32) -> array<vec4<f32>, 2> {
    let u = 1.0 - max(cos_theta, LEAST_COS_D);
    let square = u * u;
    return array(
        fibre.on[0] + square * (fibre.on[1] + square * fibre.on[2]),
        fibre.back[0] + square * (fibre.back[1] + square * fibre.back[2]),
    );
}

// The same of a fibre that absorbs: what goes on, and what comes back.
fn fibre_sides(fibre: Fibre, cos_theta: f32, left: vec3<f32>) -> array<vec3<f32>, 2> {
    let shares = fibre_shares(fibre, cos_theta);
    let on = shares[0];
    let back = shares[1];
    return array(
        vec3(on.x) + left * (vec3(on.y) + left * (vec3(on.z) + on.w * left)),
        vec3(back.x) + left * (vec3(back.y) + left * (vec3(back.z) + back.w * left)),
    );
}

// Light in a coat of fibres of which each sends the shares `on` and `back` of it to either side (Kubelka and Munk 1931).
struct Diffused {
    // Over what falls on the coat: what other fibres have sent on, and never back; what comes from the light's side besides; what comes from below.
    sent_on: vec3<f32>,
    from_light: vec3<f32>,
    from_below: vec3<f32>,
    // Root of what a fibre absorbs.
    root_lost: vec3<f32>,
}

// Where the share `direct` of the light comes past all fibres.
fn diffused(on: vec3<f32>, back: vec3<f32>, direct: f32) -> Diffused {
    let lost = max(vec3(1.0) - on - back, vec3(1e-4));
    let root_lost = sqrt(lost);
    let less = root_lost * sqrt(lost + 2.0 * back);
    let given_back = back / (lost + back + less);
    let depth = log2(clamp(direct, 1e-30, 1.0));
    let arrives = exp2(less * depth);
    let sent_on = exp2((vec3(1.0) - on) * depth);
    return Diffused(max(sent_on - direct, vec3(0.0)), max(arrives - sent_on, vec3(0.0)), given_back * arrives, root_lost);
}

// How much of the light that goes on from fibre to fibre there is under a light so high, over that under one straight above: of fibres that absorb the square
// of root_lost (after Hapke 1981, whose H function's share beyond 1 it is).
fn falls_in(root_lost: vec3<f32>, sine: f32) -> vec3<f32> {
    let root = 2.0 * root_lost;
    return sine * (1.0 + root) / (1.0 + sine * root);
}

// Hair that hangs free: what of the light that a fibre sends on or back turns back in a sheet of it, and what leaves it at its edges.
const TURNED_ON: f32 = 0.15;
const TURNED_BACK: f32 = 0.8;
const LEAKS: f32 = 0.12;

// What goes on, and what comes back, in a sheet of fibres of which each sends that on and back.
fn hanging_sides(sides: array<vec3<f32>, 2>) -> array<vec3<f32>, 2> {
    let back = TURNED_ON * sides[0] + TURNED_BACK * sides[1];
    return array((1.0 - LEAKS) * (sides[0] + sides[1]) - back, back);
}

// How much more light goes that way than if it went to all heights alike, of sines of the light's and the eye's angle to the plane across the fibre: of a
// lobe of that variance (d'Eon 2011, around which I0 is taken to 2 %).
fn along_cone(sin_i: f32, sin_o: f32, variance: f32) -> f32 {
    let k = 1.0 / clamp(variance, 1e-3, 1e3);
    let a = k * sqrt(max((1.0 - sin_i * sin_i) * (1.0 - sin_o * sin_o), 0.0));
    let i0e = inverseSqrt(1.0 + 2.0 * a + 4.2832 * a * a / (a + 0.9183) - 0.6664 * a / (1.0 + 0.3884 * a * a));
    return 2.0 * k * i0e * exp(a - k * (1.0 + sin_i * sin_o)) / (1.0 - exp(-2.0 * k));
}

// Fibres side by side keep light near the cone on which it came, and each that scatters it makes the cone wider: along_cone of what was sent on and never back
// (x), and of other light (y). Of light of which the share `direct` comes past all fibres. left: as fibre_left has it, of grey.
fn hanging_cones(fibre: Fibre, cos_i: f32, left: f32, direct: f32, sin_i: f32, sin_o: f32) -> vec2<f32> {
    let shares = fibre_shares(fibre, cos_i);
    let light = vec4(1.0, left, left * left, left * left * left);
    // TT's lobe is half as wide, and TRT's twice.
    let wide = fibre.optics.w * vec4(1.0, 0.25, 4.0, 4.0);
    // Fits of fibres that let nothing through may be nothing, or less.
    let on = max(dot(shares[0], light), 1e-4);
    let all = on + max(dot(shares[1], light), 0.0);
    let width = dot(shares[0] + shares[1], light * wide) / all;
    let depth = -log(clamp(direct, 1e-30, 1.0));
    // Of what was sent on at all.
    let sent = max(on * depth, 1e-3);
    let sent_on = dot(shares[0], light * wide) / on * sent / (1.0 - exp(-sent));
    // How often light has been scattered that comes back from such a sheet: by how much less there is, the more each fibre absorbs.
    let back = TURNED_ON * on + TURNED_BACK * (all - on);
    let lost = max(1.0 - (1.0 - LEAKS) * all, 1e-4);
    let met = back * inverseSqrt(lost * (lost + 2.0 * back));
    let times = 1.0 + depth * all + all / back * met * (1.0 + met / 1.5) / (1.0 + met);
    return vec2(along_cone(sin_i, sin_o, sent_on + width), along_cone(sin_i, sin_o, (times + 1.0) * width));
}
