//! The hare: a brown hare sitting upright, 0.48 m to the tips of its ears, on the plane y = 0, facing +Z.
//!
//! The body is a smooth union of round cones and ellipsoids. Every solid carries its comb direction, so the comb field,
//! the fur colours and the skeleton all come from the same list.

use glam::{DMat3, DVec3, dvec3 as v};

use super::{
    body::{self, Body, Comb, Keep, cone, ellipsoid, on_side, pitch, ramp},
    glb::{Material, Model, Primitive},
    hare_rig::{self, ear},
    regions::Regions,
    remesh::{Sizing, no_local_limit},
    sdf::Solid,
    shapes::{METRES_PER_UV, eyes, push_ball},
    skin::SurfaceFunctions,
    trimesh::TriMesh,
};

/// Returns the hare's body without eyes and nose.
pub fn body() -> Body {
    let mut body = Body::empty(0.008);
    let back = Comb::Along(v(0.0, -0.55, -0.83));
    let down = Comb::Along(v(0.0, -1.0, -0.12));
    let nose = v(0.0, 0.297, 0.165);

    // Trunk: rump, arched back, chest, neck.
    body.add(cone(v(0.0, 0.088, -0.07), 0.077, v(0.0, 0.19, 0.008), 0.061), 0.02, back);
    body.add(ellipsoid(v(0.0, 0.15, -0.055), v(0.06, 0.08, 0.07), pitch(-0.4, 0.9)), 0.03, back);
    body.add(ellipsoid(v(0.0, 0.185, 0.035), v(0.05, 0.066, 0.05), DMat3::IDENTITY), 0.03, down);
    body.add(cone(v(0.0, 0.215, 0.03), 0.05, v(0.0, 0.285, 0.058), 0.036), 0.03, Comb::From(v(0.0, 0.42, 0.16)));

    // Head: skull, muzzle, cheeks, chin and the two lips.
    let face = Comb::From(nose);
    body.add(ellipsoid(v(0.0, 0.316, 0.068), v(0.036, 0.037, 0.048), pitch(0.35, 1.0)), 0.02, face);
    body.add(cone(v(0.0, 0.31, 0.094), 0.029, v(0.0, 0.297, 0.128), 0.0195), 0.015, face);
    for side in [1.0, -1.0] {
        body.add(ellipsoid(v(side * 0.021, 0.298, 0.083), v(0.02, 0.0225, 0.025), DMat3::IDENTITY), 0.015, face);
        body.add(ellipsoid(v(side * 0.0085, 0.29, 0.135), v(0.0105, 0.0105, 0.0115), DMat3::IDENTITY), 0.008, face);
    }
    body.add(ellipsoid(v(0.0, 0.279, 0.118), v(0.011, 0.010, 0.016), DMat3::IDENTITY), 0.01, face);

    // Haunches, hind feet and the tail.
    for side in [1.0, -1.0] {
        let m = |p: DVec3| on_side(side, p);
        let haunch = Comb::Along(m(v(0.0, -0.75, -0.66)));
        body.add(ellipsoid(m(v(0.066, 0.088, -0.046)), v(0.04, 0.08, 0.068), pitch(0.4, 0.9)), 0.009, haunch);
        body.add(cone(m(v(0.074, 0.075, -0.005)), 0.028, m(v(0.075, 0.045, 0.014)), 0.021), 0.02, haunch);
        let foot = Comb::Along(m(v(0.0, -0.25, 0.97)));
        body.add(cone(m(v(0.072, 0.021, -0.075)), 0.02, m(v(0.077, 0.0145, 0.05)), 0.0135), 0.012, foot);
        body.add(ellipsoid(m(v(0.078, 0.0135, 0.06)), v(0.016, 0.0128, 0.021), DMat3::IDENTITY), 0.01, foot);
    }
    let tail = Comb::Along(v(0.0, 0.6, -0.8));
    body.add(ellipsoid(v(0.0, 0.09, -0.153), v(0.023, 0.029, 0.023), pitch(0.5, 0.9)), 0.014, tail);

    // Shoulders, front legs and paws.
    for side in [1.0, -1.0] {
        let m = |p: DVec3| on_side(side, p);
        body.add(ellipsoid(m(v(0.036, 0.168, 0.036)), v(0.025, 0.052, 0.034), pitch(-0.1, 1.0)), 0.02, down);
        body.add(cone(m(v(0.034, 0.145, 0.05)), 0.0235, m(v(0.028, 0.075, 0.066)), 0.0155), 0.018, down);
        body.add(cone(m(v(0.028, 0.075, 0.066)), 0.0155, m(v(0.0275, 0.02, 0.073)), 0.0125), 0.006, down);
        let paw = Comb::Along(m(v(0.0, -0.5, 0.87)));
        body.add(ellipsoid(m(v(0.028, 0.0128, 0.085)), v(0.015, 0.0125, 0.022), DMat3::IDENTITY), 0.01, paw);
    }

    // Ears: a leaf of three tapered plates with a rounded back, hollowed on the front.
    for side in [1.0, -1.0] {
        let [root, tip, facing] = ear(side);
        let along = tip - root;
        let normal = (facing - along * (facing.dot(along) / along.length_squared())).normalize();
        let axes = DMat3::from_cols(normal.cross(along).normalize(), along.normalize(), normal);
        let comb = Comb::Along(along.normalize());
        let at = |t: f64| root + along * t;
        let leaf = |a, ra, b, rb| Solid::Leaf { a, b, ra, rb, normal, rim: 0.0042 };
        body.add(leaf(root, 0.0125, at(0.32), 0.0215), 0.012, comb);
        body.add(leaf(at(0.32), 0.0215, at(0.58), 0.0215), 0.001, comb);
        body.add(leaf(at(0.58), 0.0215, at(0.94), 0.0085), 0.001, comb);
        body.add(ellipsoid(at(0.4) - normal * 0.002, v(0.016, 0.06, 0.0095), axes), 0.006, comb);
        let hollow = ellipsoid(at(0.46) + normal * 0.0125, v(0.015, 0.055, 0.0125), axes);
        body.carve(hollow, 0.005, comb);
    }
    body
}

