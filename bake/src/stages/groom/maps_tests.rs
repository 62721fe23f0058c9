use super::*;
use crate::recipe::{Channel, Recipe};
use crate::stages::fixtures;

/// Builds a square of two triangles that share the diagonal, in the materials "skin" and "Nose". Texture coordinates
/// are (x, 1 − y).
fn square() -> (Mesh, Vec<Material>, RestPose) {
    let positions = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]].map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec();
    let part = |material| {
        let source = format!("part {material}");
        MeshPart { source, has_uvs: true, ..fixtures::part(material, material, 1) }
    };
    let mesh = Mesh {
        normals: vec![Vec3::Z; 4],
        uvs: positions.iter().map(|p| Vec2::new(p.x, 1.0 - p.y)).collect(),
        colors: vec![[0, 51, 102, 255], [255, 51, 102, 0], [255, 51, 102, 51], [0, 51, 102, 51]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        parts: vec![part(0), part(1)],
        positions,
        ..Mesh::default()
    };
    let material = |name: &str| Material { name: name.into(), ..Material::default() };
    let rest = RestPose::of(&mesh, None);
    (mesh, vec![material("skin"), material("Nose")], rest)
}

/// Creates an image of one row.
fn row(texels: &[[u8; 4]]) -> Image {
    Image { width: texels.len() as u32, height: 1, rgba: texels.concat() }
}

fn images() -> MapImages {
    let mut images = MapImages::default();
    // The red channel is 0 on the left and 255 on the right; the green channel is 0.6 everywhere. As a flow map, the
    // image points to the lower right.
    images.images.insert("a.png".into(), row(&[[0, 153, 0, 255], [255, 153, 0, 255]]));
    images.images.insert("flow.png".into(), row(&[[255, 0, 128, 255]]));
    images
}

struct Evaluated {
    lay: LayoutMaps,
    coat: VertexGroom,
    textures: GroomTextures,
    water: FurWetness,
    warnings: Vec<String>,
}

fn evaluate(recipe: &str, furred: [bool; 2]) -> Evaluated {
    let groom = Recipe::parse("r.toml", recipe).unwrap().groom;
    let (mesh, materials, rest) = square();
    let (images, mut warnings) = (images(), Vec::new());
    let maps = Maps::new(&mesh, &materials, &furred, &groom, &images, &mut warnings);
    Evaluated {
        lay: maps.layout_maps(&mesh, &rest, Vec3::X).unwrap(),
        coat: maps.vertex_groom(&Vertices::of_model(&mesh, &rest)).unwrap(),
        textures: maps.textures().unwrap(),
        water: maps.fur_wetness(),
        warnings,
    }
}

#[test]
fn empty_groom_changes_nothing() {
    let found = evaluate("", [true, true]);
    assert_eq!(found.lay, LayoutMaps::default());
    let zero = vec![0.0; 4];
    assert_eq!(
        found.coat,
        VertexGroom { length: vec![1.0; 4], lean: zero.clone(), wetness: zero.clone(), bareness: zero }
    );
    assert_eq!((found.textures.images.len(), found.water), (0, FurWetness::Dry));
    assert_eq!(evaluate("", [true, false]).coat.length, [1.0, 1.0, 1.0, 0.0], "a bare material has no hair");
}

#[test]
fn constants_vertex_colours_and_images_are_read() {
    let text =
        "[groom]\nlength = \"vertex#a\"\nlean = 0.25\nwetness = \"vertex#b\"\nbare = \"vertex\"\ndensity = \"a.png\"";
    let found = evaluate(text, [true, true]);
    assert_eq!(found.coat.length, [1.0, 0.0, 0.2, 0.2]);
    assert_eq!(found.coat.lean, [0.25; 4]);
    assert_eq!(found.coat.wetness, [0.4; 4]);
    assert_eq!(found.coat.bareness, [0.0, 1.0, 1.0, 0.0]);
    // At u = 0 and u = 1, a repeating image mixes its left and right side to 0.5, which is a density of 1.
    assert_eq!(found.lay.density.unwrap(), [1.0; 4]);
    assert_eq!((found.textures.images.len(), found.water), (0, FurWetness::Mixed));
    let lengths = evaluate("[groom]\nlength = \"a.png#g\"", [true, true]).coat.length;
    assert!(lengths.iter().all(|l| (l - 0.6).abs() < 1e-6), "{lengths:?}");
}

