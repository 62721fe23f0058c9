//! The hare's skeleton, its skin weights and its one clip.

use std::collections::BTreeSet;

use glam::{DQuat, DVec3};

use super::{
    glb::{Channel, Clip, Interpolation, Joint, Target},
    hare::ear,
    trimesh::TriMesh,
};

/// Up to four joints with their weights, which sum to one.
pub type Weights = [(u8, f64); 4];

const SPINE: u8 = 1;
const CHEST: u8 = 2;
const RIBS: u8 = 3;
const NECK: u8 = 4;
const HEAD: u8 = 5;
const EAR_L: u8 = 6;
const EAR_L_TIP: u8 = 7;
const EAR_R: u8 = 8;
const EAR_R_TIP: u8 = 9;
const TAIL: u8 = 10;

/// Bound wholly to the head: eyes and nose.
pub const HEAD_ONLY: Weights = [(HEAD, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)];

/// Name, parent, world position of the joint, world position of the bone's far end.
fn bones() -> Vec<(&'static str, Option<u8>, DVec3, DVec3)> {
    let v = DVec3::new;
    let [root_l, tip_l, _] = ear(1.0);
    let [root_r, tip_r, _] = ear(-1.0);
    let (mid_l, mid_r) = (root_l.lerp(tip_l, 0.5), root_r.lerp(tip_r, 0.5));
    vec![
        ("hips", None, v(0.0, 0.075, -0.075), v(0.0, 0.09, -0.07)),
        ("spine", Some(0), v(0.0, 0.125, -0.055), v(0.0, 0.17, -0.03)),
        ("chest", Some(SPINE), v(0.0, 0.175, 0.0), v(0.0, 0.215, 0.02)),
        // A leaf, so that its breathing scale reaches neither neck nor legs.
        ("ribs", Some(CHEST), v(0.0, 0.165, 0.02), v(0.0, 0.185, 0.055)),
        ("neck", Some(CHEST), v(0.0, 0.235, 0.035), v(0.0, 0.275, 0.05)),
        ("head", Some(NECK), v(0.0, 0.295, 0.06), v(0.0, 0.3, 0.12)),
        ("ear_l", Some(HEAD), root_l, mid_l),
        ("ear_l_tip", Some(EAR_L), mid_l, tip_l),
        ("ear_r", Some(HEAD), root_r, mid_r),
        ("ear_r_tip", Some(EAR_R), mid_r, tip_r),
        ("tail", Some(0), v(0.0, 0.075, -0.138), v(0.0, 0.1, -0.165)),
        ("leg_l", Some(CHEST), v(0.033, 0.145, 0.05), v(0.0275, 0.012, 0.08)),
        ("leg_r", Some(CHEST), v(-0.033, 0.145, 0.05), v(-0.0275, 0.012, 0.08)),
    ]
}

/// Joints in rest pose: translations only, so that every inverse bind matrix is a translation too.
pub fn skeleton() -> Vec<Joint> {
    let bones = bones();
    let joint = |&(name, parent, at, _): &(&str, Option<u8>, DVec3, DVec3)| {
        let origin = parent.map_or(DVec3::ZERO, |p| bones[p as usize].2);
        Joint { name: name.into(), parent: parent.map(usize::from), translation: at - origin, world: at }
    };
    bones.iter().map(joint).collect()
}

/// Skin weights: each vertex belongs to near bones by the inverse fourth power of the distance, then smoothed over the mesh.
pub fn weights(mesh: &TriMesh) -> Vec<Weights> {
    let bones = bones();
    let mut dense: Vec<Vec<f64>> = mesh
        .positions
        .iter()
        .map(|&p| {
            let mut row: Vec<f64> = bones
                .iter()
                .map(|&(_, _, a, b)| {
                    let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
                    let d2 = (p - a.lerp(b, t)).length_squared() + 1e-5;
                    1.0 / (d2 * d2)
                })
                .collect();
            normalise(&mut row);
            row
        })
        .collect();
    let mut rings = vec![BTreeSet::new(); mesh.positions.len()];
    for t in &mesh.triangles {
        for k in 0..3 {
            rings[t[k] as usize].insert(t[(k + 1) % 3] as usize);
        }
    }
    for _ in 0..4 {
        dense = rings
            .iter()
            .zip(&dense)
            .map(|(ring, own)| {
                let mut row = own.clone();
                for &w in ring {
                    for (sum, x) in row.iter_mut().zip(&dense[w]) {
                        *sum += x;
                    }
                }
                normalise(&mut row);
                row
            })
            .collect();
    }
    dense.iter().map(|row| four_largest(row)).collect()
}