/// Returns the centre and radii of an eye.
fn eye(side: f64) -> (DVec3, DVec3) {
    (v(side * 0.0295, 0.323, 0.088), v(0.0095, 0.012, 0.0125))
}

/// Returns the fur colour at a point of the mesh surface, linear RGB.
fn fur_color(p: DVec3, n: DVec3) -> DVec3 {
    let back = v(0.17, 0.105, 0.058);
    let flank = v(0.42, 0.26, 0.13);
    let cream = v(0.74, 0.62, 0.46);
    let dark = v(0.03, 0.022, 0.016);
    let rust = v(0.38, 0.19, 0.08);

    // Fur is darker along the spine and lighter down the flanks.
    let mut c = flank.lerp(back, ramp(-0.15, 0.7, n.y - 0.35 * n.z));
    // Belly, inside of the legs and throat are pale: surfaces that face down, or face forward low on the body.
    let below = ramp(0.1, 0.75, -n.y) * ramp(0.3, 0.24, p.y);
    c = c.lerp(cream, below);
    let chest = ramp(0.35, 0.9, n.z) * ramp(0.036, 0.014, p.x.abs()) * ramp(0.25, 0.2, p.y) * ramp(0.02, 0.05, p.z);
    c = c.lerp(cream, chest * 0.85);
    // Breast and nape are reddish, as in brown hares.
    let breast = ramp(0.17, 0.21, p.y) * ramp(0.28, 0.24, p.y);
    c = c.lerp(rust, breast * 0.55);
    // Lips, chin and a ring round the eye are pale.
    if p.y > 0.26 && p.y < 0.345 {
        c = c.lerp(cream, ramp(0.300, 0.286, p.y) * ramp(0.07, 0.1, p.z));
        let (centre, _) = eye(if p.x > 0.0 { 1.0 } else { -1.0 });
        let ring = (p - centre).length();
        c = c.lerp(cream, ramp(0.0245, 0.0175, ring) * 0.9);
        c = c.lerp(dark, ramp(0.0165, 0.0125, ring) * 0.8);
    }
    // Ears have black tips and a pale inside.
    if p.y > 0.345 {
        let [root, tip, facing] = ear(if p.x > 0.0 { 1.0 } else { -1.0 });
        let t = (p - root).dot(tip - root) / (tip - root).length_squared();
        c = c.lerp(v(0.62, 0.45, 0.36), ramp(0.2, 0.8, n.dot(facing)) * ramp(0.12, 0.3, t) * 0.85);
        c = c.lerp(dark, ramp(0.72, 0.86, t));
    }
    // The tail is black above and white below.
    if p.z < -0.142 && p.y < 0.13 {
        let away = ramp(-0.142, -0.156, p.z);
        let light = v(0.85, 0.82, 0.76);
        c = c.lerp(light.lerp(dark, ramp(0.1, 0.55, n.y)), away);
    }
    // Soles are slightly rust-coloured.
    c.lerp(rust, ramp(0.02, 0.008, p.y) * 0.4)
}

