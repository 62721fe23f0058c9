//! The head: a study of a human head with neck and shoulders, life size and 0.38 m high. It is cut flat on the plane y
//! = 0 and faces +Z.
//!
//! The model is made for hair: the scalp, the brows and the rims of the upper lids have separate materials. Measures
//! are means of adult faces (Farkas 1994, "Anthropometry of the Head and Face"), between those of women and men. The
//! distance from vertex to chin is 0.23 m. Breadths: skull 0.15 m, cheekbones 0.132 m, jaw 0.1 m. The pupils are 0.063
//! m apart.

use glam::{DMat3, DVec3, DVec4, dvec2, dvec3 as v};

use super::{
    body::{self, Body, Comb, Keep, almond, bump, chain, cone, curve, ellipsoid, on_side, oval, pitch, ramp},
    glb::{Material, Model, Primitive},
    regions::{Regions, mirror_half},
    remesh::Sizing,
    rig::bound_to,
    sdf::{Solid, smooth_max},
    shapes::METRES_PER_UV,
    skin::SurfaceFunctions,
    trimesh::TriMesh,
};

const SKIN: usize = 0;
const SCALP: usize = 1;
const BROW: usize = 2;
const LASH: usize = 3;
const EYE: usize = 4;
/// Temporary material of the lips while the mesh is cut.
const LIPS: usize = 5;

/// Hair whorl; hair is combed away from it.
const WHORL: DVec3 = DVec3::new(0.0, 0.42, -0.07);

/// Centre of the left eye, metres.
const EYE_AT: DVec3 = DVec3::new(0.0315, 0.2645, 0.0622);
/// Radius of an eye, metres.
const EYE_RADIUS: f64 = 0.0127;
/// Radius of the lids' outer side, metres.
const LID_RADIUS: f64 = 0.0143;

/// Half the width of the opening between the lids, and its heights above and below the line between its corners,
/// metres.
const LIDS: [f64; 3] = [0.0139, 0.0053, 0.0045];

/// Comb direction of the sides of the nose, the ears and similar parts: downwards.
const DOWN: Comb = Comb::Along(DVec3::new(0.0, -1.0, -0.1));

/// Returns a value that is negative between the lids of the nearer eye, seen from the front, metres. The opening is
/// bounded by two arcs that meet in the corners of the eye.
fn opening(p: DVec3) -> f64 {
    let [half, over, under] = LIDS;
    let q = dvec2(p.x.abs() - EYE_AT.x, p.y - EYE_AT.y);
    // The outer corner is slightly higher than the inner one.
    almond(dvec2(-q.x, q.y - 0.055 * q.x), half, over, under)
}

/// Returns the depth of the groove between the lips, metres.
fn parting(p: DVec3) -> f64 {
    let x = p.x.abs() / MOUTH;
    if x > 1.2 || p.z < 0.06 {
        return 0.0;
    }
    0.0022 * bump(p.y - 0.192 - 0.001 * (1.0 - x * x), 0.0036) * ramp(1.04, 0.8, x) * ramp(0.06, 0.068, p.z)
}

/// Returns the approximate signed distance to the mesh surface.
fn field(body: &Body, p: DVec3) -> f64 {
    let d = body.distance(p) + parting(p);
    // Between the lids, the surface recedes behind the eyeball.
    let at = v(p.x.abs(), p.y, p.z) - EYE_AT;
    if at.length_squared() > 0.0009 || at.z < 0.0 {
        return d;
    }
    // A groove forms the fold over the upper lid.
    let within = ramp(0.001, 0.004, at.y) * ramp(0.015, 0.01, at.x.abs()) * ramp(0.0, 0.004, at.z);
    let d = d + 0.0007 * bump(opening(p) - 0.0038, 0.0034) * within;
    let floor = (EYE_RADIUS - 0.0006 - at.length()).max(0.0035 - at.z);
    let hole = smooth_max(opening(p), floor, 0.0004);
    smooth_max(d, -hole, 0.0012)
}