#[test]
fn tables_for_materials_win_and_shared_vertices_take_the_mean() {
    let text = "[groom]\nlength = 0.5\ndensity = 2\n[[groom.material]]\nname = \"*\"\nlength = 0.25\n\
                [[groom.material]]\nname = \"nose?\"\nlength = 0\n\
                [[groom.material]]\nname = \"NOSE\"\nlength = 0.75\ndensity = 4";
    let found = evaluate(text, [true, true]);
    assert_eq!(found.coat.length, [0.5, 0.25, 0.5, 0.75]);
    assert_eq!(found.lay.density.unwrap(), [3.0, 2.0, 3.0, 4.0]);
    assert!(
        matches!(&found.warnings[..], [one] if one.contains("nose?") && one.contains("skin")),
        "{:?}",
        found.warnings
    );
}

#[test]
fn body_groom_applies_where_no_map_is_set() {
    let body = BodyGroom {
        length: vec![0.5, 1.0, 0.25, 0.75],
        lean: vec![0.5; 4],
        density: Some(vec![2.0; 4]),
        ..BodyGroom::default()
    };
    let with = |text: &str, body: &BodyGroom| {
        let groom = Recipe::parse("r.toml", text).unwrap().groom;
        let (mesh, materials, rest) = square();
        let images = images();
        let maps = Maps::new(&mesh, &materials, &[true, true], &groom, &images, &mut Vec::new());
        let maps = maps.with_body(Some(body.clone()));
        // The vertices of the surface are in another order than those of the model.
        (
            maps.vertex_groom(&Vertices { input_vertex: Some(&[3, 2, 1, 0]), ..Vertices::of_model(&mesh, &rest) })
                .unwrap(),
            maps.layout_maps(&mesh, &rest, Vec3::X).unwrap(),
            maps.decision(1.0, 0.01),
        )
    };
    let (coat, lay, said) = with("", &body);
    assert_eq!(
        (coat.length, coat.lean, lay.density.unwrap()),
        (vec![0.75, 0.25, 1.0, 0.5], vec![0.5; 4], vec![2.0; 4])
    );
    assert!(said.is_some());
    let (coat, lay, said) = with("[groom]\nlength = 0.5\nlean = 0.25\ndensity = 3", &body);
    assert_eq!((coat.length, coat.lean, lay.density.unwrap()), (vec![0.5; 4], vec![0.25; 4], vec![3.0; 4]));
    assert_eq!(said, None);
    // A table for one material overrides the automatic groom on that material only. Vertices shared by both materials
    // have the mean of both values.
    let (coat, _, said) = with("[[groom.material]]\nname = \"Nose\"\nlength = 1", &body);
    assert_eq!(coat.length, [0.875, 0.25, 1.0, 1.0]);
    assert!(said.is_some());
    let (_, lay, _) = with("", &BodyGroom { density: None, ..body.clone() });
    assert_eq!(lay, LayoutMaps::default());
}

#[test]
fn tables_for_joints_win_over_maps_and_body() {
    let text = "[groom]\nlean = 0.5\nwetness = \"a.png#g\"\n[[groom.joint]]\nname = \"ear\"\nlength = 0.5\nlean = 0\n\
        density = 2\nwetness = 1\nbare = 0.5";
    let groom = Recipe::parse("r.toml", text).unwrap().groom;
    let (mut mesh, materials, rest) = square();
    let node = fixtures::node("Ear", None);
    let other = pelage_formats::Node { name: "Back".into(), ..node.clone() };
    let joints = [0, 1].map(|node| pelage_formats::Joint { node, inverse_bind: [0.0; 16] }).to_vec();
    let animation = pelage_formats::Animation { nodes: vec![node, other], joints, ..Default::default() };
    let follow =
        |weight: f32| pelage_formats::SkinVertex { joints: [0, 1, 0, 0], weights: [weight, 1.0 - weight, 0.0, 0.0] };
    mesh.skin = [0.0, 0.5, 1.0, 0.0].map(follow).to_vec();
    let (images, mut warnings) = (images(), Vec::new());
    let body = BodyGroom { length: vec![0.25; 4], lean: vec![1.0; 4], ..BodyGroom::default() };
    let maps = Maps::new(&mesh, &materials, &[true, false], &groom, &images, &mut warnings)
        .with_joints(JointValues::new(&groom.joint, Some(&animation), &mut warnings))
        .with_body(Some(body));
    assert_eq!(warnings, Vec::<String>::new());
    let coat = maps.vertex_groom(&Vertices::of_model(&mesh, &rest)).unwrap();
    assert_eq!(coat.length, [0.25, 0.375, 0.5, 0.0], "the last vertex is on no furred material");
    assert_eq!(coat.lean, [0.5, 0.25, 0.0, 0.0]);
    assert_eq!(coat.wetness, [0.0, 0.5, 1.0, 0.0], "to which the texture's is added");
    assert_eq!(coat.bareness, [0.0, 0.25, 0.5, 0.0]);
    assert_eq!(maps.layout_maps(&mesh, &rest, Vec3::X).unwrap().density.unwrap(), [1.0, 1.5, 2.0, 1.0]);
}

