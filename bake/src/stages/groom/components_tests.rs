use super::*;
use crate::stages::fixtures::{self, node};
use crate::stages::groom::split_listed;
use pelage_formats::{Joint, SkinVertex};
use pelage_import::mesh::{Material, Mesh, MeshPart};

/// Nodes of the skeleton: name and parent.
const NODES: [(&str, Option<u32>); 5] =
    [("Spine", None), ("Head", Some(0)), ("Eye_L", Some(1)), ("EyeLash_L", Some(1)), ("Ear_L", Some(1))];

/// Appends a sphere of 12 rings that follows one joint, and returns its triangles.
fn add_ball(mesh: &mut Mesh, joint: u16, center: Vec3, radius: f32) -> std::ops::Range<usize> {
    let first = mesh.triangles.len();
    fixtures::add_ball(mesh, center, radius, 0);
    mesh.skin.resize(mesh.positions.len(), SkinVertex { joints: [joint, 0, 0, 0], weights: [1.0, 0.0, 0.0, 0.0] });
    first..mesh.triangles.len()
}

/// Builds a head of radius 1 m in one material, and a ball for each entry: joint, centre, radius. Returns also the
/// triangles of each ball.
fn avatar(balls: &[(u16, Vec3, f32)]) -> (Model, Vec<std::ops::Range<usize>>) {
    let inverse_bind = glam::Mat4::IDENTITY.to_cols_array();
    let joints = (0..NODES.len() as u32).map(|node| Joint { node, inverse_bind }).collect();
    let animation =
        Animation { nodes: NODES.map(|(name, parent)| node(name, parent)).to_vec(), joints, ..Animation::default() };
    let mut mesh = Mesh::default();
    add_ball(&mut mesh, 1, Vec3::ZERO, 1.0);
    let ranges = balls.iter().map(|(joint, center, radius)| add_ball(&mut mesh, *joint, *center, *radius)).collect();
    mesh.parts.push(MeshPart { triangle_count: mesh.triangles.len(), ..MeshPart::default() });
    let materials = vec![Material { name: "Atlas".into(), ..Material::default() }];
    (Model { mesh, materials, animation: Some(animation), ..Model::default() }, ranges)
}

/// Returns the feature of each ball, and checks that all its triangles have the same one and the head has none.
fn features(balls: &[(u16, Vec3, f32)]) -> Vec<Option<Feature>> {
    let (model, ranges) = avatar(balls);
    let found = bare_components(&model, &RestPose::of(&model.mesh, model.animation.as_ref()));
    let first = ranges.first().map_or(0, |range| range.start);
    assert!(found.keys().all(|triangle| *triangle >= first), "the head is furred");
    let of = |range: std::ops::Range<usize>| {
        let features: Vec<_> = range.map(|triangle| found.get(&triangle).cloned()).collect();
        assert!(features.iter().all(|feature| *feature == features[0]));
        features[0].clone()
    };
    ranges.into_iter().map(of).collect()
}

#[test]
fn components_of_bare_joints_and_inside_the_head_are_bare() {
    let joint = |name: &str| Some(Feature::Joint(name.into()));
    let balls = [
        (2, Vec3::new(0.3, 0.3, 0.9), 0.15),
        (3, Vec3::new(0.3, 0.5, 0.95), 0.05),
        (1, Vec3::new(0.0, -0.3, 0.5), 0.1),
        (1, Vec3::new(-0.3, 0.3, 0.86), 0.1),
        (4, Vec3::new(-0.5, 1.0, 0.0), 0.18),
        (1, Vec3::new(0.5, 1.0, 0.0), 0.18),
        (0, Vec3::new(0.0, 0.0, 0.0), 0.15),
        (1, Vec3::ZERO, 0.5),
    ];
    let expected =
        [joint("Eye_L"), joint("EyeLash_L"), Some(Feature::InHead), Some(Feature::InHead), None, None, None, None];
    let names =
        ["eye", "lash", "tongue", "eyeball", "ear joint", "ear of the head's joint", "in the spine", "too large"];
    for ((found, expected), name) in features(&balls).into_iter().zip(expected).zip(names) {
        assert_eq!(found, expected, "{name}");
    }
}

#[test]
fn listed_joints_include_their_children() {
    let (model, ranges) = avatar(&[(4, Vec3::new(-0.5, 1.0, 0.0), 0.18)]);
    let list = |name: &str| split_listed(&model, &[name.to_owned()]);
    let split = list("Ear*").unwrap();
    let names: Vec<String> = split.materials.iter().map(Material::full_name).collect();
    assert_eq!(names, ["Atlas", "Atlas/Ear_L"]);
    let of_ear: usize = split.mesh.parts.iter().filter(|p| p.material == 1).map(|p| p.triangle_count).sum();
    assert_eq!(of_ear, ranges[0].len());
    assert_eq!(list("Head").unwrap().materials.len(), 1, "the head and all that follows its joint");
    assert!(list("Tail").is_none());
}