/// Returns the head without its eyes, lids closed.
pub fn body() -> Body {
    let mut body = Body::empty(0.008);
    let hair = Comb::From(WHORL);
    // Skull: vault, forehead and back of the head. Face: middle, dental arch, chin and floor of the mouth.
    body.add(ellipsoid(v(0.0, 0.298, -0.012), v(0.0745, 0.082, 0.094), DMat3::IDENTITY), 0.02, hair);
    body.add(ellipsoid(v(0.0, 0.306, 0.03), v(0.0615, 0.058, 0.0575), DMat3::IDENTITY), 0.03, hair);
    body.add(ellipsoid(v(0.0, 0.255, -0.048), v(0.062, 0.058, 0.052), DMat3::IDENTITY), 0.03, hair);
    body.add(ellipsoid(v(0.0, 0.236, 0.03), v(0.0535, 0.075, 0.05), DMat3::IDENTITY), 0.03, DOWN);
    body.add(ellipsoid(v(0.0, 0.2, 0.05), v(0.036, 0.036, 0.037), DMat3::IDENTITY), 0.025, DOWN);
    body.add(ellipsoid(v(0.0, 0.166, 0.0655), v(0.019, 0.0165, 0.0205), DMat3::IDENTITY), 0.02, DOWN);
    body.add(ellipsoid(v(0.0, 0.183, 0.03), v(0.035, 0.03, 0.045), pitch(-0.2, 1.0)), 0.03, DOWN);
    for side in [1.0, -1.0] {
        bones(&mut body, side);
    }
    neck(&mut body);
    for side in [1.0, -1.0] {
        orbit(&mut body, side);
    }
    nose(&mut body);
    lips(&mut body);
    for side in [1.0, -1.0] {
        ear(&mut body, side);
    }
    // Cuts the base flat.
    body.carve(ellipsoid(v(0.0, -8.0, -0.03), DVec3::splat(8.0), DMat3::IDENTITY), 0.014, DOWN);
    body
}

/// Adds the cheekbone, the jaw and the muscles on them.
fn bones(body: &mut Body, side: f64) {
    let m = |p: DVec3| on_side(side, p);
    // Cheekbone with its arch to the ear.
    body.add(cone(m(v(0.04, 0.244, 0.056)), 0.014, m(v(0.053, 0.249, 0.034)), 0.0115), 0.025, DOWN);
    body.add(cone(m(v(0.053, 0.249, 0.034)), 0.0115, m(v(0.0585, 0.252, 0.002)), 0.0085), 0.022, DOWN);
    // Jaw, from the ear to its angle and on to the chin; then the cheek over it.
    body.add(cone(m(v(0.0535, 0.238, -0.003)), 0.0105, m(v(0.038, 0.191, 0.01)), 0.0115), 0.025, DOWN);
    body.add(cone(m(v(0.038, 0.191, 0.01)), 0.0115, m(v(0.01, 0.164, 0.068)), 0.0115), 0.025, DOWN);
    body.add(ellipsoid(m(v(0.037, 0.217, 0.031)), v(0.0205, 0.033, 0.03), pitch(0.2, 1.0)), 0.025, DOWN);
}

fn neck(body: &mut Body) {
    let m = on_side;
    body.add(oval(v(0.0, 0.22, -0.03), 0.051, v(0.0, 0.125, -0.034), 0.0505, 0.93), 0.03, DOWN);
    body.add(cone(v(0.0, 0.125, -0.034), 0.047, v(0.0, 0.04, -0.052), 0.058), 0.02, DOWN);
    // The larynx, barely visible.
    body.add(cone(v(0.0, 0.135, 0.003), 0.011, v(0.0, 0.095, -0.006), 0.012), 0.025, DOWN);
    // Chest and back.
    body.add(ellipsoid(v(0.0, -0.008, -0.04), v(0.145, 0.08, 0.072), DMat3::IDENTITY), 0.05, DOWN);
    for side in [1.0, -1.0] {
        let out = Comb::Along(m(side, v(0.8, -0.6, 0.0)));
        // Trapezius (from the back of the head over the shoulder), shoulder, collar bone, and the muscle from behind
        // the ear to the breastbone.
        body.add(cone(m(side, v(0.02, 0.19, -0.056)), 0.022, m(side, v(0.045, 0.086, -0.066)), 0.026), 0.035, DOWN);
        body.add(cone(m(side, v(0.045, 0.085, -0.065)), 0.026, m(side, v(0.14, 0.034, -0.052)), 0.025), 0.045, out);
        body.add(ellipsoid(m(side, v(0.155, -0.012, -0.046)), v(0.044, 0.06, 0.05), DMat3::IDENTITY), 0.04, out);
        let collar = [
            (v(0.016, 0.053, 0.012), 0.008),
            (v(0.055, 0.056, 0.009), 0.006),
            (v(0.1, 0.057, -0.014), 0.006),
            (v(0.142, 0.049, -0.034), 0.008),
        ];
        body.add(chain(&collar.map(|(p, r)| (m(side, p), r)), 3), 0.022, out);
        let strap = [
            (v(0.053, 0.218, -0.026), 0.01),
            (v(0.044, 0.17, -0.014), 0.0105),
            (v(0.03, 0.115, -0.002), 0.0085),
            (v(0.013, 0.062, 0.008), 0.0055),
        ];
        body.add(chain(&strap.map(|(p, r)| (m(side, p), r)), 3), 0.014, DOWN);
    }
}

