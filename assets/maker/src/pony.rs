//! The pony: a stocky pony of the Shetland type, 1 m high at the withers, standing square on the plane y = 0 and facing
//! +Z.
//!
//! The model is made for long hair over short fur. Where mane, forelock and tail grow, the mesh has separate materials
//! of the same appearance as the fur around them.

use glam::{DMat3, DVec3, DVec4, dvec2, dvec3 as v};

use super::{
    body::{self, Body, Comb, Keep, almond, bump, cone, curve, ellipsoid, on_side, oval, pitch, ramp},
    glb::{Material, Model},
    pony_rig,
    regions::{Regions, mirror_half},
    remesh::Sizing,
    sdf::{Solid, smooth_max},
    shapes::{METRES_PER_UV, eyes},
    skin::SurfaceFunctions,
    trimesh::TriMesh,
};

const MANE: usize = 1;
const FORELOCK: usize = 2;
const TAIL: usize = 3;
const HOOF: usize = 4;
const EYE: usize = 5;

/// Poll, between the ears: origin of the head's coordinates.
const POLL: DVec3 = DVec3::new(0.0, 1.225, 0.6);
/// Unit direction along the face, from the poll to the nose.
const ALONG: DVec3 = DVec3::new(0.0, -0.743, 0.669_294_4);
/// Unit direction out of the forehead.
const OUT: DVec3 = DVec3::new(0.0, 0.669_294_4, 0.743);

/// Returns a point of the head from its head coordinates, metres: sideways, along the face from the poll, and out of
/// the forehead.
fn head(x: f64, s: f64, t: f64) -> DVec3 {
    POLL + v(x, 0.0, 0.0) + ALONG * s + OUT * t
}

/// Returns the head coordinates of a point.
fn on_head(p: DVec3) -> DVec3 {
    v(p.x, (p - POLL).dot(ALONG), (p - POLL).dot(OUT))
}

/// Returns the axes of the head as columns: sideways, along the face, out of the forehead.
fn head_axes() -> DMat3 {
    DMat3::from_cols(DVec3::NEG_X, ALONG, OUT)
}

/// Returns the centre and radii of an eye.
fn eye(side: f64) -> (DVec3, DVec3) {
    (head(side * 0.0595, 0.148, 0.033), DVec3::splat(EYE_RADIUS))
}

const EYE_RADIUS: f64 = 0.021;

/// Returns the gaze direction of an eye: outwards, slightly forwards.
fn gaze(side: f64) -> DVec3 {
    (v(side, 0.0, 0.0) + ALONG * 0.2 + OUT * 0.32).normalize()
}

/// Returns the curve of the crest from the withers to the poll, with the radius of the fat under it.
fn crest() -> Vec<(DVec3, f64)> {
    let line = [
        (v(0.0, 0.925, 0.1), 0.03),
        (v(0.0, 0.983, 0.235), 0.032),
        (v(0.0, 1.095, 0.36), 0.035),
        (v(0.0, 1.185, 0.47), 0.032),
        (v(0.0, 1.225, 0.575), 0.03),
    ];
    curve(&line, 4)
}

/// Returns the curve of the dock, from inside the croup to the end of the dock.
fn dock() -> Vec<(DVec3, f64)> {
    curve(&pony_rig::TAIL.map(|(p, radius)| (p, radius)), 3)
}

/// Returns the distance to a chain of round cones, metres.
fn to_line(line: Vec<(DVec3, f64)>, p: DVec3) -> f64 {
    Solid::Chain { line }.distance(p)
}

/// Returns the approximate signed distance to the mesh surface.
fn field(body: &Body, p: DVec3) -> f64 {
    let d = body.distance(p);
    if p.z < 0.5 || p.y < 0.8 {
        return d;
    }
    // The mouth is a groove between the lips.
    let q = on_head(p);
    let d = d + 0.0035 * bump(q.z - MOUTH, 0.013) * ramp(0.345, 0.37, q.y);
    // Between the lids, the surface recedes behind the eyeball.
    let (opening, at) = opening(p);
    if at.length_squared() > 0.002 || at.z < 0.0 {
        return d;
    }
    let hole = smooth_max(opening, EYE_RADIUS - 0.0012 - at.length(), 0.001);
    smooth_max(d, -hole, 0.003)
}

