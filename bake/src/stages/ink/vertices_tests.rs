use super::*;
use crate::recipe::{MaterialInk, Recipe};
use crate::stages::fixtures;
use pelage_import::mesh::Image;

/// Makes a sphere around the origin, with rings of vertices from pole to pole along y. The second half of the triangles
/// has another material.
fn sphere(radius: f32) -> (Mesh, RestPose) {
    let mut mesh = fixtures::ball(24, 32);
    mesh.positions.iter_mut().for_each(|p| *p *= radius);
    mesh.uvs = mesh.normals.iter().map(|n| Vec2::new(0.5, 0.5 + 0.5 * n.y)).collect();
    mesh.colors.fill([51, 102, 153, 255]);
    let half = mesh.triangles.len() / 2;
    let part = |material, first| MeshPart { has_uvs: true, ..fixtures::part(material, first, half) };
    mesh.parts = vec![part(0, 0), part(1, half)];
    let rest = RestPose { positions: mesh.positions.clone(), normals: mesh.normals.clone() };
    (mesh, rest)
}

fn materials() -> Vec<Material> {
    ["body", "eye"].map(|name| Material { name: name.into(), ..Material::default() }).to_vec()
}

fn evaluate(params: &InkParams, radius: f32, images: &MapImages) -> (InkVertices, Vec<String>) {
    let (mesh, rest) = sphere(radius);
    let canvas = InkTarget { mesh: &mesh, rest: &rest, radius, materials: &materials(), images };
    let mut warnings = Vec::new();
    (
        vertices(
            params,
            &InkShading { wash_speed: params.speed, wash_range: params.range, ..InkShading::default() },
            &canvas,
            &mut warnings,
        )
        .unwrap(),
        warnings,
    )
}

#[test]
fn wash_of_a_sphere_matches_the_formula() {
    // On a sphere of radius ρ, the wash product at an arc β from the centre is ρ (1 − cos β) as published, and sin(β/2)
    // in the normalised form.
    for radius in [0.01f32, 1.0, 250.0] {
        let params = InkParams { center: Some([0.0, radius, 0.0]), ..InkParams::default() };
        let (found, _) = evaluate(&params, radius, &MapImages::default());
        let (mesh, _) = sphere(radius);
        let mut pole = 0;
        for (vertex, normal) in found.vertices.iter().zip(&mesh.normals) {
            let cos = f64::from(normal.y).clamp(-1.0, 1.0);
            let (literal, angle) = (1.0 - cos, ((1.0 - cos) / 2.0).sqrt());
            let [a, b] = vertex.wash.map(|w| f64::from(w) / 32767.0);
            assert!((2.0 * a - literal).abs() < 1e-4, "{literal} came as {}", 2.0 * a);
            // At the centre itself, the direction is undefined, and 0 is stored.
            assert!((b - angle).abs() < 2e-3, "{angle} came as {b}");
            pole += u32::from(vertex.wash == [0, 0]);
        }
        assert!(pole >= 32, "CP lies on vertices, and their wash is 0");
    }
}

#[test]
fn distant_wash_centres_are_clamped_and_never_give_nan() {
    let params = InkParams { center: Some([0.0, 1e6, 0.0]), ..InkParams::default() };
    let (found, _) = evaluate(&params, 1.0, &MapImages::default());
    assert!(found.vertices.iter().all(|v| v.wash.iter().all(|w| *w > i16::MIN)));
    assert!(found.vertices.iter().any(|v| v.wash[0] == 32767) && found.vertices.iter().any(|v| v.wash[0] == -32767));
    assert_eq!(wash_product(Vec3::ZERO, Vec3::Y, Vec3::ZERO, 0.0), [0.0, 0.0]);
    let [a, b] = wash_product(Vec3::splat(f32::MAX), Vec3::Y, Vec3::splat(f32::MIN), 1e-20);
    assert!(a.is_finite() && b.is_finite());
}

