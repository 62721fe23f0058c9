//! The torus and the torus knot, which are tubes around a closed curve. Their texture coordinates repeat a whole number
//! of times around the tube (u) and along it (v), so hair tiles close without a seam. The module also makes spheres for
//! eyes.

use core::f64::consts::TAU;

use glam::{DVec3, DVec4};

use super::{
    glb::{Material, Model, Primitive, Weights},
    rig::bound_to,
};

/// World length of one unit of texture coordinates, metres. Used for torus, knot and hare, and for the eyes of all
/// models.
pub const METRES_PER_UV: f64 = 0.1;

/// Returns a torus, 0.4 m across with a tube of 0.16 m: 19 x 15 quads, 570 triangles.
pub fn torus() -> Model {
    let (ring, tube) = (0.2, 0.08);
    let at = move |t: f64| DVec3::new(libm::sin(t) * ring, tube, libm::cos(t) * ring);
    model("Torus", &tube_along(&at, tube, 19, 15, [0.42, 0.24, 0.12]))
}

/// Returns a (2, 3) torus knot about 0.55 m wide with a tube of 0.09 m: 120 x 12 quads, 2 880 triangles.
pub fn knot() -> Model {
    let at = |t: f64| {
        let r = 0.15 + 0.075 * libm::cos(3.0 * t);
        DVec3::new(r * libm::cos(2.0 * t), 0.28 + r * libm::sin(2.0 * t), 0.09 * libm::sin(3.0 * t))
    };
    model("Knot", &tube_along(&at, 0.045, 120, 12, [0.3, 0.3, 0.34]))
}

fn model(name: &str, primitive: &Primitive) -> Model {
    Model {
        name: name.into(),
        materials: vec![Material { name: "Coat".into(), color: [1.0; 3], roughness: 0.9 }],
        primitives: vec![primitive.clone()],
        skeleton: None,
        clips: Vec::new(),
    }
}

/// Builds a tube of radius `radius` metres around the closed curve `at`, whose period is 2 pi. The tube has `rings`
/// rings at equal distances, each of `sides` vertices.
fn tube_along(at: &dyn Fn(f64) -> DVec3, radius: f64, rings: usize, sides: usize, color: [f64; 3]) -> Primitive {
    let (parameters, length) = even_steps(at, rings);
    let points: Vec<DVec3> = parameters.iter().map(|&t| at(t)).collect();
    let step = 1e-4;
    let tangents: Vec<DVec3> = parameters.iter().map(|&t| (at(t + step) - at(t - step)).normalize()).collect();

    // Parallel transport rotates the previous normal with the tangent. For small steps, projecting it onto the new
    // normal plane is the same to second order. The twist that remains after one turn around the curve is measured and
    // distributed evenly.
    let mut normals = vec![tangents[0].any_orthonormal_vector()];
    for i in 1..=rings {
        let (last, tangent) = (normals[i - 1], tangents[i % rings]);
        normals.push((last - tangent * last.dot(tangent)).normalize());
    }
    let (first, last) = (normals[0], normals[rings]);
    let twist = libm::atan2(tangents[0].cross(first).dot(last), first.dot(last));

    let round_u = (TAU * radius / METRES_PER_UV).round().max(1.0);
    let round_v = (length / METRES_PER_UV).round().max(1.0);
    let mut primitive = Primitive::new("tube", 0);
    for i in 0..=rings {
        let along = i as f64 / rings as f64;
        let (p, tangent) = (points[i % rings], tangents[i % rings]);
        for j in 0..=sides {
            let round = j as f64 / sides as f64;
            // Subtracts the twist, so that the last ring meets the first. Both copies of the seam are computed from the
            // same numbers.
            let (i0, j0) = (i % rings, (j % sides) as f64 / sides as f64);
            let angle = j0 * TAU - twist * i0 as f64 / rings as f64;
            // `side` x tangent = normal, so u, v and the outward normal are right-handed.
            let side = tangent.cross(normals[i0]);
            let normal = normals[i0] * libm::cos(angle) + side * libm::sin(angle);
            let uv = [round * round_u, along * round_v];
            primitive.push_vertex(p + normal * radius, normal, uv, DVec3::from(color).extend(1.0), bound_to(0));
        }
    }
    let row = sides as u32 + 1;
    for i in 0..rings as u32 {
        for j in 0..sides as u32 {
            let a = i * row + j;
            primitive.triangles.push([a, a + 1, a + row + 1]);
            primitive.triangles.push([a, a + row + 1, a + row]);
        }
    }
    primitive
}

/// Returns the parameters of `count` points at equal distances along the closed curve, and the curve's length. Both are
/// computed from 4 096 chords.
fn even_steps(at: &dyn Fn(f64) -> DVec3, count: usize) -> (Vec<f64>, f64) {
    let chords = 4096_usize;
    let parameter = |k: usize| k as f64 / chords as f64 * TAU;
    let mut distance = vec![0.0];
    for k in 0..chords {
        distance.push(distance[k] + (at(parameter(k + 1)) - at(parameter(k))).length());
    }
    let length = distance[chords];
    let mut k = 0;
    let parameters = (0..count)
        .map(|i| {
            let wanted = length * i as f64 / count as f64;
            while distance[k + 1] <= wanted {
                k += 1;
            }
            let part = (wanted - distance[k]) / (distance[k + 1] - distance[k]);
            (k as f64 + part) / chords as f64 * TAU
        })
        .collect();
    (parameters, length)
}

/// Builds a pair of eyes: two spheres of material `material`, with `n` cells along a cube edge. `eye` returns centre
/// and radii for a side, +1 or -1.
pub fn eyes(material: usize, eye: impl Fn(f64) -> (DVec3, DVec3), n: u32, weights: Weights) -> Primitive {
    let mut eyes = Primitive::new("eyes", material);
    for side in [1.0, -1.0] {
        let (centre, radii) = eye(side);
        push_ball(&mut eyes, centre, radii, n, weights);
    }
    eyes
}

/// Adds a sphere as an inflated cube with `n` cells along an edge, which avoids slivers.
pub fn push_ball(to: &mut Primitive, centre: DVec3, radii: DVec3, n: u32, weights: Weights) {
    let faces = [
        [DVec3::X, DVec3::Y, DVec3::Z],
        [DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z],
        [DVec3::Y, DVec3::Z, DVec3::X],
        [DVec3::NEG_Y, DVec3::Z, DVec3::NEG_X],
        [DVec3::Z, DVec3::X, DVec3::Y],
        [DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y],
    ];
    for [out, along_u, along_v] in faces {
        let first = to.len() as u32;
        for j in 0..=n {
            for i in 0..=n {
                let (s, t) = (f64::from(i) / f64::from(n) * 2.0 - 1.0, f64::from(j) / f64::from(n) * 2.0 - 1.0);
                let unit = (out + along_u * s + along_v * t).normalize();
                let uv = [(s + 1.0) * radii.x / METRES_PER_UV, (t + 1.0) * radii.y / METRES_PER_UV];
                to.push_vertex(centre + unit * radii, (unit / radii).normalize(), uv, DVec4::ONE, weights);
            }
        }
        for j in 0..n {
            for i in 0..n {
                let a = first + j * (n + 1) + i;
                let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
                to.triangles.push([a, b, c]);
                to.triangles.push([a, c, d]);
            }
        }
    }
}