/// Height of the groove between the lips in head coordinates: component out of the forehead, metres.
const MOUTH: f64 = -0.0375;

/// Returns the signed distance in metres from `p` to the outline of the nearer eye's lids, negative between them. Also
/// returns `p` in that eye's frame: x is perpendicular to gaze and up, y is up, z is along the gaze.
fn opening(p: DVec3) -> (f64, DVec3) {
    let (centre, _) = eye(1.0);
    let out = gaze(1.0);
    let up = (OUT - out * OUT.dot(out)).normalize();
    let at = v(p.x.abs(), p.y, p.z) - centre;
    let at = v(at.dot(out.cross(up)), at.dot(up), at.dot(out));
    (almond(dvec2(at.x, at.y + 0.1 * at.x), 0.0186, 0.0124, 0.0094), at)
}

/// Returns the body without the eyes.
pub fn body() -> Body {
    let mut body = Body::empty(0.03);
    trunk(&mut body);
    for side in [1.0, -1.0] {
        foreleg(&mut body, side);
        hind_leg(&mut body, side);
    }
    face(&mut body);
    body.add(Solid::Chain { line: dock() }, 0.045, Comb::Along(v(0.0, -0.95, -0.3)));
    body
}

fn trunk(body: &mut Body) {
    let back = Comb::Along(v(0.0, -0.35, -0.94));
    let down = Comb::Along(v(0.0, -1.0, -0.12));
    // Barrel, girth, withers, loins, croup.
    body.add(ellipsoid(v(0.0, 0.712, -0.02), v(0.208, 0.238, 0.4), pitch(0.04, 1.0)), 0.1, back);
    body.add(ellipsoid(v(0.0, 0.7, 0.24), v(0.165, 0.208, 0.22), DMat3::IDENTITY), 0.1, back);
    body.add(ellipsoid(v(0.0, 0.91, 0.14), v(0.06, 0.085, 0.2), pitch(0.06, 1.0)), 0.11, back);
    body.add(cone(v(0.0, 0.85, 0.08), 0.1, v(0.0, 0.852, -0.3), 0.115), 0.1, back);
    body.add(ellipsoid(v(0.0, 0.812, -0.335), v(0.165, 0.172, 0.215), pitch(-0.2, 1.0)), 0.1, back);
    // Neck, flattened at the sides, with its crest.
    let neck = Comb::Along(v(0.0, -0.75, -0.66));
    body.add(oval(v(0.0, 0.86, 0.27), 0.182, v(0.0, 0.99, 0.435), 0.146, 0.52), 0.12, neck);
    body.add(oval(v(0.0, 0.99, 0.435), 0.146, v(0.0, 1.12, 0.555), 0.112, 0.52), 0.04, neck);
    body.add(Solid::Chain { line: crest() }, 0.06, Comb::Along(v(0.0, -0.8, -0.6)));
    // Underside of the neck, from the throat down to the breast.
    body.add(oval(v(0.0, 0.92, 0.43), 0.12, v(0.0, 0.7, 0.33), 0.12, 0.75), 0.08, neck);
    for side in [1.0, -1.0] {
        let at = on_side(side, v(0.058, 0.67, 0.35));
        body.add(ellipsoid(at, v(0.078, 0.11, 0.075), pitch(0.2, 1.0)), 0.06, down);
    }
}

