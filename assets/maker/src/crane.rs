//! The crane: a red-crowned crane, 1.5 m to the top of its head, on the plane y = 0, facing +Z.
//!
//! The bird is white, with a black neck and a tuft of drooping black plumes over its tail. It has long legs and an
//! S-shaped neck.

use glam::{DMat3, DVec3, DVec4, dvec3 as v};

use super::{
    body::{self, Body, Comb, Keep, cone, curve, ellipsoid, on_side, pitch},
    crane_rig,
    glb::{Material, Model},
    regions::Regions,
    remesh::{Sizing, no_local_limit},
    shapes::eyes,
    skin::SurfaceFunctions,
    trimesh::TriMesh,
};

/// World length of one unit of texture coordinates, metres.
const METRES_PER_UV: f64 = 0.15;
const PLUMES: usize = 1;
const NECK: usize = 2;
const CROWN: usize = 3;
const BEAK: usize = 4;
const LEG: usize = 5;
const EYE: usize = 6;

/// Returns the centre line and radius of the neck, from the breast to the head.
fn neck() -> Vec<(DVec3, f64)> {
    let line = [
        (v(0.0, 0.9, 0.16), 0.1),
        (v(0.0, 0.99, 0.3), 0.07),
        (v(0.0, 1.11, 0.36), 0.048),
        (v(0.0, 1.24, 0.325), 0.037),
        (v(0.0, 1.36, 0.262), 0.031),
        (v(0.0, 1.455, 0.285), 0.031),
    ];
    curve(&line, 3)
}

/// Returns the centre lines and radii of the plumes over the tail.
fn plumes() -> Vec<Vec<(DVec3, f64)>> {
    let plume = |x: f64, out: f64, end: DVec3| {
        let line = [
            (v(x, 0.94, -0.2), 0.05),
            (v(x + out, 0.905, -0.36), 0.05),
            (v(x + 1.3 * out, 0.8, -0.48), 0.038),
            (end, 0.013),
        ];
        curve(&line, 3)
    };
    vec![
        plume(0.0, 0.0, v(0.0, 0.66, -0.6)),
        plume(0.05, 0.015, v(0.06, 0.6, -0.55)),
        plume(-0.05, -0.015, v(-0.06, 0.61, -0.56)),
        plume(0.085, 0.02, v(0.1, 0.6, -0.47)),
        plume(-0.085, -0.02, v(-0.1, 0.59, -0.47)),
    ]
}

/// Returns the centre and radii of an eye.
fn eye(side: f64) -> (DVec3, DVec3) {
    (v(side * 0.029, 1.487, 0.36), DVec3::splat(0.009))
}

/// Returns the body without the eyes.
pub fn body() -> Body {
    let mut body = Body::empty(0.02);
    let back = Comb::Along(v(0.0, -0.3, -0.95));
    let down = Comb::Along(v(0.0, -1.0, -0.1));

    // Drop-shaped trunk (breast, back, rump) and folded wings, whose lower edges stick out.
    body.add(ellipsoid(v(0.0, 0.865, -0.04), v(0.145, 0.16, 0.32), pitch(-0.16, 1.0)), 0.05, back);
    body.add(ellipsoid(v(0.0, 0.865, 0.13), v(0.125, 0.14, 0.15), pitch(-0.5, 1.0)), 0.06, back);
    body.add(cone(v(0.0, 0.84, -0.2), 0.1, v(0.0, 0.79, -0.37), 0.045), 0.05, back);
    for side in [1.0, -1.0] {
        let m = |p: DVec3| on_side(side, p);
        let axes = pitch(-0.22, 1.0);
        body.add(ellipsoid(m(v(0.115, 0.89, -0.08)), v(0.05, 0.115, 0.29), axes), 0.012, back);
    }
    for line in plumes() {
        push_line(&mut body, &line, 0.016);
    }

    push_line(&mut body, &neck(), 0.05);
    let face = Comb::From(v(0.0, 1.46, 0.6));
    body.add(ellipsoid(v(0.0, 1.482, 0.325), v(0.036, 0.037, 0.056), pitch(0.1, 1.0)), 0.025, face);
    body.add(cone(v(0.0, 1.478, 0.36), 0.025, v(0.0, 1.468, 0.43), 0.0155), 0.02, face);
    body.add(cone(v(0.0, 1.468, 0.42), 0.0165, v(0.0, 1.45, 0.57), 0.0075), 0.006, face);

    for side in [1.0, -1.0] {
        let m = |p: DVec3| on_side(side, p);
        let [knee, hock, ankle, toe] = crane_rig::LEG.map(m);
        // Feathers on the shank, then bare bone down to the toes.
        body.add(cone(knee + v(0.0, -0.02, -0.01), 0.088, knee.lerp(hock, 0.52), 0.036), 0.04, down);
        body.add(cone(knee.lerp(hock, 0.45), 0.034, knee.lerp(hock, 0.68), 0.017), 0.02, down);
        body.add(cone(knee.lerp(hock, 0.6), 0.0155, hock, 0.0145), 0.01, down);
        body.add(ellipsoid(hock, v(0.019, 0.026, 0.021), DMat3::IDENTITY), 0.012, down);
        body.add(cone(hock, 0.0145, ankle, 0.0135), 0.01, down);
        let ahead = Comb::Along(v(0.0, -0.2, 1.0));
        for end in [toe, toe + m(v(0.055, 0.0, -0.025)), toe + m(v(-0.036, 0.0, -0.02)), m(v(0.064, 0.0, -0.1))] {
            body.add(cone(ankle, 0.0135, v(end.x, 0.011, end.z), 0.0105), 0.02, ahead);
        }
    }
    body
}

