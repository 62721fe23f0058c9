use super::*;
use crate::recipe::Recipe;
use crate::stages::fixtures;
use crate::stages::groom::{Colors, MapImages, Maps, Vertices, bounds, colors};
use pelage_import::mesh::{Material, Model, RestPose};

/// Builds a sphere of radius 1 m without texture coordinates. The vertices along one meridian are duplicated.
fn ball() -> Model {
    let mut mesh = fixtures::ball(32, 64);
    mesh.parts = vec![fixtures::part(0, 0, mesh.triangles.len())];
    let material = Material { base_color: [0.25, 0.125, 0.0625, 1.0], ..Material::default() };
    Model { mesh, materials: vec![material], ..Model::default() }
}

fn spread(model: &Model, marks: &str, drawn: &[CombLine]) -> (MarkValues, Vec<String>) {
    let recipe = Recipe::parse("r.toml", &format!("[surface]\ncomb_marks = [{marks}]\n")).unwrap();
    let rest = RestPose::of(&model.mesh, None);
    let bounds = bounds(&rest);
    let body = Body { mesh: &model.mesh, rest: &rest, animation: None, furred: &[true], bounds: &bounds };
    let mut warnings = Vec::new();
    let values = MarkValues::new(&recipe.surface.comb_marks, drawn, &body, &mut warnings);
    (values, warnings)
}

/// Returns the vertex nearest to a point.
fn at(model: &Model, place: Vec3) -> usize {
    let away = |v: &usize| model.mesh.positions[*v].distance(place);
    (0..model.mesh.positions.len()).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap()
}

/// Returns the point on the sphere's equator at that angle from the front, radians.
fn on_equator(angle: f32) -> Vec3 {
    Vec3::new(angle.sin(), 0.0, angle.cos())
}

#[test]
fn mark_value_holds_at_its_position_and_fades_outwards() {
    let model = ball();
    let (values, warnings) = spread(&model, "{ name = \"a\", at = [0, 0, 1.02], length = 0.25, reach_m = 1 }", &[]);
    assert_eq!((warnings, values.lean.len(), values.has_color()), (Vec::new(), 0, false));
    let length = |angle: f32| blend_marks(&values.length, at(&model, on_equator(angle)), 0.75);
    assert!((length(0.0) - 0.25).abs() < 1e-3 && (length(0.2) - 0.25).abs() < 0.02, "{} {}", length(0.0), length(0.2));
    assert!((length(0.62) - 0.5).abs() < 0.06, "half the way between: {}", length(0.62));
    assert_eq!([length(1.3), length(3.1)], [0.75; 2]);
    let way: Vec<f32> = (0..30).map(|k| length(0.05 * k as f32)).collect();
    assert!(way.windows(2).all(|s| s[1] >= s[0] - 1e-4 && s[1] - s[0] < 0.1), "{way:?}");
    // The result is symmetric around the mark, and equal on both sides of the seam.
    let turned = |angle: f32, about: f32| Vec3::new(angle.sin() * about.cos(), angle.sin() * about.sin(), angle.cos());
    for about in [0.0, 0.7, 1.6, 2.5, 3.9, 5.0] {
        let here = blend_marks(&values.length, at(&model, turned(0.5, about)), 0.75);
        assert!((here - length(0.5)).abs() < 0.05, "{about}: {here} and {}", length(0.5));
    }
    let (places, front) = (&model.mesh.positions, at(&model, on_equator(0.0)));
    let seam: Vec<usize> = (0..places.len()).filter(|v| places[*v] == places[front]).collect();
    assert!(seam.len() == 2 && values.length[seam[0]] == values.length[seam[1]], "{seam:?}");
}

#[test]
fn overlapping_marks_are_blended() {
    let model = ball();
    let list = "{ name = \"a\", at = [0, 0, 1], length = 1, density = 4, reach_m = 1.2 }, \
                { name = \"b\", at = [1, 0, 0], length = 0, reach_m = 1.2 }";
    let (values, _) = spread(&model, list, &[]);
    let length = |angle: f32| blend_marks(&values.length, at(&model, on_equator(angle)), 0.5);
    let quarter = std::f32::consts::FRAC_PI_2;
    assert!(length(0.0) > 0.999 && length(quarter) < 0.001, "{} {}", length(0.0), length(quarter));
    assert!((length(quarter / 2.0) - 0.5).abs() < 0.03, "{}", length(quarter / 2.0));
    assert_eq!(blend_marks(&values.density, at(&model, on_equator(quarter)), 1.0), 1.0, "b says nothing of density");
}