/// Adds the brow, the eye socket and the closed lids.
fn orbit(body: &mut Body, side: f64) {
    let m = |p: DVec3| on_side(side, p);
    let brow = [
        (v(0.009, 0.2815, 0.0765), 0.007),
        (v(0.025, 0.2865, 0.0735), 0.007),
        (v(0.043, 0.2865, 0.0615), 0.007),
        (v(0.0535, 0.277, 0.047), 0.006),
    ];
    body.add(chain(&brow.map(|(p, r)| (m(p), r)), 3), 0.016, DOWN);
    body.carve(ellipsoid(m(v(0.0325, 0.266, 0.089)), v(0.0215, 0.0115, 0.0165), DMat3::IDENTITY), 0.016, DOWN);
    // Soft tissue in the socket round the eye, and the lids over the eye.
    let soft = m(EYE_AT + v(0.0035, -0.0005, -0.0045));
    body.add(ellipsoid(soft, v(0.0205, 0.0135, 0.0125), DMat3::IDENTITY), 0.008, DOWN);
    body.add(ellipsoid(m(EYE_AT), DVec3::splat(LID_RADIUS), DMat3::IDENTITY), 0.005, DOWN);
}

fn nose(body: &mut Body) {
    let ball = |at: DVec3, radii: DVec3| ellipsoid(at, radii, DMat3::IDENTITY);
    body.add(cone(v(0.0, 0.273, 0.0745), 0.0072, v(0.0, 0.25, 0.0895), 0.0068), 0.016, DOWN);
    body.add(cone(v(0.0, 0.25, 0.0895), 0.0068, v(0.0, 0.2295, 0.1015), 0.0075), 0.014, DOWN);
    body.add(ball(v(0.0, 0.229, 0.1012), v(0.0085, 0.0076, 0.0086)), 0.008, DOWN);
    body.add(cone(v(0.0, 0.2235, 0.103), 0.0038, v(0.0, 0.218, 0.0905), 0.0042), 0.006, DOWN);
    for side in [1.0, -1.0] {
        let m = |p: DVec3| on_side(side, p);
        body.add(ellipsoid(m(v(0.0108, 0.225, 0.0925)), v(0.0062, 0.0074, 0.0098), pitch(-0.15, 1.0)), 0.006, DOWN);
        body.carve(ellipsoid(m(v(0.0064, 0.217, 0.0955)), v(0.0034, 0.005, 0.0058), pitch(-0.2, 1.0)), 0.0025, DOWN);
    }
    // The groove under the nose.
    body.carve(cone(v(0.0, 0.2125, 0.0955), 0.002, v(0.0, 0.205, 0.0955), 0.0026), 0.006, DOWN);
}

/// Half the width of the mouth, metres.
const MOUTH: f64 = 0.0265;

fn lips(body: &mut Body) {
    let upper = [
        (v(0.0, 0.1978, 0.0892), 0.0042),
        (v(0.006, 0.1988, 0.0882), 0.0044),
        (v(0.0145, 0.1966, 0.0822), 0.0036),
        (v(MOUTH, 0.1925, 0.072), 0.002),
    ];
    let lower = [
        (v(0.0, 0.1866, 0.0866), 0.0056),
        (v(0.0085, 0.187, 0.0846), 0.0052),
        (v(0.0165, 0.189, 0.0788), 0.0038),
        (v(MOUTH, 0.1922, 0.0715), 0.002),
    ];
    for side in [1.0, -1.0] {
        for points in [upper, lower] {
            body.add(chain(&points.map(|(p, r)| (on_side(side, p), r)), 4), 0.0045, DOWN);
        }
    }
    // The dent between lower lip and chin.
    body.carve(ellipsoid(v(0.0, 0.1765, 0.0955), v(0.017, 0.0045, 0.011), DMat3::IDENTITY), 0.014, DOWN);
}

