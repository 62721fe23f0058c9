use super::*;
use crate::stages::fixtures::part;
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
            mesh.parts.push(MeshPart { names, ..part(wanted, first_triangle, triangle_count) });
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

/// Adds two squares with edges of 0.05 m, one at each side of x = 0, which face +z.
fn add_squares(model: &mut Model, material: usize, [x, y, z]: [f32; 3]) {
    let mesh = &mut model.mesh;
    let first_triangle = mesh.triangles.len();
    for x in [-x, x] {
        let base = mesh.positions.len() as u32;
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        mesh.positions.extend(corners.map(|(a, b)| Vec3::new(x + 0.025 * a, y + 0.025 * b, z)));
        mesh.normals.extend([Vec3::Z; 4]);
        mesh.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
    }
    mesh.parts.push(MeshPart { material, first_triangle, triangle_count: 4, ..MeshPart::default() });
}

#[test]
fn small_dark_pairs_in_the_face_are_eyes_whatever_their_material_name() {
    let with = |grey: f32, at: [f32; 3]| {
        let mut model = animal(|height| height > 0.985);
        model.mesh.parts.retain(|part| part.material != 2);
        model.mesh.triangles.truncate(model.mesh.parts.iter().map(|p| p.triangle_count).sum());
        for (number, material) in model.materials.iter_mut().enumerate() {
            material.name = format!("Material.{number:03}");
        }
        model.materials[2].base_color = [grey, grey, grey, 1.0];
        add_squares(&mut model, 2, at);
        names(model)
    };
    let face = [0.15, 0.4, 0.95];
    assert_eq!(with(0.01, face), ["Material.000/nose", "Material.001", "Material.002/eyes"]);
    let plain = ["Material.000", "Material.001", "Material.002"];
    assert_eq!(with(0.3, face), plain, "pale spots");
    assert_eq!(with(0.01, [0.15, -0.5, 0.95]), plain, "low on the body");
    assert_eq!(with(0.01, [0.15, 1.1, 0.0]), plain, "on the back");
}

/// Builds a body in one material, whose texture is brown with a row of black texels. Faces at the given directions
/// from its centre, within 0.1 m, show black.
fn painted(black: &[[f32; 3]]) -> Model {
    let mut model =
        Model { materials: vec![Material { name: "Atlas".into(), ..Material::default() }], ..Model::default() };
    add_ball(&mut model, Vec3::ZERO, 1.0, &["Mesh"], |_| 0);
    let brown = [124, 124, 124, 255];
    let rgba = [[10, 10, 10, 255], brown, brown, brown].concat();
    model.images = vec![std::sync::Arc::new(pelage_import::mesh::Image { width: 1, height: 4, rgba })];
    model.materials[0].base_color_image = Some(0);
    // Every triangle has vertices of its own, as a palette needs.
    let old = std::mem::take(&mut model.mesh);
    for triangle in &old.triangles {
        let corners = triangle.map(|v| old.positions[v as usize]);
        let middle = corners.into_iter().sum::<Vec3>() / 3.0;
        let is_black = black.iter().any(|at| middle.distance(Vec3::from(*at).normalize()) < 0.1);
        let first = model.mesh.positions.len() as u32;
        model.mesh.triangles.push([first, first + 1, first + 2]);
        model.mesh.positions.extend(corners);
        model.mesh.normals.extend([Vec3::Z; 3]);
        model.mesh.uvs.extend([glam::Vec2::new(0.5, if is_black { 0.125 } else { 0.625 }); 3]);
    }
    model.mesh.parts = old.parts;
    model
}

#[test]
fn paired_dark_texels_in_the_face_are_eyes_without_a_rig() {
    let eyes = [[-0.3, 0.4, 0.85], [0.3, 0.4, 0.85]];
    let found = split_materials(painted(&eyes));
    assert_eq!(found.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["Atlas", "Atlas/eyes"]);
    assert!((4..40).contains(&found[1].1), "{found:?}");
    let with_nose = [eyes[0], eyes[1], [0.0, 0.1, 1.0]];
    assert_eq!(names(painted(&with_nose)), ["Atlas", "Atlas/eyes"]);
    let mut rigged = painted(&eyes);
    rigged.mesh.skin = vec![pelage_formats::SkinVertex::default(); rigged.mesh.positions.len()];
    assert_eq!(names(rigged), ["Atlas"], "joints tell where the eyes of a rigged model are");
}

