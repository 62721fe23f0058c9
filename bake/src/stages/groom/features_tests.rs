#![allow(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;
use glam::Vec3;

/// Name and grey of the materials: black, brown, and the white of eyes.
const COLORS: [(&str, f32); 3] = [("Black", 0.02), ("Brown", 0.2), ("Eyes", 0.8)];

/// Appends a sphere with its poles along z, as one part per material.
///
/// * `material`: selects the material by the z coordinate of a triangle's centre relative to the sphere's, in radii
fn add_ball(model: &mut Model, center: Vec3, radius: f32, names: &[&str], material: impl Fn(f32) -> usize) {
    let (rings, sides) = (24u32, 24u32);
    let mesh = &mut model.mesh;
    let base = mesh.positions.len() as u32;
    for (i, j) in (0..=rings).flat_map(|i| (0..sides).map(move |j| (i, j))) {
        let (a, b) = (std::f32::consts::PI * i as f32 / rings as f32, std::f32::consts::TAU * j as f32 / sides as f32);
        let ring = if i == 0 || i == rings { 0.0 } else { a.sin() };
        mesh.positions.push(center + radius * Vec3::new(ring * b.cos(), ring * b.sin(), a.cos()));
        mesh.normals.push(Vec3::Z);
    }
    for wanted in 0..COLORS.len() {
        let first_triangle = mesh.triangles.len();
        for (i, j) in (0..rings).flat_map(|i| (0..sides).map(move |j| (i, j))) {
            let at = |i: u32, j: u32| base + i * sides + j % sides;
            let height = (std::f32::consts::PI * (i as f32 + 0.5) / rings as f32).cos();
            if material(height) == wanted {
                mesh.triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
                mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
            }
        }
        let triangle_count = mesh.triangles.len() - first_triangle;
        if triangle_count > 0 {
            let names = names.iter().map(|name| (*name).to_owned()).collect();
            mesh.parts.push(MeshPart {
                material: wanted,
                names,
                first_triangle,
                triangle_count,
                ..MeshPart::default()
            });
        }
    }
}

/// Builds a brown sphere with eyes in front. Triangles are black where `is_black` returns true for their z coordinate.
fn animal(is_black: impl Fn(f32) -> bool) -> Model {
    let material = |(name, grey): (&str, f32)| Material {
        name: name.into(),
        base_color: [grey, grey, grey, 1.0],
        ..Material::default()
    };
    let mut model = Model { materials: COLORS.map(material).to_vec(), ..Model::default() };
    add_ball(&mut model, Vec3::ZERO, 1.0, &["Mesh"], |height| usize::from(!is_black(height)));
    for x in [-0.4, 0.4] {
        add_ball(&mut model, Vec3::new(x, 0.4, 0.85), 0.1, &["Mesh"], |_| 2);
    }
    model
}

/// Splits a model's materials. Returns the full name of each resulting material, with its number of triangles.
fn split_materials(mut model: Model) -> Vec<(String, usize)> {
    let sorted = |model: &Model| {
        let mut triangles = model.mesh.triangles.clone();
        triangles.sort_unstable();
        triangles
    };
    let before = sorted(&model);
    split_features(&mut model);
    assert_eq!(sorted(&model), before, "no triangle is lost");
    let mut first = 0;
    for part in &model.mesh.parts {
        assert_eq!(part.first_triangle, first);
        first += part.triangle_count;
    }
    assert_eq!(first, before.len());
    let count = |m: usize| model.mesh.parts.iter().filter(|p| p.material == m).map(|p| p.triangle_count).sum();
    model.materials.iter().enumerate().map(|(m, material)| (material.full_name(), count(m))).collect()
}

fn names(model: Model) -> Vec<String> {
    split_materials(model).into_iter().filter(|(_, count)| *count > 0).map(|(name, _)| name).collect()
}

#[test]
fn a_dark_tip_before_the_eyes_is_a_nose() {
    assert_eq!(names(animal(|height| height > 0.985)), ["Black/nose", "Brown", "Eyes"]);
}

#[test]
fn the_tip_of_a_tail_stays_with_its_material() {
    let told = split_materials(animal(|height| !(-0.985..0.985).contains(&height)));
    let names: Vec<&str> = told.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["Black", "Brown", "Eyes", "Black/nose"]);
    assert_eq!(told[0].1, told[3].1, "both ends are alike");
    assert_eq!(self::names(animal(|height| height < -0.985)), ["Black", "Brown", "Eyes"], "a tail alone");
}

#[test]
fn large_pale_or_eyeless_tips_are_not_noses() {
    let untouched = ["Black", "Brown", "Eyes"];
    assert_eq!(names(animal(|height| height > 0.9)), untouched, "a mask of 5 %");
    let mut pale = animal(|height| height > 0.985);
    pale.materials[0].base_color = [0.12, 0.12, 0.12, 1.0];
    assert_eq!(names(pale), untouched);
    let mut dark = animal(|height| height > 0.985);
    dark.materials[1].base_color = [0.03, 0.03, 0.03, 1.0];
    assert_eq!(names(dark), untouched, "as dark as what is beside it");
    let mut blind = animal(|height| height > 0.985);
    blind.materials[2].name = "White".into();
    blind.mesh.parts.last_mut().unwrap().material = 1;
    assert_eq!(names(blind), ["Black", "Brown", "White"]);
    let mut named = animal(|height| height > 0.985);
    named.materials[0].name = "Muzzle".into();
    assert_eq!(names(named), ["Muzzle", "Brown", "Eyes"], "a snout is furred as often as not");
}

#[test]
fn eye_nodes_are_split_off_whatever_their_material_name() {
    let mut model = animal(|_| false);
    model.materials[2].name = "Main".into();
    let mut parts = model.mesh.parts.iter_mut();
    parts.next().unwrap().material = 2;
    parts.next().unwrap().names = vec!["Eye_L".into()];
    parts.next().unwrap().names = vec!["Eye_R".into(), "Sphere".into()];
    assert_eq!(names(model.clone()), ["Main", "Main/Eye_L", "Main/Eye_R"]);
    // If a mesh part covers a whole material, the name of its mesh decides.
    model.mesh.parts[0].material = 1;
    assert_eq!(names(model), ["Brown", "Main"]);
}