/// Returns the frame of an ear: its centre, and a matrix with the columns front, up and outward (normal to the plane of
/// the ear).
fn ear_frame(side: f64) -> (DVec3, DMat3) {
    // The ear's plane is turned off the skull by a quarter of a right angle, and leans back.
    let up = v(0.1, 0.97, -0.22).normalize();
    let out = v(0.87, -0.05, 0.46);
    let out = (out - up * out.dot(up)).normalize();
    let front = out.cross(up);
    let m = |p: DVec3| on_side(side, p);
    (m(v(0.074, 0.249, -0.022)), DMat3::from_cols(m(front), m(up), m(out)))
}

fn ear(body: &mut Body, side: f64) {
    let (middle, axes) = ear_frame(side);
    let at = |front: f64, up: f64, out: f64| middle + axes * v(front, up, out);
    // Outer ear: a plate with a lobe, embedded in the skull.
    let leaf = |a, ra, b, rb| Solid::Leaf { a, b, ra, rb, normal: axes.z_axis, rim: 0.0026 };
    body.add(leaf(at(-0.001, 0.012, -0.002), 0.0165, at(0.006, -0.02, -0.002), 0.0085), 0.004, DOWN);
    body.add(ellipsoid(at(0.006, 0.0, -0.009), v(0.012, 0.02, 0.01), axes), 0.008, DOWN);
    // Rim, from the bowl over the top to the lobe; then the fold inside the rim.
    let rim = [
        (at(0.011, 0.003, 0.001), 0.0022),
        (at(0.0145, 0.014, 0.002), 0.0026),
        (at(0.0085, 0.0265, 0.0025), 0.0029),
        (at(-0.004, 0.029, 0.0025), 0.003),
        (at(-0.0155, 0.0205, 0.002), 0.0028),
        (at(-0.0175, 0.006, 0.0015), 0.0026),
        (at(-0.012, -0.009, 0.0005), 0.0024),
        (at(-0.004, -0.021, 0.0), 0.003),
        (at(0.0045, -0.0265, 0.0), 0.0042),
    ];
    body.add(chain(&rim, 3), 0.0025, DOWN);
    let fold = [
        (at(0.002, 0.0205, 0.001), 0.0018),
        (at(-0.0075, 0.013, 0.0025), 0.0023),
        (at(-0.0105, 0.002, 0.003), 0.0023),
        (at(-0.006, -0.0095, 0.0025), 0.0024),
        (at(-0.001, -0.0145, 0.0025), 0.0028),
    ];
    body.add(chain(&fold, 3), 0.003, DOWN);
    // Bowl, and the flap of skin in front of it.
    body.carve(ellipsoid(at(0.002, -0.001, 0.0045), v(0.0075, 0.0095, 0.0068), axes), 0.003, DOWN);
    body.add(ellipsoid(at(0.012, -0.006, 0.0005), v(0.0042, 0.0058, 0.004), axes), 0.004, DOWN);
}

/// Returns the distance to an ear's plate, metres.
fn to_ear(p: DVec3) -> f64 {
    let (middle, axes) = ear_frame(1.0);
    let q = axes.transpose() * (v(p.x.abs(), p.y, p.z) - middle);
    ((q - v(0.0, 0.002, 0.0)) / v(0.0205, 0.034, 0.017)).length() * 0.02 - 0.02
}

/// Returns the greatest edge length at a point, metres. It is small near the eyes, the brows and the mouth, whose
/// outlines define a face.
fn fineness(p: DVec3) -> f64 {
    let to = |at: DVec3| (v(p.x.abs(), p.y, p.z) - at).length();
    let grow = |finest: f64, distance: f64| finest + 0.3 * distance.max(0.0);
    let eye = grow(0.0011, (to(EYE_AT) - 0.0185).max(opening(p).abs() - 0.006));
    let mouth = grow(0.0014, to(v(0.008, 0.193, 0.085)) - 0.019);
    let brow = if p.z > 0.03 { grow(0.0022, brow_distance(p)) } else { f64::MAX };
    eye.min(mouth).min(brow)
}

/// Makes the head's mesh: closed, vertices on the surface.
pub fn body_mesh(body: &Body) -> anyhow::Result<TriMesh> {
    let bounds = [v(-0.22, -0.0112, -0.125), v(0.22, 0.39, 0.12)];
    let sizing = Sizing { sagitta: 0.00034, shortest: 0.0017, longest: 0.009, local: fineness };
    let surface = |p: DVec3| field(body, p);
    body::mesh(&surface, bounds, 0.0022, sizing, Keep::Largest)
}