fn foreleg(body: &mut Body, side: f64) {
    let m = |p: DVec3| on_side(side, p);
    let down = Comb::Along(v(0.0, -1.0, -0.12));
    let [shoulder, elbow, knee, fetlock, toe] = pony_rig::FORELEG.map(m);
    // Foreleg: shoulder blade, upper arm, forearm, knee, cannon with its sinews, fetlock.
    body.add(ellipsoid(m(v(0.118, 0.79, 0.28)), v(0.07, 0.2, 0.115), pitch(-0.6, 0.8)), 0.09, down);
    body.add(cone(shoulder, 0.085, elbow, 0.076), 0.06, down);
    body.add(ellipsoid(elbow + v(0.0, 0.0, -0.03), v(0.05, 0.07, 0.06), pitch(0.3, 1.0)), 0.05, down);
    body.add(cone(elbow + v(0.0, -0.03, 0.02), 0.079, knee + v(0.0, 0.05, 0.0), 0.043), 0.04, down);
    body.add(ellipsoid(knee + v(0.0, 0.0, 0.006), v(0.041, 0.055, 0.043), DMat3::IDENTITY), 0.03, down);
    cannon(body, knee, fetlock);
    hoof(body, fetlock, toe);
}

fn hind_leg(body: &mut Body, side: f64) {
    let m = |p: DVec3| on_side(side, p);
    let down = Comb::Along(v(0.0, -1.0, -0.12));
    let [hip, stifle, hock, fetlock, toe] = pony_rig::HIND_LEG.map(m);
    // Hind leg: haunch, buttock, thigh, gaskin, the sinew to the point of the hock, hock.
    body.add(ellipsoid(m(v(0.1, 0.75, -0.34)), v(0.105, 0.22, 0.18), pitch(-0.1, 1.0)), 0.09, down);
    body.add(ellipsoid(m(v(0.083, 0.7, -0.425)), v(0.08, 0.175, 0.115), pitch(0.08, 1.0)), 0.07, down);
    body.add(cone(hip, 0.135, stifle, 0.074), 0.07, down);
    body.add(cone(stifle + v(0.0, -0.01, -0.03), 0.084, hock + v(0.0, 0.055, 0.012), 0.04), 0.06, down);
    let point = hock + v(0.0, 0.058, -0.04);
    body.add(cone(m(v(0.095, 0.57, -0.42)), 0.032, point, 0.0185), 0.03, down);
    body.add(cone(point, 0.022, hock + v(0.0, -0.03, -0.01), 0.03), 0.02, down);
    body.add(ellipsoid(hock, v(0.039, 0.06, 0.046), pitch(0.3, 1.0)), 0.025, down);
    cannon(body, hock, fetlock);
    hoof(body, fetlock, toe);
}

/// Adds the cannon bone with the sinews behind it, and the joint below.
fn cannon(body: &mut Body, top: DVec3, fetlock: DVec3) {
    let down = Comb::Along(v(0.0, -1.0, -0.05));
    body.add(cone(top, 0.0355, fetlock + v(0.0, 0.01, 0.006), 0.03), 0.025, down);
    body.add(cone(top + v(0.0, -0.02, -0.014), 0.024, fetlock + v(0.0, 0.0, -0.012), 0.023), 0.015, down);
    body.add(ellipsoid(fetlock, v(0.034, 0.036, 0.038), DMat3::IDENTITY), 0.02, down);
}

/// Adds the pastern and the hoof: a cone cut by the ground, with a front as steep as the pastern.
fn hoof(body: &mut Body, fetlock: DVec3, toe: DVec3) {
    let down = Comb::Along(v(0.0, -1.0, 0.4));
    let middle = v(toe.x, 0.0, toe.z - 0.052);
    body.add(cone(fetlock, 0.03, middle + v(0.0, 0.072, -0.012), 0.035), 0.02, down);
    body.add(cone(middle + v(0.0, 0.06, -0.012), 0.0415, middle + v(0.0, 0.012, 0.001), 0.052), 0.006, down);
    body.carve(ellipsoid(middle + v(0.0, -1.5, 0.0), DVec3::splat(1.5), DMat3::IDENTITY), 0.004, down);
}