#[test]
fn default_wash_centre_is_above_and_is_recorded() {
    let (found, warnings) = evaluate(&InkParams::default(), 3.0, &MapImages::default());
    assert!(found.center.y > 2.0 && warnings.is_empty(), "{} {warnings:?}", found.center);
    let again = InkParams { center: Some(found.center.into()), ..InkParams::default() };
    assert_eq!(evaluate(&again, 3.0, &MapImages::default()).0, found);
    assert!(found.vertices.iter().all(|v| (v.amount, v.solid, v.line, v.reserved) == (255, 0, 255, 0)));
}

#[test]
fn materials_are_blank_washed_or_inked() {
    let table = |name: &str, text: &str| {
        let recipe = format!("[[ink.material]]\nname = \"{name}\"\n{text}");
        Recipe::parse("r.toml", &recipe).unwrap().ink.material.remove(0)
    };
    let of = |material: Vec<MaterialInk>| {
        let params = InkParams { material, center: Some([0.0, 1.0, 0.0]), ..InkParams::default() };
        let (found, warnings) = evaluate(&params, 1.0, &MapImages::default());
        let of = |v: &InkVertex| (v.amount, v.solid, v.line);
        // Each pole belongs to one material, and the equator belongs to both.
        ([of(&found.vertices[0]), of(&found.vertices[24 * 33]), of(&found.vertices[12 * 33])], found, warnings)
    };
    assert_eq!(of(vec![]).0, [(255, 0, 255); 3]);
    assert_eq!(of(vec![table("EYE", "fill = \"solid\"\nline = 0.5")]).0[1], (255, 255, 128));
    let (shares, ..) = of(vec![table("e?e", "fill = \"blank\"")]);
    assert_eq!(shares, [(255, 0, 255), (0, 0, 255), (128, 0, 255)]);
    assert_eq!(
        of(vec![table("*", "fill = \"blank\""), table("eye", "fill = \"wash\"\namount = 0.2")]).0[1],
        (51, 0, 255)
    );
    assert_eq!(of(vec![table("eye", "fill = \"solid\"\namount = 0.4")]).0[1], (255, 102, 255));
    let (_, own, _) = of(vec![table("eye", "center = [0, -1, 0]")]);
    assert_eq!(
        (own.vertices[0].wash, own.vertices[24 * 33].wash),
        ([0, 0], [0, 0]),
        "each material has its own centre"
    );
    let (.., warnings) = of(vec![table("hoof", "fill = \"blank\"")]);
    assert!(
        warnings[0].contains("ink.material") && warnings[0].contains("hoof") && warnings[0].contains("body"),
        "{warnings:?}"
    );
}

#[test]
fn maps_are_read_at_the_vertices() {
    let mut images = MapImages::default();
    // The image is black in the upper half and white in the lower half.
    let rgba = [[0, 0, 0, 255].repeat(4), [255, 255, 255, 255].repeat(4)].concat();
    images.images.insert("m.png".into(), Image { width: 1, height: 8, rgba });
    let set = |lines: &[&str]| {
        let mut recipe = Recipe::default();
        lines.iter().for_each(|line| recipe.set(line).unwrap());
        assert!(recipe.images().len() <= 1, "{:?}", recipe.images());
        evaluate(&recipe.ink, 1.0, &images).0
    };
    let found = set(&["ink.wash=m.png", "ink.solid=vertex#g", "ink.lines=0.25"]);
    let texel = |v: usize| (found.vertices[v].amount, found.vertices[v].solid, found.vertices[v].line);
    // At the lower pole, v is 0, the upper border of the image. The image repeats, so its first and last row meet
    // there.
    assert_eq!(texel(6 * 33), (255, 102, 64));
    assert_eq!(texel(18 * 33), (0, 102, 64));
    assert!(found.center.y > -0.75, "the centre is sought where there is wash: {}", found.center);
    assert_eq!(set(&["ink.wash=0"]).center, Vec3::ZERO);
}