#[test]
fn combs_are_rest_pose_vectors_or_image_flow() {
    let comb = |comb: &str| evaluate(&format!("[groom]\ncomb = {comb}"), [true, true]).lay.comb.unwrap();
    assert_eq!(comb("[0, -2, 0]"), [Vec3::new(0.0, -2.0, 0.0); 4]);
    assert!(comb("\"vertex\"").iter().all(|v| (*v - Vec3::new(v.x, -0.6, -0.2)).length() < 1e-6));
    // On the image, right is +x and up is +y. Red 1 and green 0 therefore point to the lower right.
    for v in comb("\"flow.png#uv\"") {
        assert!((v.normalize() - Vec3::new(1.0, -1.0, 0.0).normalize()).length() < 1e-2, "{v}");
    }
    // Materials without a comb map use the comb direction of the surface. Vertices on the diagonal have the mean of
    // both materials.
    let nose = evaluate("[[groom.material]]\nname = \"Nose\"\ncomb = [0, 1, 0]", [true, true]).lay.comb.unwrap();
    assert_eq!(nose, [Vec3::new(0.5, 0.5, 0.0), Vec3::X, Vec3::new(0.5, 0.5, 0.0), Vec3::Y]);
    assert!((comb("\"flow.png\"")[0] - Vec3::new(1.0, -1.0, 0.0)).length() < 0.01);
}

#[test]
fn bareness_and_wetness_images_share_one_texture_per_pair() {
    let text = "[groom]\nbare = \"a.png\"\n[[groom.material]]\nname = \"Nose\"\nwetness = \"a.png#g\"";
    let found = evaluate(text, [true, true]);
    assert_eq!(found.textures.of_material, [Some(0), Some(1)]);
    assert_eq!(found.textures.images[0], row(&[[255, 0, 0, 255], [0, 0, 0, 255]]));
    assert_eq!(found.textures.images[1], row(&[[255, 153, 0, 255], [0, 153, 0, 255]]));
    assert_eq!((found.coat.bareness, found.coat.wetness), (vec![0.0; 4], vec![0.0; 4]), "the texture says it");
    let shared = evaluate("[groom]\nbare = \"a.png\"", [true, true]).textures;
    assert_eq!((shared.of_material, shared.images.len()), (vec![Some(0), Some(0)], 1));
    assert_eq!(evaluate("[groom]\nbare = \"a.png\"", [true, false]).textures.of_material, [Some(0), None]);
}

#[test]
fn images_without_texture_coordinates_are_ignored_with_a_warning() {
    let groom = Recipe::parse("r.toml", "[groom]\nlength = \"a.png\"\ncomb = \"flow.png#uv\"").unwrap().groom;
    let (mut mesh, materials, rest) = square();
    mesh.parts.iter_mut().for_each(|p| p.has_uvs = false);
    mesh.uvs.fill(Vec2::ZERO);
    let (images, mut warnings) = (images(), Vec::new());
    let maps = Maps::new(&mesh, &materials, &[true; 2], &groom, &images, &mut warnings);
    assert_eq!(maps.vertex_groom(&Vertices::of_model(&mesh, &rest)).unwrap().length, [1.0; 4]);
    assert_eq!(maps.layout_maps(&mesh, &rest, Vec3::X).unwrap().comb.unwrap(), [Vec3::ZERO; 4]);
    assert!(warnings.len() == 2 && warnings[0].contains("part 0") && warnings[0].contains("a.png"), "{warnings:?}");
}

