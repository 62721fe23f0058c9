//! Direction of hair on the faces of animals, as the default of a recipe lays it out.
#![allow(clippy::unwrap_used, reason = "tests")]

use glam::Vec3;
use pelage_bake::io::{Reach, read_model};
use pelage_bake::pipeline::{BakeInput, Layout, lay_out_model};
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::groom::MapImages;
use pelage_bake::stages::import::ImportOptions;
use pelage_needs::data;
use pelage_tests::binary::workspace;
use std::path::Path;

/// Face of a model at rest, metres.
struct Face {
    /// Tip of the nose.
    nose: Vec3,
    /// Point between the eyes.
    brow: Vec3,
    /// Radius around the line from nose to brow that belongs to the front of the face.
    radius: f32,
}

impl Face {
    /// Returns the place of a point along the line from nose to brow, 0..=1, if it is on the front of the face.
    fn along(&self, at: Vec3) -> Option<f32> {
        let line = self.brow - self.nose;
        let along = (at - self.nose).dot(line) / line.length_squared();
        let off = at.distance(self.nose + along * line);
        ((0.0..=1.0).contains(&along) && off < self.radius).then_some(along)
    }
}

/// Returns the positions along the bridge of the singular points on the front of a face, and the least cosine between
/// the hair on its bridge and the direction from nose to brow. The tenth of the line nearest to the nose is left out.
fn measure(path: &Path, face: &Face, set: Option<&str>) -> (Vec<f32>, f32) {
    let mut recipe = Recipe::default();
    set.into_iter().for_each(|set| recipe.set(set).unwrap());
    let images = MapImages::default();
    let model = read_model(path, &ImportOptions::default(), Reach::OwnFolder).unwrap();
    let layout: Layout<'_> = lay_out_model(&BakeInput::new("m", "m", &recipe, &images), &model).unwrap();
    let surface = &layout.surface;
    let singular = surface.singularities.iter().filter_map(|(at, _)| face.along(*at)).filter(|along| *along > 0.1);
    let (mut least, mut faces) = (f32::INFINITY, 0);
    for (triangle, _) in surface.mesh.triangles.iter().zip(&surface.patch_of_triangle).filter(|(_, p)| **p != u32::MAX)
    {
        let [a, b, c] = triangle.map(|v| surface.rest.positions[v as usize]);
        let [p, q, r] = triangle.map(|v| surface.tile_uvs[v as usize]);
        let (normal, middle) = ((b - a).cross(c - a).normalize_or_zero(), (a + b + c) / 3.0);
        // Hair is combed along +v of the tile.
        let (q, r) = (q - p, r - p);
        let combed = ((c - a) * q.x - (b - a) * r.x) * q.perp_dot(r).signum();
        let back = (face.brow - face.nose).reject_from_normalized(normal).normalize_or_zero();
        let is_bridge = normal.y > 0.3 && (middle.x - face.nose.x).abs() < 0.5 * face.radius;
        if is_bridge && face.along(middle).is_some_and(|along| along > 0.1) {
            least = least.min(combed.normalize_or_zero().dot(back));
            faces += 1;
        }
    }
    assert!(faces > 3, "{}: {faces} triangles on the bridge", path.display());
    (singular.collect(), least)
}

/// Checks a face at the default. Returns the same figures for one direction for the whole body.
fn check(model: &Path, face: &Face) -> (Vec<f32>, f32) {
    let (singular, least) = measure(model, face, None);
    let before = measure(model, face, Some("surface.comb=direction"));
    println!("{}: {singular:?} {least}; with one direction {before:?}", model.display());
    assert!(singular.is_empty() && least > 0.5, "{}: {singular:?} {least}", model.display());
    before
}

#[test]
fn hair_on_built_in_faces_is_combed_from_the_nose_to_the_brow() {
    let face = |nose: [f32; 3], brow: [f32; 3], radius| Face { nose: nose.into(), brow: brow.into(), radius };
    let before = [
        ("hare", face([0.0, 0.303, 0.148], [0.0, 0.355, 0.09], 0.03)),
        ("ox", face([0.0, 0.74, 1.72], [0.0, 1.0, 1.4], 0.12)),
        ("pony", face([0.0, 0.937, 0.897], [0.0, 1.15, 0.72], 0.06)),
    ]
    .map(|(name, face)| check(&workspace().join("assets/models").join(name).with_extension("glb"), &face));
    assert!(before[2].1 < 0.5, "one direction falls on the pony's forehead: {before:?}");
}

#[test]
fn hair_on_faces_of_known_animals_is_combed_from_the_nose_to_the_brow() {
    let Some(data) = data("hair_on_faces_of_known_animals_is_combed_from_the_nose_to_the_brow") else { return };
    let face = |nose: [f32; 3], brow: [f32; 3], radius| Face { nose: nose.into(), brow: brow.into(), radius };
    let before = [
        ("Fox", face([0.0, 53.7, 66.6], [0.0, 66.0, 50.0], 6.0)),
        ("quaternius_Cow", face([0.0, 3.116, 5.087], [0.0, 3.9, 4.5], 0.4)),
        ("quaternius_ShibaInu", face([-0.036, 2.58, 2.46], [-0.02, 2.75, 2.15], 0.15)),
    ]
    .map(|(name, face)| check(&data.join("meshes/skinned").join(name).with_extension("glb"), &face));
    let (singular, least) = &before[1];
    assert!(!singular.is_empty() && *least < -0.5, "one direction radiates on the cow's nose: {singular:?} {least}");
}
