//! The ox: a water buffalo, 1.45 m at the withers and 2.7 m long without its tail, on the plane y = 0, facing +Z. Its
//! posture is low, with the head forward and the horns swept back.
//!
//! The model is made for ink, so its outline identifies it. Belly, dewlap and withers are heavy against thin legs,
//! which are separate in every view.

use glam::{DMat3, DVec3, DVec4, dvec3 as v};

use super::{
    body::{self, Body, Comb, Keep, cone, curve, ellipsoid, on_side, pitch, ramp},
    glb::{Material, Model},
    ox_rig,
    regions::Regions,
    remesh::{Sizing, no_local_limit},
    shapes::eyes,
    skin::SurfaceFunctions,
    trimesh::TriMesh,
};

/// World length of one unit of texture coordinates, metres.
const METRES_PER_UV: f64 = 0.3;
const HIDE: usize = 0;
const HORN: usize = 1;
const HOOF: usize = 2;
const MUZZLE: usize = 3;
const EYE: usize = 4;

/// End of the nose; hair is combed away from it.
const NOSE: DVec3 = DVec3::new(0.0, 0.64, 1.74);

/// Returns the centre line and radius of a horn, from inside the head to its tip.
fn horn(side: f64) -> Vec<(DVec3, f64)> {
    // A horn is a crescent that leaves the head sideways and turns back and up, clear of the neck.
    let line = [
        (v(0.06, 1.09, 1.26), 0.072),
        (v(0.25, 1.15, 1.2), 0.066),
        (v(0.44, 1.21, 1.07), 0.058),
        (v(0.56, 1.3, 0.91), 0.047),
        (v(0.57, 1.44, 0.77), 0.034),
        (v(0.47, 1.6, 0.7), 0.017),
    ];
    curve(&line, 3).into_iter().map(|(p, radius)| (on_side(side, p), radius)).collect()
}

/// Returns the distance to the horns outside the head, metres.
pub fn to_horns(p: DVec3) -> f64 {
    let near = [1.0, -1.0].into_iter().flat_map(|side| {
        let line = horn(side);
        (1..line.len()).map(move |k| cone(line[k - 1].0, line[k - 1].1, line[k].0, line[k].1).distance(p))
    });
    near.fold(f64::MAX, f64::min).max(0.15 - p.x.abs())
}

/// Returns the centre and radii of an eye.
fn eye(side: f64) -> (DVec3, DVec3) {
    (v(side * 0.128, 0.975, 1.415), v(0.024, 0.033, 0.038))
}