/// Adds the head and ears.
fn face(body: &mut Body) {
    let comb = Comb::From(head(0.0, 0.46, 0.03));
    let axes = head_axes();
    let ball = |x: f64, s: f64, t: f64, radii: DVec3| ellipsoid(head(x, s, t), radii, axes);
    // Skull, bridge of the nose, muzzle, chin.
    body.add(ball(0.0, 0.085, 0.008, v(0.074, 0.105, 0.066)), 0.05, comb);
    body.add(oval(head(0.0, 0.13, 0.006), 0.068, head(0.0, 0.34, -0.003), 0.051, 0.88), 0.03, comb);
    body.add(ball(0.0, 0.362, -0.007, v(0.051, 0.052, 0.053)), 0.03, comb);
    body.add(ball(0.0, 0.4, -0.008, v(0.042, 0.026, 0.036)), 0.025, comb);
    body.add(ball(0.0, 0.37, -0.0565, v(0.033, 0.035, 0.0205)), 0.012, comb);
    for side in [1.0, -1.0] {
        let x = |x: f64| side * x;
        // Cheek with the round edge of the jaw, jaw bar, cheekbone, brow.
        body.add(ball(x(0.045), 0.12, -0.05, v(0.03, 0.085, 0.078)), 0.045, comb);
        body.add(cone(head(x(0.03), 0.17, -0.088), 0.026, head(x(0.02), 0.35, -0.045), 0.022), 0.04, comb);
        body.add(cone(head(x(0.059), 0.16, 0.01), 0.014, head(x(0.038), 0.27, 0.004), 0.01), 0.04, comb);
        body.add(ball(x(0.028), 0.215, -0.022, v(0.026, 0.075, 0.042)), 0.045, comb);
        body.add(ball(x(0.046), 0.148, 0.026, v(0.027, 0.045, 0.034)), 0.03, comb);
        body.add(ball(x(0.054), 0.132, 0.053, v(0.023, 0.036, 0.02)), 0.025, comb);
        // Nostril: a hollowed wing.
        body.add(ball(x(0.032), 0.372, 0.02, v(0.02, 0.028, 0.02)), 0.02, comb);
        let turned = DMat3::from_cols(DVec3::NEG_X, (ALONG - OUT * 0.5).normalize(), (OUT + ALONG * 0.5).normalize());
        body.carve(ellipsoid(head(x(0.046), 0.384, 0.018), v(0.013, 0.018, 0.008), turned), 0.008, comb);
        // Closed lids.
        body.add(ellipsoid(eye(side).0, DVec3::splat(EYE_RADIUS + 0.003), DMat3::IDENTITY), 0.012, comb);
    }
    for side in [1.0, -1.0] {
        ear(body, side);
    }
}

/// Adds an ear: a leaf, hollowed on the front.
fn ear(body: &mut Body, side: f64) {
    let m = |p: DVec3| on_side(side, p);
    let [root, tip] = pony_rig::EAR.map(m);
    let facing = m(v(0.55, -0.12, 0.83)).normalize();
    let along = tip - root;
    let normal = (facing - along * (facing.dot(along) / along.length_squared())).normalize();
    let axes = DMat3::from_cols(normal.cross(along).normalize(), along.normalize(), normal);
    let comb = Comb::Along(along.normalize());
    let at = |t: f64| root + along * t;
    let leaf = |a, ra, b, rb| Solid::Leaf { a, b, ra, rb, normal, rim: 0.0085 };
    body.add(cone(root - along * 0.25, 0.022, at(0.2), 0.021), 0.025, comb);
    body.add(leaf(at(0.1), 0.02, at(0.42), 0.0285), 0.012, comb);
    body.add(leaf(at(0.42), 0.0285, at(0.92), 0.0095), 0.004, comb);
    body.add(ellipsoid(at(0.42) - normal * 0.006, v(0.022, 0.05, 0.016), axes), 0.012, comb);
    body.carve(ellipsoid(at(0.5) + normal * 0.017, v(0.0165, 0.047, 0.019), axes), 0.008, comb);
}