/// Returns the hair length at a point of the mesh surface, relative to the longest hair. It is short on the face, the
/// ears and the feet, and nearly 0 round the eyes.
fn hair_length(p: DVec3) -> f64 {
    let mut length = 1.0;
    let mut shorten = |to: f64, share: f64| length += (f64::min(to, length) - length) * share;
    shorten(0.5, ramp(0.06, 0.025, p.y));
    shorten(0.55, ramp(0.262, 0.3, p.y));
    shorten(0.5, ramp(0.335, 0.36, p.y));
    if p.y < 0.345 {
        shorten(0.3, ramp(0.265, 0.285, p.y) * ramp(0.1, 0.138, p.z));
        let (centre, _) = eye(if p.x > 0.0 { 1.0 } else { -1.0 });
        shorten(0.06, ramp(0.034, 0.0165, (p - centre).length()));
    }
    length
}

/// Makes the body's mesh: closed, about 5 000 triangles, vertices on the surface.
pub fn body_mesh(body: &Body) -> anyhow::Result<TriMesh> {
    let bounds = [v(-0.1413, -0.0312, -0.2117), v(0.14, 0.5, 0.17)];
    body::mesh(
        &|p| body.distance(p),
        bounds,
        0.004,
        Sizing { sagitta: 0.00057, shortest: 0.0034, longest: 0.0145, local: no_local_limit },
        Keep::Largest,
    )
}

/// Returns the whole model.
pub fn model() -> anyhow::Result<Model> {
    let body = body();
    let mesh = body_mesh(&body)?;
    let weights = hare_rig::weights(&mesh);
    let skin = SurfaceFunctions {
        field: &|p| body.distance(p),
        comb: &|p| body.comb(p),
        color: &|_, p, n| fur_color(p, n).extend(hair_length(p)),
        metres_per_uv: METRES_PER_UV,
    };
    let mut primitives = skin.primitives(&Regions::new(mesh), &["body"], &weights)?;

    let eyes = eyes(1, eye, 6, hare_rig::HEAD_ONLY);
    let mut nose = Primitive::new("nose", 2);
    push_ball(&mut nose, v(0.0, 0.3005, 0.1455), v(0.0075, 0.0055, 0.0058), 4, hare_rig::HEAD_ONLY);

    primitives.extend([eyes, nose]);

    Ok(Model {
        name: "Hare".into(),
        materials: vec![
            Material { name: "Coat".into(), color: [1.0, 1.0, 1.0], roughness: 0.9 },
            Material { name: "Eye".into(), color: [0.012, 0.007, 0.004], roughness: 0.1 },
            Material { name: "Nose".into(), color: [0.045, 0.022, 0.018], roughness: 0.5 },
        ],
        primitives,
        skeleton: Some(hare_rig::skeleton()),
        clips: vec![hare_rig::ear_breath(), hare_rig::walk()],
    })
}