/// Returns the body with its horns, without the eyes.
pub fn body() -> Body {
    let mut body = Body::empty(0.05);
    let back = Comb::Along(v(0.0, -0.45, -0.9));
    let down = Comb::Along(v(0.0, -1.0, -0.15));
    let face = Comb::From(NOSE);

    // Trunk: barrel, belly, withers, croup and hip bones.
    body.add(cone(v(0.0, 0.98, 0.42), 0.36, v(0.0, 0.95, -0.55), 0.36), 0.1, back);
    body.add(ellipsoid(v(0.0, 0.88, -0.08), v(0.43, 0.36, 0.62), DMat3::IDENTITY), 0.15, back);
    body.add(ellipsoid(v(0.0, 1.2, 0.44), v(0.13, 0.26, 0.36), pitch(-0.1, 1.0)), 0.16, back);
    body.add(ellipsoid(v(0.0, 1.12, -0.62), v(0.2, 0.2, 0.34), pitch(-0.25, 1.0)), 0.16, back);
    body.add(ellipsoid(v(0.0, 0.84, 0.62), v(0.24, 0.3, 0.26), DMat3::IDENTITY), 0.14, down);

    // Low neck, and the fold under the throat.
    body.add(cone(v(0.0, 1.08, 0.6), 0.25, v(0.0, 1.01, 1.12), 0.165), 0.14, Comb::Along(v(0.0, -0.2, -1.0)));
    body.add(ellipsoid(v(0.0, 0.84, 0.86), v(0.075, 0.2, 0.26), pitch(-0.5, 1.0)), 0.12, down);

    // Head: skull, bridge of the nose, jaw, muzzle.
    body.add(ellipsoid(v(0.0, 1.03, 1.28), v(0.155, 0.15, 0.2), pitch(0.55, 1.0)), 0.1, face);
    body.add(cone(v(0.0, 1.0, 1.34), 0.125, v(0.0, 0.78, 1.6), 0.085), 0.08, face);
    body.add(ellipsoid(v(0.0, 0.88, 1.34), v(0.1, 0.13, 0.18), pitch(0.8, 1.0)), 0.08, face);
    body.add(ellipsoid(v(0.0, 0.725, 1.635), v(0.115, 0.085, 0.1), pitch(0.75, 1.0)), 0.05, face);
    body.add(ellipsoid(v(0.0, 0.675, 1.575), v(0.075, 0.05, 0.085), pitch(0.6, 1.0)), 0.04, face);
    for side in [1.0, -1.0] {
        let m = |p: DVec3| on_side(side, p);
        // Brow over the eye, nostril, ear.
        body.add(ellipsoid(m(v(0.1, 1.015, 1.4)), v(0.045, 0.04, 0.06), pitch(0.5, 1.0)), 0.05, face);
        body.carve(ellipsoid(m(v(0.052, 0.77, 1.705)), v(0.02, 0.034, 0.04), pitch(0.75, 1.0)), 0.012, face);
        let (root, tip) = (m(v(0.12, 0.965, 1.17)), m(v(0.42, 0.9, 1.08)));
        let along = (tip - root).normalize();
        let facing = m(v(0.2, -0.3, 0.93));
        let normal = (facing - along * facing.dot(along)).normalize();
        let axes = DMat3::from_cols(normal.cross(along), along, normal);
        let comb = Comb::Along(along);
        body.add(cone(root, 0.04, root.lerp(tip, 0.3), 0.036), 0.05, comb);
        body.add(ellipsoid(root.lerp(tip, 0.55), v(0.078, 0.15, 0.036), axes), 0.03, comb);
        body.carve(ellipsoid(root.lerp(tip, 0.6) + normal * 0.055, v(0.05, 0.11, 0.035), axes), 0.02, comb);
    }

    for side in [1.0, -1.0] {
        let m = |p: DVec3| on_side(side, p);
        // Foreleg: shoulder blade, upper arm, forearm, knee, cannon, fetlock.
        let [shoulder, elbow, knee, fetlock, toe] = ox_rig::FORELEG.map(m);
        body.add(ellipsoid(m(v(0.24, 1.0, 0.5)), v(0.13, 0.32, 0.2), pitch(-0.15, 1.0)), 0.1, down);
        body.add(cone(shoulder, 0.17, elbow, 0.125), 0.08, down);
        body.add(cone(elbow, 0.12, knee, 0.075), 0.06, down);
        body.add(ellipsoid(knee + v(0.0, 0.0, 0.01), v(0.075, 0.09, 0.075), DMat3::IDENTITY), 0.04, down);
        body.add(cone(knee, 0.06, fetlock, 0.052), 0.03, down);
        body.add(ellipsoid(fetlock, v(0.066, 0.062, 0.07), DMat3::IDENTITY), 0.03, down);
        hoof(&mut body, fetlock, toe);
        // Hind leg: thigh, shank, hock with its heel, cannon, fetlock.
        let [hip, stifle, hock, fetlock, toe] = ox_rig::HIND_LEG.map(m);
        body.add(ellipsoid(m(v(0.2, 0.93, -0.62)), v(0.17, 0.34, 0.27), pitch(0.25, 1.0)), 0.1, down);
        body.add(cone(hip, 0.2, stifle, 0.15), 0.08, down);
        body.add(cone(stifle, 0.14, hock, 0.072), 0.06, down);
        body.add(ellipsoid(hock + v(0.0, 0.02, -0.02), v(0.06, 0.095, 0.08), pitch(0.4, 1.0)), 0.04, down);
        body.add(cone(hock, 0.062, fetlock, 0.052), 0.03, down);
        body.add(ellipsoid(fetlock, v(0.066, 0.062, 0.07), DMat3::IDENTITY), 0.03, down);
        hoof(&mut body, fetlock, toe);
    }

    // Tail with its tuft.
    let tail = ox_rig::TAIL;
    let hanging = Comb::Along(v(0.0, -1.0, -0.05));
    for (k, pair) in tail.windows(2).enumerate() {
        let radius = |k: usize| [0.05, 0.034, 0.028, 0.026][k];
        let blend = if k == 0 { 0.07 } else { 0.03 };
        body.add(cone(pair[0], radius(k), pair[1], radius(k + 1)), blend, hanging);
    }
    body.add(ellipsoid(tail[3] + v(0.0, -0.1, -0.01), v(0.045, 0.15, 0.05), DMat3::IDENTITY), 0.03, hanging);

    for side in [1.0, -1.0] {
        for pair in horn(side).windows(2) {
            let comb = Comb::Along((pair[1].0 - pair[0].0).normalize());
            body.add(cone(pair[0].0, pair[0].1, pair[1].0, pair[1].1), 0.02, comb);
        }
    }
    body
}