/// Returns the greatest edge length at a point, metres. It is small near eyes, nostrils and mouth, and where long hair
/// grows.
fn fineness(p: DVec3) -> f64 {
    let q = on_head(p);
    let grow = |finest: f64, distance: f64| finest + 0.35 * distance.max(0.0);
    let eye = grow(0.0036, opening(p).1.length() - 0.028);
    let muzzle = grow(0.006, (q - v(0.0, 0.385, 0.0)).length() - 0.06);
    let poll = grow(0.011, (q - v(0.0, 0.036, 0.05)).length() - 0.035);
    let crest = grow(0.012, (p.x.abs() - 0.022).max(to_line(crest(), p) - 0.06));
    let dock = grow(0.012, to_line(dock(), p));
    let ear = grow(0.0095, (p.z - 0.66).max(1.235 - p.y).max(0.61 - p.z));
    eye.min(muzzle).min(ear).min(poll).min(crest).min(dock)
}

/// Makes the body's mesh: closed, vertices on the surface.
pub fn body_mesh(body: &Body) -> anyhow::Result<TriMesh> {
    let bounds = [v(-0.3, -0.0312, -0.75), v(0.3, 1.4, 1.0)];
    let sizing = Sizing { sagitta: 0.0013, shortest: 0.0085, longest: 0.038, local: fineness };
    body::mesh(&|p| field(body, p), bounds, 0.008, sizing, Keep::Largest)
}

/// Returns a value that is negative on the strip along the crest where the mane grows, which is 4 cm wide.
fn mane(p: DVec3) -> f64 {
    let along = p.z.max(0.0);
    (p.x.abs() - 0.02).max(to_line(crest(), p) - 0.05).max(0.15 - along).max((p - POLL).dot(v(0.0, 0.45, 0.9)) + 0.022)
}

/// Returns a value that is negative between the ears, where the forelock grows.
fn forelock(p: DVec3) -> f64 {
    let q = on_head(p);
    let (x, s) = (q.x / 0.027, (q.y - 0.036) / 0.034);
    (((x * x + s * s).sqrt() - 1.0) * 0.027).max(0.02 - q.z)
}

/// Returns a value that is negative on the dock.
fn tail(p: DVec3) -> f64 {
    let [(root, _), (bend, _), ..] = pony_rig::TAIL;
    let way = (bend - root).normalize();
    (to_line(dock(), p) - 0.014).max(0.042 - (p - root).dot(way))
}

/// Splits the mesh surface into materials, symmetric across x = 0.
pub fn regions(body: &Body, mesh: TriMesh) -> Regions {
    let surface = |p: DVec3| field(body, p);
    let mut regions = Regions::new(mesh);
    regions.paint(MANE, &mane, &surface);
    regions.paint(FORELOCK, &forelock, &surface);
    regions.paint(TAIL, &tail, &surface);
    // The coronet, the upper border of the hoof, is lower at the heels.
    let heels = |p: DVec3| {
        let toe = if p.z > -0.1 { pony_rig::FORELEG[4] } else { pony_rig::HIND_LEG[4] };
        p.y - 0.058 - 0.22 * (p.z - (toe.z - 0.052))
    };
    regions.paint(HOOF, &heels, &surface);
    mirror_half(regions, &surface)
}