/// Returns a value that is negative where hair grows on the skull.
fn scalp(p: DVec3) -> f64 {
    // The hairline's height is a function of the cosine of the angle round the head, from the nape to the forehead.
    let z = p.z + 0.012;
    let around = z / (p.x * p.x + z * z).sqrt().max(1e-6);
    let line = [
        (-1.0, 0.192),
        (-0.9, 0.194),
        (-0.7, 0.205),
        (-0.4, 0.225),
        (-0.15, 0.262),
        (0.1, 0.268),
        (0.27, 0.262),
        (0.4, 0.275),
        (0.53, 0.305),
        (0.66, 0.3295),
        (0.8, 0.342),
        (0.92, 0.3425),
        (1.0, 0.34),
    ];
    let next = line.partition_point(|k| k.0 <= around).clamp(1, line.len() - 1);
    let (from, to) = (line[next - 1], line[next]);
    let height = from.1 + (to.1 - from.1) * ((around - from.0) / (to.0 - from.0)).clamp(0.0, 1.0);
    (height - p.y).max(0.004 - to_ear(p))
}

/// Returns the distance to the brows, seen from the front, metres. The brows are tapering arches.
fn brow_distance(p: DVec3) -> f64 {
    let line = [(0.0138, 0.2868, 0.0031), (0.0265, 0.2905, 0.0038), (0.041, 0.291, 0.003), (0.0545, 0.2838, 0.001)];
    let line = Solid::Chain { line: curve(&line.map(|(x, y, r)| (v(x, y, 0.0), r)), 4) };
    line.distance(v(p.x.abs(), p.y, 0.0))
}

/// Returns a value that is negative on the brows.
fn brow(p: DVec3) -> f64 {
    brow_distance(p).max(0.03 - p.z)
}

/// Returns a value that is negative on the rim of an upper lid, which is 2 mm wide.
fn lash(p: DVec3) -> f64 {
    let q = v(p.x.abs(), p.y, p.z) - EYE_AT;
    let over = 0.0012 + 0.1 * q.x.abs() - q.y;
    (opening(p) - 0.0021).max(-0.0001 - opening(p)).max(over).max(EYE_RADIUS + 0.0004 - q.length()).max(0.004 - q.z)
}

/// Splits the mesh surface into materials, symmetric across x = 0.
pub fn regions(body: &Body, mesh: TriMesh) -> Regions {
    let surface = |p: DVec3| field(body, p);
    let mut regions = Regions::new(mesh);
    regions.paint(SCALP, &scalp, &surface);
    // Cuts the mesh along the border of the red of the lips; both sides keep the skin's material.
    regions.paint(LIPS, &|p| -lips_border(p), &surface);
    for material in &mut regions.materials {
        *material = if *material == LIPS { SKIN } else { *material };
    }
    regions.paint(BROW, &brow, &surface);
    regions.paint(LASH, &lash, &surface);
    mirror_half(regions, &surface)
}

/// Returns the signed distance to the border of the red of the lips, metres; positive inside.
fn lips_border(p: DVec3) -> f64 {
    let x = p.x.abs() / MOUTH;
    let arch = 1.0 - x * x;
    let bow = 1.0 + (p.x / 0.004) * (p.x / 0.004);
    let (top, bottom) = (0.1925 + 0.0098 * arch * (1.0 - 0.12 * x) - 0.0016 / (bow * bow), 0.192 - 0.0112 * arch);
    (top - p.y).min(p.y - bottom).min(p.z - 0.06)
}

