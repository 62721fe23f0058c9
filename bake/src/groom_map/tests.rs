use super::*;
use crate::recipe::Recipe;
use crate::stages::fixtures::{part, torus as torus_mesh};
use crate::stages::groom::MapImages;
use pelage_import::mesh::{Material, MeshPart};

const RINGS: u32 = 28;
const SIDES: u32 = 14;

/// Builds a torus about the y axis with radii 0.3 m and 0.12 m and noisy vertex colours. With texture coordinates, it
/// is a single chart, cut along both circles.
fn torus(with_uvs: bool) -> Model {
    let mut mesh = torus_mesh(RINGS, SIDES, with_uvs);
    let row = SIDES + u32::from(with_uvs);
    for (k, color) in (0..).zip(&mut mesh.colors) {
        let (i, j) = (k / row % RINGS, k % row % SIDES);
        let odd = |k: u32| ((i * 7919 + j * 104_729 + k * 31) % 197) as u8 + 29;
        *color = [odd(0), odd(1), odd(2), 255];
    }
    let whole = part(0, 0, mesh.triangles.len());
    mesh.parts = vec![MeshPart { source: "torus".into(), has_uvs: with_uvs, ..whole }];
    Model { mesh, materials: vec![Material { name: "coat".into(), ..Material::default() }], ..Model::default() }
}

fn recipe(text: &str) -> Recipe {
    Recipe::parse("r.toml", text).unwrap()
}

fn written(
    model: &Model,
    text: &str,
    images: &MapImages,
    quantity: Quantity,
    texels: u32,
) -> Result<GroomMap, BakeError> {
    let recipe = recipe(text);
    groom_map(&BakeInput::new("torus", "torus", &recipe, images), model, quantity, None, texels)
}

/// Returns length, lean and density per vertex of the model for a recipe, encoded as in maps.
fn groomed(model: &Model, text: &str, images: &MapImages) -> [Vec<f32>; 3] {
    let recipe = recipe(text);
    let input = BakeInput::new("torus", "torus", &recipe, images);
    let mut outputs = Outputs::of_model(model);
    pipeline::make(&input, &mut outputs, Output::Groomed, &mut |_| ()).unwrap();
    let (laid, groomed) = (outputs.laid.take().unwrap(), outputs.groomed.take().unwrap());
    let of_inputs = |values: &[f32]| {
        let mut of_input = vec![f32::NAN; model.mesh.positions.len()];
        groomed.surface.input_vertex.iter().zip(values).for_each(|(v, value)| of_input[*v as usize] = *value);
        of_input
    };
    let density = laid.lay.density.unwrap_or_else(|| vec![1.0; model.mesh.positions.len()]);
    let density = density.into_iter().map(|hairs| (libm::log2f(hairs) + 2.0) / 4.0).collect();
    [of_inputs(&groomed.coat.length), of_inputs(&groomed.coat.lean), density]
}

fn with_image(map: GroomMap) -> MapImages {
    MapImages { images: [("m.png".to_owned(), map.image)].into(), ..MapImages::default() }
}

