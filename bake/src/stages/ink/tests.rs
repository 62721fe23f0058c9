use super::*;
use crate::recipe::{ColorParams, HairParams, natural};
use crate::stages::simulate::{VolumeParams, simulate};
use crate::stages::slice::decode_texture;
use glam::Vec2;
use pelage_formats::{Animation, Limits, Manifest, Package, PackageWriter, TextureEntry, TextureView};

/// Returns parameters for textures that are small enough for a test, and large enough to show seams.
fn small() -> InkParams {
    InkParams { stroke_texels: 128, wash_texels: 128, paper_texels: 128, fur_texels: 128, ..InkParams::default() }
}

fn strands() -> Strands {
    simulate(&natural().hair, &ColorParams::default(), &VolumeParams { height: 0.15 }).unwrap()
}

/// Returns the mean difference of neighbouring texels across the seam, and everywhere else. `columns`: whether to
/// compare texels side by side.
fn seam(plane: &Plane, columns: bool) -> (f32, f32) {
    let n = plane.side as i64;
    let at = |along: i64, across: i64| if columns { plane.at(across, along) } else { plane.at(along, across) };
    let step = |across: i64| (0..n).map(|i| (at(i, across + 1) - at(i, across)).abs()).sum::<f32>() / n as f32;
    ((step(n - 1)), (0..n - 1).map(step).sum::<f32>() / (n - 1) as f32)
}

#[test]
fn tiles_have_no_seams() {
    let params = small();
    let [above, beside] = fur(&strands(), 128, 1);
    let beside_u = beside.iter().map(|plane| (plane, true));
    for (name, tile) in [("wash", wash(&params, None)), ("paper", paper(&params)), ("fur", above)] {
        for (channel, plane) in tile.iter().enumerate() {
            for columns in [true, false] {
                let (across, inside) = seam(plane, columns);
                assert!(across < 1.35 * inside + 1e-3, "{name} {channel}, columns {columns}: {across} and {inside}");
            }
        }
    }
    for (channel, (plane, columns)) in beside_u.enumerate() {
        let (across, inside) = seam(plane, columns);
        assert!(across < 1.35 * inside + 1e-3, "fur from the side {channel}: {across} and {inside}");
    }
}

#[test]
fn greys_have_mean_one_half_and_thresholds_are_uniform() {
    for [a, b, _, threshold] in [wash(&small(), None), paper(&small())] {
        for plane in [a, b] {
            assert!(
                (plane.mean() - 0.5).abs() < 0.01 && plane.deviation() > 0.05,
                "{} {}",
                plane.mean(),
                plane.deviation()
            );
        }
        for part in 0..10 {
            let (from, to) = (part as f32 / 10.0, (part + 1) as f32 / 10.0);
            let share = threshold.values.iter().filter(|v| (from..to).contains(*v)).count() as f32 / (128.0 * 128.0);
            assert!((share - 0.1).abs() < 1e-3, "{share} within {from}..{to}");
        }
    }
    let [.., pressure, _] = wash(&small(), None);
    assert!((pressure.mean() - 0.5).abs() < 0.01);
    let [.., variation, opaque] = stroke(&small(), None);
    assert!((variation.mean() - 0.5).abs() < 0.01 && opaque.values.iter().all(|a| *a == 1.0));
}