/// Returns the skin colour, linear RGB.
fn color(material: usize, p: DVec3) -> DVec4 {
    let (skin, red, lip) = (v(0.62, 0.37, 0.27), v(0.62, 0.24, 0.17), v(0.45, 0.155, 0.13));
    let near = |at: DVec3, radius: f64| ramp(radius, 0.25 * radius, (v(p.x.abs(), p.y, p.z) - at).length());
    let mut color = skin;
    // Cheeks, tip of the nose, ears and chin are redder, because blood is near the surface.
    color = color.lerp(red, 0.3 * near(v(0.042, 0.226, 0.062), 0.032));
    color = color.lerp(red, 0.3 * near(v(0.0, 0.226, 0.11), 0.016));
    color = color.lerp(red, 0.35 * ramp(0.003, -0.006, to_ear(p)));
    color = color.lerp(red, 0.12 * near(v(0.0, 0.165, 0.085), 0.02));
    color = color.lerp(lip, ramp(-0.0003, 0.0007, lips_border(p)));
    // Nostrils and the gap between the lids are darker, to imitate hairs and depth.
    color = color.lerp(v(0.1, 0.035, 0.025), 0.8 * near(v(0.0064, 0.218, 0.0955), 0.005));
    if p.z > 0.05 {
        color = color.lerp(v(0.36, 0.17, 0.13), 0.45 * ramp(0.0016, 0.0, opening(p)));
    }
    match material {
        SCALP => color.lerp(v(0.25, 0.15, 0.11), 0.55),
        BROW => color.lerp(v(0.13, 0.07, 0.05), 0.6),
        LASH => color.lerp(v(0.06, 0.03, 0.025), 0.8),
        _ => color,
    }
    .extend(1.0)
}

/// Adds an eye: a ball with rings about its gaze axis, which separate pupil, iris and white.
fn push_eye(to: &mut Primitive, side: f64) {
    const SEGMENTS: u32 = 28;
    let white = v(0.74, 0.7, 0.67);
    let (iris, limbus, pupil) = (v(0.16, 0.085, 0.035), v(0.035, 0.02, 0.012), DVec3::splat(0.004));
    // Angle from the gaze, degrees, and colour; an angle is listed twice where the colour changes abruptly.
    let rings = [
        (0.0, pupil),
        (10.5, pupil),
        (11.5, iris.lerp(limbus, 0.5)),
        (15.0, iris * 1.25),
        (21.0, iris),
        (24.8, limbus),
        (27.5, white * 0.75),
        (34.0, white),
        (46.0, white),
        (60.0, v(0.66, 0.5, 0.46)),
        (90.0, v(0.6, 0.36, 0.3)),
        (135.0, v(0.6, 0.36, 0.3)),
        (180.0, v(0.6, 0.36, 0.3)),
    ];
    let centre = on_side(side, EYE_AT);
    let first = to.len() as u32;
    let radians = core::f64::consts::PI / 180.0;
    for (degrees, color) in rings {
        let (s, c) = (libm::sin(degrees * radians), libm::cos(degrees * radians));
        // The cornea bulges over the iris.
        let bulge = 0.0007 * ramp(30.0, 0.0, degrees);
        for k in 0..=SEGMENTS {
            let turn = core::f64::consts::TAU * f64::from(k % SEGMENTS) / f64::from(SEGMENTS);
            let unit = v(s * libm::cos(turn), s * libm::sin(turn), c);
            let uv = [f64::from(k) / f64::from(SEGMENTS), degrees * radians * EYE_RADIUS / METRES_PER_UV];
            let at = centre + unit * (EYE_RADIUS + bulge);
            to.push_vertex(at, unit, uv, color.extend(1.0), bound_to(0));
        }
    }
    let row = SEGMENTS + 1;
    for ring in 0..rings.len() as u32 - 1 {
        for k in 0..SEGMENTS {
            let a = first + ring * row + k;
            if ring + 2 < rings.len() as u32 {
                to.triangles.push([a, a + row, a + row + 1]);
            }
            if ring > 0 {
                to.triangles.push([a, a + row + 1, a + 1]);
            }
        }
    }
}

/// Returns the whole model.
pub fn model() -> anyhow::Result<Model> {
    let body = body();
    let regions = regions(&body, body_mesh(&body)?);
    let weights = vec![bound_to(0); regions.mesh.positions.len()];
    let skin = SurfaceFunctions {
        field: &|p| field(&body, p),
        comb: &|p| body.comb(p),
        color: &|material, p, _| color(material, p),
        metres_per_uv: METRES_PER_UV,
    };
    let mut primitives = skin.primitives(&regions, &["skin", "scalp", "brows", "lashes"], &weights)?;
    let mut eyes = Primitive::new("eyes", EYE);
    for side in [1.0, -1.0] {
        push_eye(&mut eyes, side);
    }
    primitives.push(eyes);
    let material = |name: &str, roughness| Material { name: name.into(), color: [1.0; 3], roughness };
    Ok(Model {
        name: "Head".into(),
        materials: vec![
            material("Skin", 0.55),
            material("Scalp", 0.6),
            material("Brow", 0.6),
            material("Lash", 0.6),
            material("Eye", 0.08),
        ],
        primitives,
        skeleton: None,
        clips: Vec::new(),
    })
}