fn normalise(row: &mut [f64]) {
    let sum: f64 = row.iter().sum();
    for x in row {
        *x /= sum;
    }
}

fn four_largest(row: &[f64]) -> Weights {
    let mut order: Vec<usize> = (0..row.len()).collect();
    order.sort_by(|&a, &b| row[b].total_cmp(&row[a]));
    // Weights under one per cent move nothing that one could see.
    let kept: Vec<usize> = order.into_iter().take(4).filter(|&j| row[j] > 0.01).collect();
    let sum: f64 = kept.iter().map(|&j| row[j]).sum();
    let mut weights = [(0, 0.0); 4];
    for (slot, &j) in weights.iter_mut().zip(&kept) {
        *slot = (j as u8, row[j] / sum);
    }
    weights
}

fn turn(axis: DVec3, degrees: f64) -> [f64; 4] {
    let half = degrees * core::f64::consts::PI / 360.0;
    let (s, c) = (libm::sin(half), libm::cos(half));
    let q = DQuat::from_xyzw(axis.x * s, axis.y * s, axis.z * s, c);
    [q.x, q.y, q.z, q.w]
}

fn rotations(joint: u8, axis: DVec3, keys: &[(f64, f64)]) -> Channel {
    Channel {
        joint: joint.into(),
        target: Target::Rotation,
        interpolation: Interpolation::Linear,
        times: keys.iter().map(|k| k.0).collect(),
        values: keys.iter().flat_map(|k| turn(axis, k.1)).collect(),
    }
}

/// Two seconds, looping: one ear flicks, the other sways, the head nods a little, the ribs breathe twice.
pub fn ear_breath() -> Clip {
    let twitch = [(0.0, 0.0), (0.3, 0.0), (0.42, 16.0), (0.54, -5.0), (0.68, 9.0), (0.9, 0.0), (2.0, 0.0)];
    let flick = [(0.0, 0.0), (0.36, 0.0), (0.48, 14.0), (0.62, -8.0), (0.78, 5.0), (1.0, 0.0), (2.0, 0.0)];
    let sway = [(0.0, 0.0), (0.5, 5.0), (1.0, 0.0), (1.5, -6.0), (2.0, 0.0)];
    let bend = [(0.0, 0.0), (0.6, 4.0), (1.1, 0.0), (1.6, -7.0), (2.0, 0.0)];
    let nod = [(0.0, 0.0), (0.7, 1.5), (1.4, -1.0), (2.0, 0.0)];
    let wag = [(0.0, 0.0), (1.1, 0.0), (1.2, 10.0), (1.32, -8.0), (1.45, 0.0), (2.0, 0.0)];
    // Cubic spline keys hold in-tangent, value, out-tangent; flat tangents at the turning points make an even breath.
    let breath = |x: f64| [[0.0; 3], [1.0 + x, 1.0 + 0.5 * x, 1.0 + x], [0.0; 3]];
    let ribs = [0.0, 0.045, 0.0, 0.045, 0.0];
    Clip {
        name: "EarBreath".into(),
        channels: vec![
            rotations(EAR_L, DVec3::Z, &twitch),
            rotations(EAR_L_TIP, DVec3::Z, &flick),
            rotations(EAR_R, DVec3::X, &sway),
            rotations(EAR_R_TIP, DVec3::X, &bend),
            rotations(HEAD, DVec3::X, &nod),
            rotations(TAIL, DVec3::X, &wag),
            Channel {
                joint: RIBS.into(),
                target: Target::Scale,
                interpolation: Interpolation::CubicSpline,
                times: (0..5).map(|k| f64::from(k) * 0.5).collect(),
                values: ribs.iter().flat_map(|&x| breath(x)).flatten().collect(),
            },
        ],
    }
}
