use super::*;
use crate::recipe::Recipe;
use crate::stages::fixtures::{self, part};
use crate::stages::groom::{ImageCoordinates, Vertices};
use crate::stages::groom::{MapImages, Maps, colors};
use pelage_import::mesh::{Image, Material};

const RINGS: u32 = 24;
const SIDES_OF_RING: u32 = 12;

/// Builds a torus about the y axis with radii 0.3 m and 0.12 m, without texture coordinates, in two materials.
fn torus() -> Model {
    let mut mesh = fixtures::torus(RINGS, SIDES_OF_RING, false);
    let triangles = mesh.triangles.len();
    mesh.parts = vec![part(0, 0, triangles / 2), part(1, triangles / 2, triangles - triangles / 2)];
    let material = |name: &str| Material { name: name.into(), ..Material::default() };
    Model { mesh, materials: vec![material("coat"), material("other")], ..Model::default() }
}

/// Paints a smooth image over the atlas. The red channel has the values of `share` at the model's positions; green and
/// blue are 0.
fn painted(atlas: &ModelAtlas, side: u32, share: impl Fn(Vec3) -> f32 + Sync) -> Image {
    use crate::stages::groom::canvas::{Canvas, CanvasTriangle};
    let corners = |t: &[u32; 3]| t.map(|v| atlas.uv(v) * side as f32);
    let triangles = atlas.mesh.triangles.iter().zip(0..);
    let pieces = triangles.map(|(t, triangle)| CanvasTriangle { triangle, corners: corners(t) }).collect();
    let texels = Canvas::new(side, pieces, 4).paint(|spot, _| {
        let [a, b, c] = atlas.mesh.triangles[spot.triangle].map(|v| atlas.rest.positions[v as usize]);
        let place = a * spot.weights.x + b * spot.weights.y + c * spot.weights.z;
        glam::Vec4::new(share(place), 0.0, 0.0, 1.0)
    });
    crate::stages::groom::atlas::linear_image(side, &texels)
}

fn share(place: Vec3) -> f32 {
    (0.5 + place.x).clamp(0.0, 1.0)
}

#[test]
fn charts_lie_inside_the_texture_and_do_not_overlap() {
    let model = torus();
    let atlas = ModelAtlas::new("torus", &model).unwrap();
    assert_eq!(atlas.mesh.triangles.len(), model.mesh.triangles.len());
    assert!(atlas.mesh.uvs.iter().all(|uv| uv.min_element() > 0.0 && uv.max_element() < 1.0));
    assert_eq!((atlas.side, atlas.gutter), (1024, 8));
    let n = 512;
    let mut owners = vec![0u32; n * n];
    let mut area = 0.0;
    for triangle in &atlas.mesh.triangles {
        let [a, b, c] = triangle.map(|v| atlas.uv(v) * n as f32);
        let inside = |p: Vec2| {
            let side = |a: Vec2, b: Vec2| (b - a).perp_dot(p - a);
            let sides = [side(a, b), side(b, c), side(c, a)];
            sides.iter().all(|s| *s > 1e-3) || sides.iter().all(|s| *s < -1e-3)
        };
        area += (b - a).perp_dot(c - a).abs() / 2.0;
        for (y, x) in (0..n).flat_map(|y| (0..n).map(move |x| (y, x))) {
            owners[y * n + x] += u32::from(inside(Vec2::new(x as f32 + 0.5, y as f32 + 0.5)));
        }
    }
    assert!(owners.iter().all(|count| *count <= 1), "triangles lie on each other");
    assert!(area > 0.3 * (n * n) as f32, "{} of the texture is used", area / (n * n) as f32);
}

#[test]
fn every_vertex_has_its_coordinates_and_seams_have_several() {
    let model = torus();
    let atlas = ModelAtlas::new("torus", &model).unwrap();
    let standing = |v: usize| atlas.standing_for(&model.mesh, 0, v).len() + atlas.standing_for(&model.mesh, 1, v).len();
    let counts: Vec<usize> = (0..model.mesh.positions.len()).map(standing).collect();
    assert!(counts.iter().all(|c| *c >= 1) && counts.contains(&1) && counts.iter().any(|c| *c >= 2));
    let (corners, coordinates) = atlas.corner_coordinates();
    for (triangle, places) in atlas.mesh.triangles.iter().zip(&corners) {
        for (v, place) in triangle.iter().zip(places) {
            assert!(coordinates[*place as usize].contains(&atlas.uv(*v)));
        }
    }
}

