use super::*;
use glam::Vec2;
use pelage_bake::pipeline;
use pelage_bake::pipeline::BakeInput;
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::groom::MapImages;
use pelage_formats::Limits;
use pelage_import::mesh::{Image, Model};
use pelage_lab::stability::surface::torus;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock};

/// Returns a torus with a base-colour texture of `texels`² texels; 0 means no texture.
fn model(texels: u32) -> Model {
    let mut model = torus();
    if texels > 0 {
        let texel = |i: u32| if i.is_multiple_of(3) { [255, 200, 150, 255] } else { [90, 120, 60, 255] };
        let rgba = (0..texels * texels).flat_map(texel).collect();
        model.images.push(std::sync::Arc::new(Image { width: texels, height: texels, rgba }));
        model.materials[0].base_color_image = Some(0);
        model
            .mesh
            .uvs
            .iter_mut()
            .enumerate()
            .for_each(|(i, uv)| *uv = Vec2::new(i as f32 * 0.37, i as f32 * 0.11).fract());
        model.mesh.parts[0].has_uvs = true;
    }
    model
}

/// Returns the package of a torus, baked once for each combination of texels and recipe settings. Several tests share
/// the result.
fn package(texels: u32, sets: &[&str]) -> Arc<[u8]> {
    type Baked = Arc<OnceLock<Arc<[u8]>>>;
    static KNOWN: Mutex<BTreeMap<(u32, Vec<String>), Baked>> = Mutex::new(BTreeMap::new());
    let key = (texels, sets.iter().map(|&set| set.to_owned()).collect());
    let baked = KNOWN.lock().unwrap().entry(key).or_default().clone();
    let bake = || {
        let mut recipe = Recipe::default();
        // Ink is disabled: it is not predicted, and its textures take most of the bake time.
        ["ink.enabled=false"].iter().chain(sets).for_each(|set| recipe.set(set).unwrap());
        let images = MapImages::default();
        let told = BakeInput::new("torus", "torus", &recipe, &images);
        pipeline::bake(&told, &model(texels), &mut |_| ()).unwrap().package.into()
    };
    baked.get_or_init(bake).clone()
}

/// Predicts the cost of the torus with a texture of `texels`² texels, seen from `distance_m` metres in a square picture
/// of `pixels`² pixels.
fn prognosis(texels: u32, sets: &[&str], pixels: u32, distance_m: f32, instances: u32) -> Prognosis {
    let baked = package(texels, sets);
    let package = Package::open(&baked, &Limits::default()).unwrap();
    let eye = Vec3::new(0.3, 0.8, 1.0).normalize() * distance_m;
    let view =
        PrognosisView { eye, target: Vec3::ZERO, fov_y_rad: 0.6, size: (pixels, pixels), instances, shadow_map: 512 };
    diagnose(&package, &view, &|source| BakeError::Package { file: "torus".into(), source }).unwrap()
}

fn changes(found: &Prognosis) -> Vec<&str> {
    found.advice.iter().map(|a| a.change.split('=').next().unwrap()).collect()
}