/// Adds the pastern and a hoof in front of it on the ground, wider at the bottom.
fn hoof(body: &mut Body, fetlock: DVec3, toe: DVec3) {
    let down = Comb::Along(v(0.0, -1.0, 0.3));
    let middle = v(toe.x, 0.0, toe.z - 0.06);
    body.add(cone(fetlock, 0.056, middle + v(0.0, 0.075, 0.0), 0.06), 0.03, down);
    body.add(cone(middle + v(0.0, 0.062, -0.012), 0.064, middle + v(0.0, 0.046, 0.022), 0.068), 0.02, down);
    // The ground plane cuts the hoof flat.
    body.carve(ellipsoid(middle + v(0.0, -0.6, 0.0), DVec3::splat(0.6), DMat3::IDENTITY), 0.006, down);
}

/// Makes the body's mesh: closed, about 8 000 triangles, vertices on the surface.
pub fn body_mesh(body: &Body) -> anyhow::Result<TriMesh> {
    let bounds = [v(-0.72, -0.06, -1.3), v(0.72, 1.72, 1.86)];
    body::mesh(
        &|p| body.distance(p),
        bounds,
        0.016,
        Sizing { sagitta: 0.0026, shortest: 0.017, longest: 0.085, local: no_local_limit },
        Keep::Largest,
    )
}

/// Splits the mesh surface into materials.
pub fn regions(body: &Body, mesh: TriMesh) -> Regions {
    let surface = |p: DVec3| body.distance(p);
    let mut regions = Regions::new(mesh);
    regions.paint(HORN, &|p| to_horns(p) - 0.012, &surface);
    regions.paint(HOOF, &|p| p.y - 0.088, &surface);
    // The end of the nose is bounded by a plane perpendicular to the bridge of the nose.
    regions.paint(MUZZLE, &|p| (p - v(0.0, 0.79, 1.57)).dot(v(0.0, 0.646, -0.763)), &surface);
    regions
}

/// Returns the hide's linear colour and, as fourth component, its hair length relative to the longest hair. The hide is
/// grey-black, and paler below the knees.
fn hide(p: DVec3, n: DVec3) -> DVec4 {
    let (dark, pale) = (v(0.075, 0.068, 0.064), v(0.26, 0.23, 0.2));
    let mut color = dark.lerp(v(0.13, 0.115, 0.105), ramp(-0.2, 0.8, n.y) * ramp(0.6, 1.2, p.y));
    color = color.lerp(pale, 0.7 * ramp(0.46, 0.34, p.y) * ramp(0.08, 0.14, p.y) * ramp(-0.95, -0.85, p.z));
    let (at, _) = eye(if p.x > 0.0 { 1.0 } else { -1.0 });
    let length = 1.0 - 0.6 * ramp(0.5, 0.3, p.y) * ramp(-0.95, -0.85, p.z) - 0.5 * ramp(1.2, 1.45, p.z);
    let length = length * (1.0 - 0.95 * ramp(0.09, 0.045, (p - at).length()));
    color.extend(length)
}

/// Returns the whole model.
pub fn model() -> anyhow::Result<Model> {
    let body = body();
    let regions = regions(&body, body_mesh(&body)?);
    let weights = ox_rig::weights(&regions.mesh, &|p| to_horns(p) < 0.02);
    let skin = SurfaceFunctions {
        field: &|p| body.distance(p),
        comb: &|p| body.comb(p),
        color: &|material, p, n| if material == HIDE { hide(p, n) } else { DVec4::ONE },
        metres_per_uv: METRES_PER_UV,
    };
    let mut primitives = skin.primitives(&regions, &["hide", "horns", "hooves", "muzzle"], &weights)?;
    primitives.push(eyes(EYE, eye, 5, ox_rig::HEAD_ONLY));
    let material = |name: &str, color, roughness| Material { name: name.into(), color, roughness };
    Ok(Model {
        name: "Ox".into(),
        materials: vec![
            material("hide", [1.0; 3], 0.9),
            material("horn", [0.16, 0.13, 0.1], 0.5),
            material("hoof", [0.05, 0.042, 0.035], 0.6),
            material("muzzle", [0.06, 0.045, 0.042], 0.5),
            material("eye", [0.012, 0.008, 0.006], 0.1),
        ],
        primitives,
        skeleton: Some(ox_rig::skeleton()),
        clips: vec![ox_rig::walk()],
    })
}