#[test]
fn painted_maps_apply_at_the_painted_position() {
    let model = torus();
    let atlas = ModelAtlas::new("torus", &model).unwrap();
    let file = MapImages { images: [("l.png".to_owned(), painted(&atlas, 512, share))].into(), ..MapImages::default() };
    let text = "[groom]\ncoordinates = \"atlas\"\nlength = \"l.png\"\nbare = \"l.png\"\nwetness = \"l.png#g\"\n\
                comb = \"l.png\"\ncolor = \"l.png\"";
    let groom = Recipe::parse("r.toml", text).unwrap().groom;
    let mut warnings = Vec::new();
    let maps = Maps::new(&model.mesh, &model.materials, &[true; 2], &groom, &file, &mut warnings)
        .over(ImageCoordinates::Atlas(Box::new(atlas)));
    assert_eq!(warnings, [""; 0]);
    let rest = RestPose::of(&model.mesh, None);
    let coat = maps.vertex_groom(&Vertices::of_model(&model.mesh, &rest)).unwrap();
    let comb = maps.layout_maps(&model.mesh, &rest, Vec3::X).unwrap().comb.unwrap();
    for (v, place) in model.mesh.positions.iter().enumerate() {
        let expected = share(*place);
        for found in [coat.length[v], coat.bareness[v], (comb[v].x + 1.0) / 2.0] {
            assert!((found - expected).abs() < 0.01, "{place}: {found} instead of {expected}");
        }
        assert_eq!((coat.wetness[v], comb[v].y), (0.0, -1.0));
    }
    assert_eq!(maps.textures().unwrap().images.len(), 0, "what vertices say no texture says again");
    let colors = colors(&model, &Vertices::of_model(&model.mesh, &rest), &maps, &[true; 2], true).unwrap();
    let bright = (0..model.mesh.positions.len()).max_by(|a, b| coat.length[*a].total_cmp(&coat.length[*b])).unwrap();
    let [r, g, b, a] = colors.vertices[bright];
    assert!(colors.images.is_empty() && r > 150 && (g, b, a) == (0, 0, 255), "{:?}", colors.vertices[bright]);
}

#[test]
fn a_flow_image_points_along_the_atlas() {
    let model = torus();
    let atlas = ModelAtlas::new("torus", &model).unwrap();
    // The flow map points right on the image everywhere.
    let right = Image { width: 1, height: 1, rgba: vec![255, 128, 0, 255] };
    let file = MapImages { images: [("f.png".to_owned(), right)].into(), ..MapImages::default() };
    let groom = Recipe::parse("r.toml", "[groom]\ncoordinates = \"atlas\"\ncomb = \"f.png#uv\"").unwrap().groom;
    let maps = Maps::new(&model.mesh, &model.materials, &[true; 2], &groom, &file, &mut Vec::new())
        .over(ImageCoordinates::Atlas(Box::new(atlas.clone())));
    let comb = maps.layout_maps(&model.mesh, &RestPose::of(&model.mesh, None), Vec3::X).unwrap().comb.unwrap();
    let mut checked = 0;
    for triangle in &atlas.mesh.triangles {
        let [a, b, c] = triangle.map(|v| v as usize);
        let (uv, p) = (&atlas.mesh.uvs, &atlas.rest.positions);
        let (t1, t2, p1, p2) = (uv[b] - uv[a], uv[c] - uv[a], p[b] - p[a], p[c] - p[a]);
        let along_u = ((p1 * t2.y - p2 * t1.y) / t1.perp_dot(t2)).normalize();
        let inner = |v: &usize| {
            let model_vertex = model.mesh.positions.iter().position(|q| *q == p[*v])?;
            let stands = [0, 1].map(|m| atlas.standing_for(&model.mesh, m, model_vertex).len());
            (stands[0] + stands[1] == 1).then_some(model_vertex)
        };
        for v in [a, b, c].iter().filter_map(inner) {
            assert!(comb[v].normalize().dot(along_u) > 0.8, "{} against {along_u}", comb[v]);
            checked += 1;
        }
    }
    assert!(checked > 100, "{checked}");
}

#[test]
fn atlas_depends_only_on_the_mesh() {
    let model = torus();
    let atlas = ModelAtlas::new("torus", &model).unwrap();
    let other = Model { warnings: vec!["something".into()], nodes: Vec::new(), ..model.clone() };
    assert_eq!(ModelAtlas::new("another name", &other).unwrap().mesh, atlas.mesh);
    // Vertices are found even if the recipe duplicates them.
    let mut cut = model.mesh.clone();
    let copy = cut.copy_vertex(5) as usize;
    assert_eq!(atlas.standing_for(&cut, 0, copy), atlas.standing_for(&model.mesh, 0, 5));
}

#[test]
fn model_without_area_has_no_atlas() {
    let mut model = torus();
    model.mesh.positions.fill(Vec3::ZERO);
    assert!(ModelAtlas::new("torus", &model).unwrap_err().to_string().contains("torus"));
}
