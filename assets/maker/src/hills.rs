//! The hills: a landscape for ink in the shan shui style. Three ridges of steep round peaks rise one behind another,
//! beyond gentle ground with a path. One unit is 1 m; y is up.
//!
//! Animals walk along x on the path, which crosses the whole ground from x = -40 to 40 near z = 0. The ground is flat
//! at y = 0 for |z| < 1.6. The scene is viewed from +z. Ridges: `near` around z = -24 up to 9 m, `middle` around z =
//! -60 up to 24 m, `far` around z = -125 up to 46 m. Every ridge is closed and reaches below the ground.

use glam::{DMat3, DVec3, DVec4, dvec3 as v};

use super::{
    body::{self, Body, Comb, Keep, cone, ellipsoid, ramp},
    charts::{Atlas, ChartVertex},
    glb::{Material, Model, Primitive},
    regions::Regions,
    remesh::{Sizing, no_local_limit},
    rig::bound_to,
    sdf::smooth_max,
    skin::SurfaceFunctions,
    trimesh::TriMesh,
};

/// World length of one unit of texture coordinates, metres.
const METRES_PER_UV: f64 = 4.0;

/// A ridge of peaks.
struct Ridge {
    name: &'static str,
    /// Distance behind the path, metres.
    behind: f64,
    /// Depth and width of the folds in the rock, metres.
    fold: (f64, f64),
    /// Size of the bounding box: half its width, its height and half its depth, metres.
    size: DVec3,
    /// Cell size of the first mesh, metres.
    cell: f64,
    sizing: Sizing,
    /// Peaks: x, and z relative to the ridge's centre; height; radius at the foot. All in metres.
    peaks: &'static [[f64; 4]],
}

const NEAR: Ridge = Ridge {
    name: "near",
    behind: 24.0,
    fold: (0.35, 2.6),
    size: DVec3::new(38.0, 11.0, 9.0),
    cell: 0.6,
    sizing: Sizing { sagitta: 0.06, shortest: 0.4, longest: 2.0, local: no_local_limit },
    peaks: &[
        [-27.0, 0.0, 5.2, 3.6],
        [-23.2, -1.2, 8.6, 3.0],
        [-19.4, 0.8, 6.1, 2.7],
        [-15.8, 0.2, 3.0, 3.0],
        [-11.0, -0.4, 1.4, 3.4],
        [13.2, -0.6, 1.6, 3.4],
        [17.6, 0.6, 3.6, 2.6],
        [20.6, -0.8, 7.2, 2.8],
        [24.4, 0.4, 4.9, 3.2],
        [28.4, -0.6, 2.6, 3.2],
    ],
};

const MIDDLE: Ridge = Ridge {
    name: "middle",
    behind: 60.0,
    fold: (0.9, 5.0),
    size: DVec3::new(63.0, 28.0, 15.0),
    cell: 1.1,
    sizing: Sizing { sagitta: 0.15, shortest: 0.9, longest: 3.6, local: no_local_limit },
    peaks: &[
        [-46.0, 0.0, 12.0, 7.0],
        [-37.5, -2.0, 19.5, 6.0],
        [-30.5, 1.5, 14.0, 4.6],
        [-21.0, -0.5, 7.0, 6.6],
        [-9.0, 1.0, 12.5, 4.4],
        [-3.2, -1.0, 23.5, 5.2],
        [3.6, 0.8, 17.0, 4.2],
        [9.4, -0.6, 8.4, 5.0],
        [20.0, 0.4, 5.0, 7.0],
        [31.0, -1.6, 16.2, 4.8],
        [37.4, 0.8, 21.8, 5.0],
        [44.0, -0.6, 11.0, 6.4],
    ],
};

const FAR: Ridge = Ridge {
    name: "far",
    behind: 125.0,
    fold: (1.4, 9.0),
    size: DVec3::new(114.0, 52.0, 27.0),
    cell: 2.0,
    sizing: Sizing { sagitta: 0.34, shortest: 1.7, longest: 7.0, local: no_local_limit },
    peaks: &[
        [-80.0, 0.0, 22.0, 14.0],
        [-62.0, -3.0, 36.0, 10.5],
        [-48.0, 2.0, 27.0, 9.0],
        [-32.0, -1.0, 18.0, 12.0],
        [-19.0, 1.0, 41.0, 9.0],
        [-8.0, -1.5, 30.0, 8.0],
        [8.0, 1.0, 20.0, 11.0],
        [21.0, -2.0, 45.0, 10.0],
        [33.0, 1.6, 34.0, 8.5],
        [47.0, -1.0, 24.0, 11.0],
        [63.0, 0.8, 38.0, 10.0],
        [80.0, -1.0, 19.0, 14.0],
    ],
};