/// Returns the fur's linear colour and, as fourth component, the hair length relative to the longest hair. The pony is
/// a chestnut with a mealy muzzle, belly and legs.
fn fur_color(p: DVec3, n: DVec3) -> DVec4 {
    let (chestnut, dark) = (v(0.33, 0.115, 0.034), v(0.2, 0.06, 0.018));
    let (mealy, skin) = (v(0.6, 0.38, 0.2), v(0.085, 0.06, 0.052));
    let mut color = chestnut.lerp(dark, 0.6 * ramp(0.35, 1.0, n.y) * ramp(0.75, 0.95, p.y));
    // Belly, insides of the legs, and the legs below knee and hock are paler.
    let inside = ramp(0.3, 0.8, -n.x * p.x.signum()) * ramp(0.6, 0.5, p.y);
    color = color.lerp(mealy, 0.65 * (ramp(0.45, 0.95, -n.y) * ramp(0.75, 0.6, p.y)).max(inside));
    color = color.lerp(mealy, 0.35 * ramp(0.34, 0.16, p.y));
    let mut length = 1.0 - 0.55 * ramp(0.5, 0.36, p.y);
    let mut shorten = |to: f64, share: f64| length += (f64::min(to, length) - length) * share;
    let q = on_head(p);
    if q.y > -0.2 && p.z > 0.5 {
        let on_face = ramp(0.0, 0.14, q.y + 0.8 * (q.z + 0.05));
        shorten(0.5, on_face);
        // `muzzle` excludes the throat, which is behind the chin.
        let muzzle = ramp(-0.15, -0.11, q.z);
        // Muzzle and chin are pale; the bare skin around nostrils and lips is dark.
        color = color.lerp(mealy, 0.9 * ramp(0.3, 0.36, q.y - 0.3 * q.z) * muzzle);
        let nostril = (p - head(0.046 * p.x.signum(), 0.384, 0.018)).length();
        let lips = ramp(0.012, 0.003, (q.z - MOUTH).abs()) * ramp(0.34, 0.37, q.y);
        color = color.lerp(skin, (0.9 * ramp(0.024, 0.011, nostril)).max(0.75 * lips));
        color = color.lerp(skin, 0.55 * ramp(0.385, 0.415, q.y) * muzzle);
        shorten(0.22, ramp(0.33, 0.385, q.y) * muzzle);
        let (centre, _) = eye(p.x.signum());
        let ring = (p - centre).length();
        color = color.lerp(mealy, 0.16 * ramp(0.055, 0.034, ring));
        color = color.lerp(skin, 0.9 * ramp(0.0065, 0.0015, opening(p).0.max(ring - 0.03)));
        shorten(0.05, ramp(0.05, 0.031, ring));
        // Ears have dark rims and tips, and are paler inside.
        let [root, tip] = pony_rig::EAR.map(|e| on_side(p.x.signum(), e));
        let t = (p - root).dot(tip - root) / (tip - root).length_squared();
        if p.y > 1.24 && t > 0.0 {
            let facing = v(0.55 * p.x.signum(), -0.12, 0.83);
            color = color.lerp(mealy, 0.55 * ramp(0.3, 0.9, n.dot(facing)) * ramp(0.1, 0.35, t));
            color = color.lerp(dark, 0.8 * ramp(0.75, 0.95, t));
            shorten(0.45, ramp(0.0, 0.2, t));
        }
    }
    color.extend(length)
}

/// Returns the whole model.
pub fn model() -> anyhow::Result<Model> {
    let body = body();
    let regions = regions(&body, body_mesh(&body)?);
    let weights = pony_rig::weights(&regions.mesh);
    let skin = SurfaceFunctions {
        field: &|p| field(&body, p),
        comb: &|p| body.comb(p),
        color: &|material, p, n| if material == HOOF { DVec4::ONE } else { fur_color(p, n) },
        metres_per_uv: METRES_PER_UV,
    };
    let mut primitives = skin.primitives(&regions, &["body", "crest", "poll", "dock", "hooves"], &weights)?;
    primitives.push(eyes(EYE, eye, 5, pony_rig::HEAD_ONLY));
    let material = |name: &str, color, roughness| Material { name: name.into(), color, roughness };
    Ok(Model {
        name: "Pony".into(),
        materials: vec![
            material("Coat", [1.0; 3], 0.8),
            material("Mane", [1.0; 3], 0.8),
            material("Forelock", [1.0; 3], 0.8),
            material("Tail", [1.0; 3], 0.8),
            material("Hoof", [0.06, 0.048, 0.038], 0.55),
            material("Eye", [0.014, 0.008, 0.005], 0.08),
        ],
        primitives,
        skeleton: Some(pony_rig::skeleton()),
        clips: vec![pony_rig::walk(), pony_rig::gallop()],
    })
}