#[test]
fn advice_is_given_only_when_it_applies() {
    let (near, pixels) = (6.0, 600);
    let plain = prognosis(0, &[], pixels, near, 1);
    assert_eq!(plain.advice, [], "expected no advice: {:?}", plain.on_screen);
    let advised = |sets: &[&str], pixels, distance_m, texels| {
        let found = prognosis(texels, sets, pixels, distance_m, 1);
        for advice in &found.advice {
            assert!(![&advice.found, &advice.saves, &advice.costs].iter().any(|text| text.is_empty()), "{advice:?}");
        }
        changes(&found).into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    for (name, sets, pixels, distance_m, texels) in [
        ("slice.layers", &["slice.layers=64"][..], pixels, 12.0, 0),
        ("slice.tile_texels", &["slice.tile_texels=256"], pixels, near, 0),
        ("fins.enabled", &["fins.enabled=true"], pixels, 600.0, 0),
        ("pack.shell_format", &["pack.shell_format=rgba8"], pixels, near, 0),
        ("pack.base_color_max", &[], pixels, 60.0, 512),
        ("the model: fewer triangles", &[], 120, near, 0),
    ] {
        let found = advised(sets, pixels, distance_m, texels);
        assert!(found.iter().any(|change| change == name), "{name} is missing: {found:?}");
    }
    // Transparent or occluded layers cost as much as any others, so a change of the look alone saves nothing.
    for sets in [["hair.root_radius=0.002", "hair.tip_radius=0.001"], ["hair.density=30000", "hair.length_variation=0"]]
    {
        assert_eq!(advised(&sets, pixels, near, 0), Vec::<String>::new(), "{sets:?}");
    }
    // The texels are small on the screen, but with half as many every hair would be narrower than a texel.
    let small = prognosis(0, &["slice.tile_texels=64"], 120, 12.0, 1);
    assert!(small.on_screen.texel_px < 0.25, "{:?}", small.on_screen);
    assert!(!changes(&small).contains(&"slice.tile_texels"), "{:?}", small.advice);
    assert!(advised(&["hair.root_radius=0.016"], 120, 12.0, 0).contains(&"slice.tile_texels".to_owned()));
    // The recommended number of layers is sufficient: applying it leads to no further advice.
    let few = prognosis(0, &["slice.layers=64"], pixels, 12.0, 1);
    let change = few.advice.iter().find(|a| a.change.starts_with("slice.layers")).unwrap().change.clone();
    assert!(!changes(&prognosis(0, &[&change], pixels, 12.0, 1)).contains(&"slice.layers"), "{change}");
}

/// Checks the order of advice: first changes that improve the look, then savings, largest first, all above zero.
#[test]
fn advice_is_ordered_by_savings() {
    let found = prognosis(512, &["slice.layers=64", "slice.tile_texels=256", "pack.shell_format=rgba8"], 300, 20.0, 3);
    let saved: Vec<Saved> = found.advice.iter().filter_map(|a| a.saved).collect();
    assert!(saved.len() == found.advice.len() && saved.len() >= 4, "{:?}", found.advice);
    assert!(saved.iter().all(|saved| *saved > Saved::default()), "{saved:?}");
    assert!(saved.is_sorted_by(|a, b| a >= b), "{saved:?}");
    // The predicted savings equal the difference between the predictions without and with the change applied.
    let fragments = |p: &Prognosis| p.passes.iter().filter_map(|pass| pass.fragments).sum::<u64>() as f64;
    let layers = found.advice.iter().find(|a| a.change.starts_with("slice.layers")).unwrap();
    let sets = [&layers.change, "slice.tile_texels=256", "pack.shell_format=rgba8"];
    let fewer = prognosis(512, &sets, 300, 20.0, 3);
    let ratio = layers.saved.unwrap().fragments as f64 / (fragments(&found) - fragments(&fewer));
    assert!((0.95..1.05).contains(&ratio), "{ratio}");
}

/// Checks that close-ups get the advice of more layers or, above 64, of more distance. Following the advice must
/// suffice.
#[test]
fn close_ups_need_more_layers_or_more_distance() {
    let (distance_m, layers) = (6.0, 16.0);
    let height = prognosis(0, &[], 600, distance_m, 1).on_screen.height_px;
    let at_gap = |gap: f64, sets: &[&str], distance_m| {
        let pixels = (600.0 * gap * (layers - 1.0) / height).round() as u32;
        prognosis(0, sets, pixels, distance_m, 1)
    };
    let look = |p: &Prognosis| p.advice.iter().find(|a| a.saved.is_none()).cloned();
    assert_eq!(look(&at_gap(2.5, &[], distance_m)), None);
    let near = at_gap(9.0, &[], distance_m);
    let more = look(&near).unwrap();
    assert_eq!(near.advice[0], more, "advice that improves the look must come first");
    assert!(more.change.starts_with("slice.layers=4") && more.found.contains("9.0 pixels"), "{more:?}");
    assert_eq!(look(&at_gap(9.0, &[&more.change], distance_m)), None, "{more:?}");
    let nearer = at_gap(20.0, &[], distance_m);
    let away = look(&nearer).unwrap();
    assert!(away.found.starts_with("too near for shells") && away.change.contains("slice.layers=64"), "{away:?}");
    let fine_m: f32 = away.change.split(' ').nth(2).unwrap().parse().unwrap();
    let further = distance_m + 1.01 * fine_m - nearer.on_screen.near_m as f32;
    assert_eq!(look(&at_gap(20.0, &["slice.layers=64"], further)), None, "{away:?}");
    let not_far_enough = distance_m + 0.9 * fine_m - nearer.on_screen.near_m as f32;
    assert!(look(&at_gap(20.0, &["slice.layers=64"], not_far_enough)).is_some(), "{away:?}");
}

/// Checks that the camera's up direction is the same as in the runtime, for a view almost straight down. With another
/// up direction, a different picture would be predicted.
#[test]
fn doctor_cameras_match_the_runtime() {
    use pelage_runtime::{Camera, Projection};
    let target = Vec3::new(0.1, 0.2, -0.3);
    for towards in [
        Vec3::Y,
        Vec3::NEG_Y,
        Vec3::new(0.03, 1.0, 0.0),
        Vec3::new(0.03, -1.0, 0.01),
        Vec3::new(0.01, 1.0, 0.0),
        Vec3::new(0.3, 0.8, 1.0),
    ] {
        let eye = target + 2.0 * towards.normalize();
        let view = PrognosisView { eye, target, fov_y_rad: 0.6, size: (500, 300), instances: 1, shadow_map: 0 };
        let ours = camera(&view).unwrap();
        let projection = Projection::Perspective { fov_y_rad: 0.6, aspect: 5.0 / 3.0, near_m: 0.1, far_m: 10.0 };
        let theirs = projection.clip_from_view(true) * Camera::look_at(eye, target, projection).view_from_world;
        for point in [Vec3::ZERO, 0.2 * Vec3::X, 0.2 * Vec3::Y, 0.2 * Vec3::Z] {
            let [a, b] = [ours, theirs].map(|clip| clip * (target + point).extend(1.0)).map(|c| (c.x / c.w, c.y / c.w));
            assert!(
                (a.0 - b.0).abs() < 1e-4 && (a.1 - b.1).abs() < 1e-4,
                "{towards}: {point} at {a:?}, expected {b:?}"
            );
        }
    }
}

#[test]
fn predicted_work_scales_with_size_and_layers() {
    let of = |p: &Prognosis, name: &str| {
        let pass = p.passes.iter().find(|pass| pass.name == name).unwrap();
        (pass.fragments.unwrap_or_default() as f64, pass.vertices)
    };
    // Draw all layers, whatever their size in pixels.
    let full = ["detail.enabled=false"];
    let (one, ten) = (prognosis(0, &full, 300, 6.0, 1), prognosis(0, &full, 300, 6.0, 10));
    assert_eq!((of(&ten, "shells").1, of(&ten, "skin").0), (10 * of(&one, "shells").1, 10.0 * of(&one, "skin").0));
    assert_eq!(ten.memory, one.memory, "instances at rest must share memory");
    // A picture with twice the side has four times the pixels. Above `MOST_PIXELS` they are counted on a smaller
    // picture.
    let (large, huge) = (prognosis(0, &full, 600, 6.0, 1), prognosis(0, &full, 4800, 6.0, 1));
    for (picture, factor) in [(&large, 4.0), (&huge, 256.0)] {
        let ratio = of(picture, "shells").0 / of(&one, "shells").0 / factor;
        assert!((0.97..1.03).contains(&ratio), "{ratio}");
    }
    assert!(one.overdraw.0 > 8.0 && one.overdraw.1 >= 15, "{:?}", one.overdraw);
    assert!(one.covered_pixels[1] > one.covered_pixels[0]);
    // With levels of detail, the number of layers equals the fur's height in pixels.
    let (fewer, far) = (prognosis(0, &[], 300, 6.0, 1), prognosis(0, &[], 300, 600.0, 1));
    let drawn = [&one, &fewer, &far].map(|p| p.on_screen.layers_drawn);
    assert!(drawn[0] == 15 && (1..15).contains(&drawn[1]) && drawn[2] == 0, "{drawn:?}");
    assert!(of(&fewer, "shells").0 < of(&one, "shells").0 && of(&far, "shells").1 == 0);
    // Without fur there is less work, and the report says why.
    let bare = prognosis(0, &["model.bare=[\"*\"]"], 300, 6.0, 1);
    let shells = bare.passes.iter().find(|pass| pass.name == "shells").unwrap();
    assert!(!shells.runs && shells.vertices == 0 && shells.reason.contains("no fur"), "{shells:?}");
}

#[test]
fn objects_behind_the_camera_are_not_counted() {
    let baked = package(0, &[]);
    let package = Package::open(&baked, &Limits::default()).unwrap();
    let fault = |source| BakeError::Package { file: "torus".into(), source };
    let view = PrognosisView {
        eye: Vec3::new(0.0, 0.0, 5.0),
        target: Vec3::new(0.0, 0.0, 6.0),
        fov_y_rad: 0.6,
        size: (64, 64),
        instances: 1,
        shadow_map: 0,
    };
    let found = diagnose(&package, &view, &fault).unwrap();
    assert_eq!((found.covered_pixels, found.overdraw.1, found.on_screen.triangles), ([0, 0], 0, 0));
    assert!(
        found.passes.iter().find(|p| p.name == "shadow_width").is_some_and(|p| !p.runs && p.reason == "switched off")
    );
    assert!(diagnose(&package, &PrognosisView { target: view.eye, ..view }, &fault).is_err());
}