/// Returns smooth noise of about -1..1 with features about one unit wide: the sum of three sines in different
/// directions.
fn uneven(p: DVec3) -> f64 {
    let sine = |x: f64| libm::sin(x);
    let a = sine(1.31 * p.x + 0.7 * p.y + 0.4 * sine(0.9 * p.z + 1.3));
    let b = sine(1.17 * p.z - 0.53 * p.x + 0.8 * sine(0.7 * p.y + 2.1));
    let c = sine(0.83 * p.y + 0.91 * p.z - 1.1 * p.x + 0.5 * sine(1.3 * p.x));
    (a + b + c) / 2.2
}

impl Ridge {
    fn body(&self) -> Body {
        let mut body = Body::empty(self.cell);
        let down = Comb::Along(v(0.0, -1.0, 0.0));
        for (k, &[x, before, height, radius]) in self.peaks.iter().enumerate() {
            // A peak is a steep shaft that leans slightly, with a round head, a lower shoulder on one side, and a
            // widening foot.
            let z = before - self.behind;
            let side = if k % 2 == 0 { 1.0 } else { -1.0 };
            let lean = v(0.12 * side * radius, 0.0, -0.05 * radius);
            let (low, top) = (v(x, -0.1 * height, z), v(x, height, z) + lean);
            let blend = 0.65 * radius;
            let neck = v(x, 0.7 * height, z) + lean * 0.7;
            body.add(cone(low, 0.95 * radius, neck, 0.6 * radius), blend, down);
            body.add(cone(neck, 0.58 * radius, top - v(0.0, 0.46 * radius, 0.0), 0.46 * radius), blend, down);
            let shoulder = v(x + 0.74 * side * radius, 0.6 * height, z + 0.35 * radius);
            body.add(cone(v(shoulder.x, 0.0, shoulder.z), 0.55 * radius, shoulder, 0.3 * radius), 0.6 * radius, down);
            let foot = v(1.75 * radius, 0.2 * height + 2.0 * self.cell, 1.3 * radius);
            body.add(ellipsoid(v(x, -2.0 * self.cell, z), foot, DMat3::IDENTITY), blend, down);
        }
        body
    }

    /// Returns the signed distance to the rock: the peaks with folds that run downwards, cut off below the ground.
    fn distance(&self, body: &Body, p: DVec3) -> f64 {
        let (depth, width) = self.fold;
        // Folds are elongated downwards, and fade out at the foot.
        let folds = uneven(v(p.x, 0.28 * p.y, p.z) / width * 3.0) + 0.45 * uneven(v(p.z, 0.5 * p.y, p.x) / width * 6.5);
        let folded = body.distance(p) + 0.6 * depth * folds * ramp(-0.5, 3.0 * width, p.y + width);
        let below = -2.6 * self.cell - p.y;
        smooth_max(folded, below, 0.5 * self.cell)
    }

    fn primitive(&self, material: usize) -> anyhow::Result<Primitive> {
        let body = self.body();
        let field = |p: DVec3| self.distance(&body, p);
        let middle = v(0.0, 0.0, -self.behind);
        let low = middle - v(self.size.x, 5.0 * self.cell, self.size.z);
        let high = middle + self.size;
        let mesh = body::mesh(&field, [low, high], self.cell, self.sizing, Keep::All)?;
        let weights = vec![bound_to(0); mesh.positions.len()];
        let skin = SurfaceFunctions {
            field: &field,
            comb: &|p| body.comb(p),
            color: &|_, p, n| rock(p, n, self.size.y),
            metres_per_uv: METRES_PER_UV,
        };
        let mut made = skin.primitives(&Regions::new(mesh), &[self.name], &weights)?;
        let mut primitive = made.remove(0);
        primitive.material = material;
        Ok(primitive)
    }
}