/// Adds a chain of round cones.
fn push_line(body: &mut Body, line: &[(DVec3, f64)], blend: f64) {
    for pair in line.windows(2) {
        let comb = Comb::Along((pair[1].0 - pair[0].0).normalize());
        body.add(cone(pair[0].0, pair[0].1, pair[1].0, pair[1].1), blend, comb);
    }
}

/// Makes the body's mesh: closed, about 5 000 triangles, vertices on the surface.
pub fn body_mesh(body: &Body) -> anyhow::Result<TriMesh> {
    let bounds = [v(-0.24, -0.03, -0.7), v(0.24, 1.57, 0.63)];
    let sizing = Sizing { sagitta: 0.0019, shortest: 0.013, longest: 0.05, local: no_local_limit };
    body::mesh(&|p| body.distance(p), bounds, 0.0085, sizing, Keep::Largest)
}

/// Splits the mesh surface into materials.
pub fn regions(body: &Body, mesh: TriMesh) -> Regions {
    let surface = |p: DVec3| body.distance(p);
    let mut regions = Regions::new(mesh);
    let lines = plumes();
    let pieces: Vec<_> =
        lines.iter().flat_map(|line| line.windows(2).map(|w| cone(w[0].0, w[0].1, w[1].0, w[1].1))).collect();
    let near = |p: DVec3| pieces.iter().map(|s| s.distance(p)).fold(f64::MAX, f64::min) - 0.014;
    regions.paint(PLUMES, &|p| near(p).max(p.z + 0.26), &surface);
    // The black throat reaches from above the breast to below the eyes.
    let throat =
        |p: DVec3| (v(0.0, 1.04, 0.335) - p).dot(v(0.0, 0.9, 0.45)).max(p.y - 1.462).max((p.z - 0.372).min(p.y - 1.36));
    regions.paint(NECK, &throat, &surface);
    regions.paint(CROWN, &|p| (p - v(0.0, 1.535, 0.325)).length() - 0.042, &surface);
    regions.paint(BEAK, &|p| (0.392 - p.z).max(1.4 - p.y), &surface);
    regions.paint(LEG, &|p| p.y - 0.545, &surface);
    regions
}

/// Returns the whole model.
pub fn model() -> anyhow::Result<Model> {
    let body = body();
    let regions = regions(&body, body_mesh(&body)?);
    let weights = crane_rig::weights(&regions.mesh);
    let skin = SurfaceFunctions {
        field: &|p| body.distance(p),
        comb: &|p| body.comb(p),
        color: &|_, _, _| DVec4::ONE,
        metres_per_uv: METRES_PER_UV,
    };
    let names = ["feathers", "plumes", "neck", "crown", "beak", "legs"];
    let mut primitives = skin.primitives(&regions, &names, &weights)?;
    primitives.push(eyes(EYE, eye, 3, crane_rig::HEAD_ONLY));
    let material = |name: &str, color, roughness| Material { name: name.into(), color, roughness };
    Ok(Model {
        name: "Crane".into(),
        materials: vec![
            material("feather", [0.86, 0.85, 0.82], 0.9),
            material("flight", [0.03, 0.03, 0.035], 0.8),
            material("neck", [0.035, 0.033, 0.035], 0.9),
            material("crown", [0.6, 0.04, 0.03], 0.9),
            material("beak", [0.3, 0.28, 0.2], 0.5),
            material("leg", [0.06, 0.055, 0.055], 0.7),
            material("eye", [0.012, 0.008, 0.006], 0.1),
        ],
        primitives,
        skeleton: Some(crane_rig::skeleton()),
        clips: vec![crane_rig::walk()],
    })
}