/// Returns the largest difference between two lists.
fn max_difference(a: &[f32], b: &[f32]) -> f32 {
    assert!(a.len() == b.len() && a.iter().chain(b).all(|x| x.is_finite()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn written_maps_reproduce_vertex_values_within_one_byte_step() {
    for (with_uvs, over) in [(false, "coordinates = \"atlas\"\n"), (true, ""), (true, "coordinates = \"atlas\"\n")] {
        let model = torus(with_uvs);
        let none = MapImages::default();
        let before = format!("[groom]\n{over}length = \"vertex\"\nlean = \"vertex#g\"\ndensity = \"vertex#b\"");
        let had = groomed(&model, &before, &none);
        for (k, quantity) in [Quantity::Length, Quantity::Lean, Quantity::Density].into_iter().enumerate() {
            let map = written(&model, &before, &none, quantity, 512).unwrap();
            assert!(map.misses_by < 0.5 / 255.0, "{quantity:?}, {over:?}: {}", map.misses_by);
            let after = format!("[groom]\n{over}{} = \"m.png\"", quantity.key());
            let has = groomed(&model, &after, &with_image(map));
            let difference = max_difference(&has[k], &had[k]);
            assert!(difference <= 1.0 / 255.0, "{quantity:?}, {over:?}: {difference}");
        }
    }
}

#[test]
fn constant_values_fill_the_map_with_their_bytes() {
    let model = torus(true);
    let none = MapImages::default();
    let text = "[groom]\nlength = 0.6\nlean = 0.2\ndensity = 2\n\
                wetness = 0.4\nbare = 0.8\ncomb = [0, 0.5, -1]\n\
                color = \"#336699\"";
    for (quantity, expected) in [
        (Quantity::Length, [153; 3]),
        (Quantity::Lean, [51; 3]),
        (Quantity::Density, [191; 3]),
        (Quantity::Wetness, [102; 3]),
        (Quantity::Bare, [204; 3]),
        (Quantity::Comb, [128, 185, 13]),
        (Quantity::Color, [0x33, 0x66, 0x99]),
    ] {
        let map = written(&model, text, &none, quantity, 64).unwrap();
        assert_eq!(map.coordinates, GroomCoordinates::Model);
        for texel in map.image.rgba.chunks_exact(4) {
            assert!(
                texel[3] == 255 && texel.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 1),
                "{quantity:?}: {texel:?}"
            );
        }
    }
}

#[test]
fn comb_without_a_map_is_the_hair_direction() {
    let model = torus(false);
    let none = MapImages::default();
    let lies = |text| written(&model, text, &none, Quantity::Comb, 512).unwrap();
    let down = lies("[surface]\ncomb = \"gravity\"");
    assert_eq!(down.coordinates, GroomCoordinates::Atlas);
    // At the outer equator, the surface is vertical, so hair points straight down.
    let at = |map: &GroomMap, v: usize| {
        let uv = map.mesh.uvs[v];
        bilinear(&map.image, uv, Wrap::Repeat, Encoding::Linear).truncate() * 2.0 - 1.0
    };
    let outer = |v: &usize| down.rest.positions[*v].length() > 0.415;
    let upright = (0..down.mesh.positions.len()).filter(outer);
    let directions: Vec<Vec3> = upright.map(|v| at(&down, v)).collect();
    assert!(directions.len() >= RINGS as usize && directions.iter().all(|d| d.y < -0.9), "{directions:?}");
    let nowhere = lies("[surface]\ncomb = \"none\"");
    assert!(nowhere.image.rgba.chunks_exact(4).all(|t| t[3] == 255 && t[..3].iter().all(|c| matches!(c, 127 | 128))));
}

#[test]
fn image_maps_are_copied_texel_by_texel() {
    let model = torus(true);
    let mut rgba = vec![0; 4 * 64 * 64];
    for (i, texel) in rgba.chunks_exact_mut(4).enumerate() {
        texel.copy_from_slice(&[if i % 64 < 32 { 255 } else { 0 }, 51, 0, 255]);
    }
    let image = Image { width: 64, height: 64, rgba };
    let images = MapImages { images: [("m.png".to_owned(), image)].into(), ..MapImages::default() };
    let text = "[groom]\nbare = \"m.png\"\nwetness = \"m.png#g\"";
    let bare = written(&model, text, &images, Quantity::Bare, 64).unwrap().image;
    let wet = written(&model, text, &images, Quantity::Wetness, 64).unwrap().image;
    for i in 0..64 * 64 {
        let expected = if i % 64 < 32 { 255 } else { 0 };
        assert_eq!((bare.rgba[4 * i], wet.rgba[4 * i]), (expected, 51), "texel {i}");
    }
}

#[test]
fn writing_a_map_without_texture_coordinates_is_refused() {
    let (model, none, recipe) = (torus(false), MapImages::default(), Recipe::default());
    let input = BakeInput::new("torus.glb", "torus", &recipe, &none);
    let error = groom_map(&input, &model, Quantity::Length, Some(GroomCoordinates::Model), 64).unwrap_err().to_string();
    assert!(error.contains("torus.glb") && error.contains("TEXCOORD_0"), "{error}");
}

#[test]
fn coordinates_of_a_palette_give_way_to_the_atlas() {
    let mut model = torus(true);
    let of = |model: &Model| written(model, "", &MapImages::default(), Quantity::Length, 64).unwrap();
    assert_eq!(of(&model).coordinates, GroomCoordinates::Model);
    model.mesh.uvs.iter_mut().for_each(|uv| *uv = Vec2::new(0.1, (uv.y * 4.0).floor() / 4.0));
    let map = of(&model);
    assert_eq!(map.coordinates, GroomCoordinates::Atlas);
    assert!(map.image.rgba.chunks_exact(4).any(|texel| texel[3] > 0));
}

#[test]
fn triangles_outside_the_image_are_wrapped() {
    let mut found = Vec::new();
    repeated([Vec2::new(-0.2, 1.2), Vec2::new(0.2, 1.2), Vec2::new(0.0, 1.6)], |uvs| found.push(uvs[0]));
    let expected = [Vec2::new(0.8, 0.2), Vec2::new(-0.2, 0.2)];
    assert!(found.len() == 2 && found.iter().zip(expected).all(|(a, b)| a.distance(b) < 1e-6), "{found:?}");
    repeated([Vec2::NAN; 3], |_| panic!("found a copy of a triangle without coordinates"));
    let mut count = 0;
    repeated([Vec2::ZERO, Vec2::splat(1e9), Vec2::X], |_| count += 1);
    assert_eq!(count, 256);
}