/// Returns the rock colour, linear RGB. Rock is pale at the foot, where mist is, and darker towards the top and where
/// it is steep.
fn rock(p: DVec3, n: DVec3, high: f64) -> DVec4 {
    let dark = 0.55 + 0.45 * ramp(0.8, 0.1, n.y);
    let mist = ramp(0.35 * high, 0.0, p.y);
    DVec3::splat((0.62 - 0.42 * dark).max(0.05)).lerp(DVec3::splat(0.8), mist).extend(1.0)
}

/// Returns z of the path's centre line at `x`, metres.
fn path_middle(x: f64) -> f64 {
    0.35 * libm::sin(0.21 * x + 0.6) + 0.2 * libm::sin(0.53 * x)
}

/// Returns the height of the ground, metres. It is 0 on the path, about 0.2 lower in front of it, and rises in gentle
/// waves towards the hills.
fn ground_height(x: f64, z: f64) -> f64 {
    let away = ramp(1.6, 7.0, z.abs());
    let waves = uneven(v(0.16 * x, 0.0, 0.21 * z)) + 0.25 * uneven(v(0.7 * x, 3.0, 0.8 * z));
    let side = if z > 0.0 { -0.2 + 0.12 * waves } else { 0.12 * waves - 0.012 * z };
    away * side
}

/// Returns the ground and the path on it: a sheet that widens with distance.
fn ground() -> Vec<Primitive> {
    const ROWS: [f64; 29] = [
        14.0, 10.0, 7.0, 5.0, 3.6, 2.6, 1.9, 1.2, 0.7, 0.0, -0.7, -1.2, -1.9, -2.6, -3.6, -5.0, -7.0, -9.5, -13.0,
        -17.0, -22.0, -28.0, -36.0, -46.0, -58.0, -72.0, -90.0, -112.0, -140.0,
    ];
    let columns = 48_u32;
    let mut mesh = TriMesh::default();
    for row in ROWS {
        for i in 0..=columns {
            let x = (f64::from(i) / f64::from(columns) * 2.0 - 1.0) * (40.0 + 0.6 * (ROWS[0] - row));
            // Rows near the path follow it, so that its borders are smooth.
            let z = row + path_middle(x) * ramp(5.0, 0.7, row.abs());
            mesh.positions.push(v(x, ground_height(x, z), z));
        }
    }
    for j in 0..ROWS.len() as u32 - 1 {
        for i in 0..columns {
            let a = j * (columns + 1) + i;
            let (b, c, d) = (a + 1, a + columns + 2, a + columns + 1);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let field = |p: DVec3| p.y - ground_height(p.x, p.z);
    let mut regions = Regions::new(mesh);
    regions.paint(1, &|p| (p.z - path_middle(p.x)).abs() - 0.701, &field);
    let uv = |p: &DVec3| [p.x / METRES_PER_UV, -p.z / METRES_PER_UV];
    let vertices = regions.mesh.positions.iter().enumerate();
    let atlas = Atlas {
        vertices: vertices.map(|(k, p)| ChartVertex { position: k as u32, uv: uv(p) }).collect(),
        triangles: regions.mesh.triangles.clone(),
        ..Atlas::default()
    };
    let skin = SurfaceFunctions {
        field: &field,
        comb: &|_| DVec3::NEG_Z,
        color: &|_, _, _| DVec4::ONE,
        metres_per_uv: METRES_PER_UV,
    };
    let weights = vec![bound_to(0); regions.mesh.positions.len()];
    skin.charted(&regions, &atlas, &["ground", "path"], &weights)
}

/// Returns the whole model.
pub fn model() -> anyhow::Result<Model> {
    let mut primitives = ground();
    for (k, ridge) in [NEAR, MIDDLE, FAR].iter().enumerate() {
        primitives.push(ridge.primitive(2 + k)?);
    }
    let material = |name: &str, color| Material { name: name.into(), color, roughness: 1.0 };
    Ok(Model {
        name: "Hills".into(),
        materials: vec![
            material("ground", [0.5, 0.49, 0.45]),
            material("path", [0.72, 0.7, 0.65]),
            material("near", [0.75; 3]),
            material("middle", [0.86; 3]),
            material("far", [1.0; 3]),
        ],
        primitives,
        skeleton: None,
        clips: Vec::new(),
    })
}