#[test]
fn the_stroke_is_a_dark_uneven_rim() {
    let [wet, dry, ..] = stroke(&InkParams { stroke_texels: 512, ..InkParams::default() }, None);
    let on_ray = |plane: &Plane, turn: f32, inward: f32| {
        let (sin, cos) = (turn * std::f32::consts::TAU).sin_cos();
        plane.sample(Vec2::splat(0.5) + 0.5 * (1.0 - inward) * Vec2::new(cos, sin))
    };
    let mut widths = Vec::new();
    for i in 0..128 {
        let turn = i as f32 / 128.0;
        assert!(on_ray(&wet, turn, 0.004) < 0.1, "the outline at {turn} is {}", on_ray(&wet, turn, 0.004));
        assert!(on_ray(&wet, turn, 0.6) > 0.98 && on_ray(&dry, turn, 0.6) > 0.98);
        widths.push((0..400).map(|k| k as f32 / 1000.0).find(|q| on_ray(&wet, turn, *q) > 0.5).unwrap());
    }
    let mean = widths.iter().sum::<f32>() / 128.0;
    let (thin, wide) = widths.iter().fold((1.0f32, 0.0f32), |(a, b), w| (a.min(*w), b.max(*w)));
    assert!((mean - 0.085).abs() < 0.025, "{mean}");
    assert!(wide > 1.8 * thin, "a line of one width: {thin}..{wide}");
    assert!(
        dry.values.iter().zip(&wet.values).all(|(dry, wet)| dry >= wet),
        "a dry brush leaves no more ink than a wet one"
    );
    assert!(dry.mean() > wet.mean() + 0.01);
    let even = stroke(&InkParams { stroke_variation: 0.0, ..InkParams::default() }, None);
    let wobble: Vec<f32> = (0..64).map(|i| on_ray(&even[0], i as f32 / 64.0, 0.085)).collect();
    assert!(wobble.iter().all(|g| (g - wobble[0]).abs() < 0.15), "without variation the line is even: {wobble:?}");
}

#[test]
fn densities_of_fur_are_nested_and_grow() {
    let strands = strands();
    for (name, planes) in ["above", "beside"].iter().zip(fur(&strands, 256, 1)) {
        for pair in planes.windows(2) {
            assert!(pair[0].values.iter().zip(&pair[1].values).all(|(few, more)| few <= more), "{name}");
        }
        let shares = planes.each_ref().map(Plane::mean);
        assert!(shares[0] > 0.05 && shares[0] < 0.2 && shares[3] < 0.8, "{name}: {shares:?}");
        assert!(shares[1] > 1.5 * shares[0] && shares[3] > 3.0 * shares[0], "{name}: {shares:?}");
    }
    // Seen from the side, hair is dense at the mesh surface and ends in tips.
    let [_, [.., all]] = fur(&strands, 256, 1);
    let row = |y: usize| all.values[y * 256..(y + 1) * 256].iter().sum::<f32>() / 256.0;
    assert!(row(12) > 0.7 && row(12) > row(128) && row(128) > row(220) && row(255) < 0.05, "{} {}", row(12), row(255));
}

#[test]
fn a_single_upright_strand_still_gives_strokes() {
    let upright = HairParams { lean: 0.0, frizz: 0.0, density: 1, ..natural().hair };
    let strands = simulate(&upright, &ColorParams::default(), &VolumeParams { height: 0.01 }).unwrap();
    let [above, beside] = fur(&strands, 64, 1);
    assert!(above[3].mean() > 2e-4 && beside[3].mean() > 2e-4, "{} {}", above[3].mean(), beside[3].mean());
    assert_eq!(fur(&Strands::default(), 16, 1)[0][3].mean(), 0.0);
}

#[test]
fn ink_textures_depend_on_the_seed() {
    let [one, other] = [1, 2].map(|seed| {
        let (params, pack) = (InkParams { seed, ..small() }, PackParams::default());
        textures(&params, &pack, &MapImages::default(), Some(&strands()), StageProgress::ignored()).unwrap()
    });
    assert!(one.stroke != other.stroke && one.wash != other.wash && one.paper != other.paper && one.fur != other.fur);
}