#[test]
fn missing_map_image_is_an_error() {
    let groom = GroomParams {
        length: ScalarMap::Image { path: "b.png".into(), channel: Channel::Red },
        ..GroomParams::default()
    };
    let (mesh, materials, rest) = square();
    let images = images();
    let maps = Maps::new(&mesh, &materials, &[true; 2], &groom, &images, &mut Vec::new());
    assert!(maps.vertex_groom(&Vertices::of_model(&mesh, &rest)).unwrap_err().to_string().contains("b.png"));
}

#[test]
fn wetness_maps_classify_as_dry_wet_or_mixed() {
    let water = |text: &str, furred| evaluate(text, furred).water;
    assert_eq!(water("[groom]\nwetness = 1", [true, true]), FurWetness::Wet);
    assert_eq!(water("[groom]\nwetness = 0.5", [true, true]), FurWetness::Mixed);
    let nose = "[[groom.material]]\nname = \"Nose\"\nwetness = 1";
    assert_eq!([water(nose, [true, true]), water(nose, [false, true])], [FurWetness::Mixed, FurWetness::Wet]);
    assert_eq!(water(nose, [true, false]), FurWetness::Dry);
    // For wetness by joint, only the tables count. A package without the model's joint names therefore gives the same
    // result.
    let joint = |wetness: f32| format!("[[groom.joint]]\nname = \"*\"\nwetness = {wetness}");
    assert_eq!([water(&joint(0.0), [true; 2]), water(&joint(1.0), [true; 2])], [FurWetness::Dry, FurWetness::Mixed]);
    let all = format!("[groom]\nwetness = 1\n{}", joint(1.0));
    assert_eq!(water(&all, [true; 2]), FurWetness::Wet);
    let groom = Recipe::parse("r.toml", &joint(1.0)).unwrap().groom;
    assert_eq!(FurWetness::of(&groom, &["skin"]), FurWetness::Mixed);
}

#[test]
fn projected_images_need_no_texture_coordinates() {
    let (mut mesh, materials, rest) = square();
    mesh.parts.iter_mut().for_each(|part| part.has_uvs = false);
    let bounds = crate::stages::groom::bounds(&rest);
    let text = "[groom]\ncoordinates = \"z\"\nlength = \"a.png\"\nlean = \"a.png#g\"\nbare = \"a.png\"\n\
                comb = \"flow.png#uv\"\ncolor = \"a.png\"\ndensity = \"a.png\"";
    let groom = Recipe::parse("r.toml", text).unwrap().groom;
    let (images, mut warnings) = (images(), Vec::new());
    let along = groom.coordinates.projection().unwrap();
    let maps = Maps::new(&mesh, &materials, &[true, true], &groom, &images, &mut warnings)
        .over(ImageCoordinates::Space { along, bounds });
    assert_eq!(warnings, [""; 0]);
    let at = Vertices::of_model(&mesh, &rest);
    let coat = maps.vertex_groom(&at).unwrap();
    // Seen from +z, the image is black on the left and white on the right.
    assert_eq!((&coat.length[..], &coat.bareness[..]), (&[0.0, 1.0, 1.0, 0.0][..], &[0.0, 1.0, 1.0, 0.0][..]));
    assert!(coat.lean.iter().all(|lean| (lean - 0.6).abs() < 1e-6), "{:?}", coat.lean);
    assert!(maps.textures().unwrap().images.is_empty(), "what vertices say no texture says again");
    let lay = maps.layout_maps(&mesh, &rest, Vec3::X).unwrap();
    assert_eq!(lay.density.unwrap(), [0.25, 4.0, 4.0, 0.25]);
    // The flow map's red channel points right on the image, and its green channel points down. Seen along z, this is +x
    // and −y.
    assert!(lay.comb.unwrap().iter().all(|d| d.distance(Vec3::new(1.0, -1.0, 0.0)) < 1e-6));
    let color = maps.color_at(&images.images["a.png"], &at, &mesh.parts[0], 1).unwrap();
    assert!(color.x == 1.0 && color.z == 0.0, "{color}");
}