#[test]
fn dark_spots_of_a_coat_stay_furred() {
    let [left, right] = [[-0.3, 0.4, 0.85], [0.3, 0.4, 0.85]];
    let back = [[-0.6, 0.7, 0.0], [0.2, 0.9, 0.1], [0.1, 0.9, -0.5], [-0.5, 0.6, -0.7], [0.7, 0.6, -0.4]];
    let large = |x: f32| [0.0_f32, 0.15, 0.3].map(|step| [x * (1.0 + 2.0 * step), 0.4 + step, 0.85]);
    for (what, spots) in [
        ("one", vec![left]),
        ("many, as on a Dalmatian", [&[left, right], &back[..]].concat()),
        ("large, as on a cow", [large(-0.3), large(0.3)].concat()),
        ("one above the other", vec![left, [-0.3, 0.75, 0.6]]),
        ("on both flanks", vec![[-1.0, 0.3, 0.0], [1.0, 0.3, 0.0]]),
        ("low", vec![[-0.3, -0.4, 0.85], [0.3, -0.4, 0.85]]),
    ] {
        assert_eq!(names(painted(&spots)), ["Atlas"], "{what}");
    }
    let mut dark = painted(&[left, right]);
    dark.materials[0].base_color = [0.1, 0.1, 0.1, 1.0];
    assert_eq!(names(dark), ["Atlas", "Atlas/eyes"], "black beside dark brown");
    let mut pale = painted(&[left, right]);
    pale.images = vec![std::sync::Arc::new(pelage_import::mesh::Image { width: 1, height: 1, rgba: vec![90; 4] })];
    assert_eq!(names(pale), ["Atlas"], "equally dark everywhere");
}

#[test]
fn eyeballs_in_the_only_material_are_eyes_without_a_rig() {
    let with = |balls: &[([f32; 3], f32)]| {
        let mut model =
            Model { materials: vec![Material { name: "Atlas".into(), ..Material::default() }], ..Model::default() };
        add_ball(&mut model, Vec3::ZERO, 1.0, &["Mesh"], |_| 0);
        balls.iter().for_each(|(at, radius)| add_ball(&mut model, Vec3::from(*at), *radius, &["Mesh"], |_| 0));
        split_materials(model)
    };
    let [left, right] = [[-0.3, 0.4, 0.85], [0.3, 0.4, 0.85]];
    assert_eq!(with(&[(left, 0.06), (right, 0.06)]), [("Atlas".to_owned(), 1152), ("Atlas/eyes".to_owned(), 2304)]);
    for (what, balls) in [
        ("one", vec![(left, 0.06)]),
        ("unequal", vec![(left, 0.06), (right, 0.05)]),
        ("large", vec![(left, 0.2), (right, 0.2)]),
        ("low", vec![([-0.3, -0.4, 0.85], 0.06), ([0.3, -0.4, 0.85], 0.06)]),
    ] {
        assert_eq!(with(&balls).len(), 1, "{what}");
    }
}

#[test]
fn listed_nodes_and_joints_are_split_off() {
    let model = animal(|_| false);
    let list = |patterns: &[&str]| patterns.iter().map(|p| (*p).to_owned()).collect::<Vec<_>>();
    assert!(split_listed(&model, &list(&["Brown", "Eyes"])).is_none(), "materials need no split");
    let mut named = model;
    named.mesh.parts[0].names = vec!["Body".into()];
    for (part, name) in named.mesh.parts[1..].iter_mut().zip(["Left", "Right"]) {
        part.material = 1;
        part.names = vec![name.into()];
    }
    let split = split_listed(&named, &list(&["left"])).unwrap();
    let bare =
        |pattern: &str| split.materials.iter().filter(|m| is_named(pattern, m)).map(Material::full_name).collect();
    let found: Vec<String> = bare("left");
    assert_eq!(found, ["Brown/Left"]);
    let all: Vec<String> = bare("Brown");
    assert_eq!(all, ["Brown", "Brown/Left"]);
}