fn reread<T>(ktx2: &[u8], look: impl FnOnce(TextureView<'_>) -> T) -> T {
    let manifest = Manifest { textures: vec![TextureEntry { name: "t".into() }], ..Manifest::default() };
    let bytes = PackageWriter::new(manifest).texture(ktx2).finish().unwrap();
    look(Package::open(&bytes, &Limits::default()).unwrap().texture(0).unwrap())
}

#[test]
fn encoded_ink_textures_are_linear_complete_and_accurate() {
    let (params, strands) = (small(), strands());
    for shell_format in [ShellFormat::Bc7, ShellFormat::Rgba8] {
        let pack = PackParams { shell_format, ..PackParams::default() };
        let encoded =
            textures(&params, &pack, &MapImages::default(), Some(&strands), StageProgress::ignored()).unwrap();
        let painted = [
            vec![stroke(&params, None)],
            vec![wash(&params, None)],
            vec![paper(&params)],
            fur(&strands, 128, 1).to_vec(),
        ];
        let files = [&encoded.stroke, &encoded.wash, &encoded.paper, encoded.fur.as_ref().unwrap()];
        for (texture, ((_, file), layers)) in files.into_iter().zip(painted).enumerate() {
            // The paper, the third texture, is never block-compressed.
            let block = shell_format == ShellFormat::Bc7 && texture != 2;
            let format = if block { TextureFormat::Bc7Unorm } else { TextureFormat::Rgba8Unorm };
            reread(file, |view| {
                let shape = (view.format, view.width, view.height, view.layers, view.levels);
                assert_eq!(shape, (format, 128, 128, layers.len() as u32, 8), "{texture}");
                for (layer, planes) in layers.iter().enumerate() {
                    let texels = decode_texture(&view, 0, layer as u32).unwrap();
                    for (channel, plane) in planes.iter().enumerate() {
                        let pairs = texels.iter().skip(channel).step_by(4).zip(&plane.values);
                        let squares: f32 = pairs.map(|(b, v)| (f32::from(*b) / 255.0 - v).powi(2)).sum();
                        let error = (squares / (128.0 * 128.0)).sqrt();
                        assert!(error < if block { 0.08 } else { 0.003 }, "{texture} {layer} {channel}: {error}");
                    }
                }
            });
        }
    }
    assert!(
        textures(&params, &PackParams::default(), &MapImages::default(), None, StageProgress::ignored())
            .unwrap()
            .fur
            .is_none()
    );
}

#[test]
fn ink_fur_is_enabled_by_fur_keys_animation_or_bare_materials() {
    let (stone, animal) = (Model::default(), Model { animation: Some(Animation::default()), ..Model::default() });
    let with = |set: &[&str]| {
        let mut recipe = Recipe::default();
        set.iter().for_each(|set| recipe.set(set).unwrap());
        recipe
    };
    assert_eq!([&stone, &animal].map(|model| fur_strength(&with(&[]), model, &[true])), [0.0, 1.0]);
    for set in ["hair.length_m=0.02", "groom.lean=0.5", "color.tip=#ffffff", "fins.depth=0.3", "model.bare=[\"eye\"]"] {
        assert_eq!(fur_strength(&with(&[set]), &stone, &[true]), 1.0, "{set}");
    }
    assert_eq!(fur_strength(&with(&[]), &stone, &[true, false]), 1.0, "eyes were found");
    // Resolution settings and disabled fins do not show that the model has fur.
    for set in ["slice.layers=8", "model.unit_m=0.01", "fins.enabled=false", "ink.line=2"] {
        assert_eq!(fur_strength(&with(&[set]), &stone, &[true]), 0.0, "{set}");
    }
    // An explicit value always applies.
    assert_eq!(fur_strength(&with(&["ink.fur=0.3"]), &stone, &[true]), 0.3);
    assert_eq!(fur_strength(&with(&["ink.fur=0"]), &animal, &[true]), 0.0);
}

#[test]
fn textures_of_the_default_sizes_stay_small() {
    let encoded = textures(
        &InkParams::default(),
        &PackParams::default(),
        &MapImages::default(),
        Some(&strands()),
        StageProgress::ignored(),
    )
    .unwrap();
    let files = [encoded.stroke, encoded.wash, encoded.paper, encoded.fur.unwrap()];
    let bytes: usize = files.iter().map(|(_, file)| file.len()).sum();
    assert!(bytes < 900_000, "{bytes}");
}