#[test]
fn marks_smaller_than_an_edge_affect_the_nearest_vertex() {
    let model = ball();
    let (values, _) = spread(&model, "{ name = \"a\", at = [0.03, 0.02, 1], lean = 1, reach_m = 1e-4 }", &[]);
    let full = values.lean.iter().filter(|(share, _)| *share > 0.99).count();
    assert!((1..=2).contains(&full), "{full} vertices, on the seam two at one place");
    assert_eq!(values.lean.iter().filter(|(share, _)| *share > 0.0).count(), full);
}

#[test]
fn mirrored_mark_applies_on_both_sides() {
    let model = ball();
    let (values, _) =
        spread(&model, "{ name = \"a\", at = [1, 0, 0], length = 0, reach_m = 0.5, mirrored = true }", &[]);
    for (place, expected) in [(Vec3::X, 0.0), (Vec3::NEG_X, 0.0), (Vec3::Z, 1.0)] {
        assert!((blend_marks(&values.length, at(&model, place), 1.0) - expected).abs() < 1e-3, "{place}");
    }
}

#[test]
fn marks_far_from_the_surface_are_reported_with_their_distance() {
    let line = |x: f32| CombLine { name: "comb_x".into(), places: vec![(Vec3::X * x, Vec3::Y); 40] };
    let (values, warnings) = spread(
        &ball(),
        "{ name = \"ruff\", at = [0, 0, 3.5], lean = 1 }, { name = \"near\", at = [0, 1.05, 0], lean = 1 }",
        &[line(1.02), line(2.0)],
    );
    assert!(values.lean.iter().any(|(share, _)| *share == 1.0), "it counts all the same");
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("comb_x") && warnings[0].contains("1.0 m"), "{warnings:?}");
    assert!(warnings[1].contains("\"ruff\"") && warnings[1].contains("2.5 m"), "{warnings:?}");
}

fn colored(change: impl FnOnce(&mut Model), marks: &str) -> (Model, Colors) {
    let mut model = ball();
    change(&mut model);
    let (values, _) = spread(&model, marks, &[]);
    let (groom, images, rest) = (Default::default(), MapImages::default(), RestPose::of(&model.mesh, None));
    let maps = Maps::new(&model.mesh, &model.materials, &[true], &groom, &images, &mut Vec::new()).with_marks(values);
    let colors = colors(&model, &Vertices::of_model(&model.mesh, &rest), &maps, &[true], true).unwrap();
    (model, colors)
}

#[test]
fn mark_colour_replaces_the_model_colour() {
    let (model, colors) = colored(|_| {}, "{ name = \"a\", at = [0, 0, 1], color = \"#ffffff\", reach_m = 1 }");
    let color = |place: Vec3| {
        let vertex = colors.vertices[at(&model, place)].map(|byte| f32::from(byte) / 255.0);
        [0, 1, 2, 3].map(|k| vertex[k] * colors.materials[0].factor[k])
    };
    assert_eq!(color(Vec3::Z), [1.0; 4]);
    let far = color(Vec3::NEG_Z);
    assert!(far.iter().zip([0.25, 0.125, 0.0625, 1.0]).all(|(f, e)| (f - e).abs() < 1.0 / 255.0), "{far:?}");
    let [r, g, b, _] = color(on_equator(0.62));
    assert!((r - 0.625).abs() < 0.08 && (g - 0.5625).abs() < 0.1 && b < g, "{r} {g} {b}");
}

#[test]
fn mark_colour_multiplies_the_texture() {
    let image = pelage_import::mesh::Image { width: 1, height: 1, rgba: vec![128; 4] };
    let change = |model: &mut Model| {
        model.images.push(std::sync::Arc::new(image));
        model.materials[0].base_color_image = Some(0);
    };
    let (model, colors) = colored(change, "{ name = \"a\", at = [0, 0, 1], color = \"#ff0000\", reach_m = 1 }");
    let factor = colors.materials[0].factor;
    let front = colors.vertices[at(&model, Vec3::Z)];
    assert!(colors.materials[0].image.is_some() && front[0] == 255 && front[1..3] == [0, 0], "{front:?} {factor:?}");
    assert_eq!((factor, colors.vertices[at(&model, Vec3::NEG_Z)]), ([0.25, 0.125, 0.0625, 1.0], [255; 4]));
}
