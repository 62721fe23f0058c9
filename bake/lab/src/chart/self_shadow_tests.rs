use super::super::self_shadow_forms::configurations;
use super::*;
use glam::{Mat4, Vec4};
use pelage_bake::recipe::{HairParams, SliceParams, natural};
use pelage_runtime::shared::soft_shadow::SoftShadow;
use pelage_runtime::shared::tile_frame::tile_frame;
use pelage_runtime::{LightView, Sphere};

fn sheet() -> Sheet {
    let recipe = Recipe {
        hair: HairParams { density: 60, root_radius: 0.03, tip_radius: 0.02, lean: 0.4, ..natural().hair },
        slice: SliceParams { layers: 6, tile_texels: 16, ..SliceParams::default() },
        ..natural()
    };
    Sheet::new(&recipe, Lengths { length_m: 0.02, tile_size_m: 0.08 }).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn middle_tile_is_centred_and_has_the_frame_of_the_shader() {
    let sheet = sheet();
    let middle = sheet.corner + 0.5 * (sheet.along[0] + sheet.along[1]);
    assert!(middle.length() < 1e-6, "{middle}");
    assert!(sheet.along.iter().all(|way| (way.length() - 0.08).abs() < 1e-6), "{:?}", sheet.along);
    let package = Package::open(&sheet.package, &Limits::default()).unwrap_or_else(|e| panic!("{e}"));
    let mesh = package.mesh().unwrap_or_else(|e| panic!("{e}")).unwrap_or_else(|| panic!("no mesh")).to_data();
    for v in &mesh.geometry {
        let tangent = Vec4::from(v.tangent);
        let frame = tile_frame(Vec3::from(v.normal), tangent.truncate(), tangent.w);
        for (light_ts, axis) in
            [(DVec3::X, frame.tangent_ws), (DVec3::Y, frame.bitangent_ws), (DVec3::Z, frame.normal_ws)]
        {
            assert!((sheet.to_world(light_ts) - axis).length() < 1e-5, "{light_ts}: {axis}");
        }
        assert!((v.fur_height - sheet.up.length()).abs() < 1e-7);
    }
    // The sheet must extend, on each side of the tile, by the reach of light at 75 degrees through the fur.
    let need = sheet.up.length() / 0.08 * 75f32.to_radians().tan();
    for axis in 0..2 {
        let uvs: Vec<f32> = mesh.attributes.iter().map(|a| a.tile_uv[axis]).collect();
        let (low, high) = uvs.iter().fold((f32::MAX, f32::MIN), |(l, h), u| (l.min(*u), h.max(*u)));
        let tile = 0.5 * (low + high) - 0.5;
        assert!((tile - tile.round()).abs() < 1e-4, "{low}..{high}");
        assert!(
            tile - low > need && high - tile - 1.0 > need && high - low < 1.3 * (1.0 + 2.0 * need),
            "{low}..{high}"
        );
    }
}

/// Maps that contain the truth must return it after all steps of the lookup; altered maps must not.
#[test]
fn exact_shadow_maps_have_zero_error() {
    let sheet = sheet();
    let slant = Slant { angle: 0, light_ts: DVec3::Z };
    // This map is for light from straight above, and its texels are those of the tile. It contains the product of the
    // transmittances of the layers above.
    let n = sheet.set.texels;
    let alpha = |k: usize, i: usize| f32::from(sheet.set.layers[k].color[0][4 * i + 3]) / 255.0;
    let layers: Vec<Vec<f32>> = (0..6)
        .map(|k| {
            (0..(n * n) as usize)
                .map(|i| (k.max(1) + usize::from(k > 0)..6).map(|j| 1.0 - alpha(j, i)).product())
                .collect()
        })
        .collect();
    let columns = [sheet.along[0].extend(0.0), sheet.along[1].extend(0.0), Vec4::Y, sheet.corner.extend(1.0)];
    let view = LightView {
        clip_from_world: Mat4::IDENTITY,
        map_from_world: Mat4::from_cols_array_2d(&columns.map(Into::into)).inverse(),
        range_m: 1.0,
        extent: 0.08,
        near_m: None,
        sphere: Sphere { center: Vec3::ZERO, radius: 1.0 },
    };
    let soft = SoftShadow { range_m: 1.0, penumbra: 0.1, blur: 0.1, texel: 0.1 };
    let mut maps = LightMaps { view, soft, size: n, layers, width: Vec::new(), depths: Default::default() };
    assert!((sheet.map_texels_per_hair_texel(&maps) - 1.0).abs() < 1e-5);
    assert_eq!(sheet.map_size_on(&maps, 0.1), 40.0);
    let truth = sheet.truth(&slant);
    let shadows = ShadowParams::default().with(|shadows| shadows.density = 1.0);
    let as_drawn = (&shadows, SlantForm::Corrected);
    let fast = sheet.transmittance_by_maps(&maps, &slant, as_drawn, &truth);
    let mut measured = SelfShadowErrors::default();
    measured.add(&slant, &fast, 1.0, &truth);
    // A small error remains, because the volume caps the opacity of opaque texels and the maps do not.
    let rmse = measured.total(0).rmse().unwrap_or(1.0);
    assert!(rmse < 0.01, "{rmse}");
    assert!(truth.strands.len() > 300 && measured.total(1).rmse().is_some_and(|rmse| rmse > 0.02));
    maps.layers.iter_mut().flatten().for_each(|t| *t = (*t + 0.2).min(1.0));
    let mut worse = SelfShadowErrors::default();
    worse.add(&slant, &sheet.transmittance_by_maps(&maps, &slant, as_drawn, &truth), 1.0, &truth);
    assert!(worse.total(0).rmse().is_some_and(|rmse| rmse > 0.05));
}

/// Returns the errors of the transmittances that `found` returns, under all lights.
fn measured(
    truths: &[(Slant, TransmittanceTruth)],
    found: &dyn Fn(&Slant, &TransmittanceTruth) -> Vec<f64>,
) -> SelfShadowErrors {
    let mut measured = SelfShadowErrors::default();
    truths.iter().for_each(|(slant, truth)| measured.add(slant, &found(slant, truth), 1.0, truth));
    measured
}

fn lit(sheet: &Sheet) -> Vec<(Slant, TransmittanceTruth)> {
    slants().into_iter().map(|slant| (slant, sheet.truth(&slant))).collect()
}

fn baked(sheet: &Sheet, blocks: Option<BcQuality>, directions: u32) -> TileVisibility {
    sheet.visibility(blocks, directions).unwrap_or_else(|e| panic!("{e}")).0
}

/// Returns the RMS error and the mean error of the light on the hair.
fn on_hair(measured: &SelfShadowErrors) -> (f64, f64) {
    let errors = measured.total(2);
    (errors.rmse().unwrap_or(f64::NAN), errors.mean().unwrap_or(f64::NAN))
}

/// Checks that baked visibility is nearer to the light on the hair than any maps. The maps compared here are the best
/// possible ones, because they contain the volume itself. Negative control: with a wrong texel, layer or light
/// direction, baked visibility must be farther off.
#[test]
fn baked_visibility_matches_strands_better_than_exact_maps() {
    let sheet = sheet();
    let truths = lit(&sheet);
    let hair: u32 = truths[0].1.hair.iter().map(|(_, _, times)| times).sum();
    assert_eq!(hair, HAIR_DRAWS);
    assert!(truths[0].1.hair.iter().all(|(i, ..)| sheet.texel(truths[0].1.points[*i]).2 > 0), "layer 0 has no hair");
    let visibility = baked(&sheet, None, 96);
    let (error, mean) =
        on_hair(&measured(&truths, &|slant, truth| sheet.transmittance_by_visibility(&visibility, slant, truth)));
    // Texels as coarse as these mix lit hair with shadowed hair.
    assert!(mean.abs() < 0.05, "{mean}");
    for density in [0.4, 0.7, 1.0] {
        let volume = |_: &Slant, truth: &TransmittanceTruth| truth.volume.iter().map(|t| t.powf(density)).collect();
        let (of_maps, _) = on_hair(&measured(&truths, &volume));
        assert!(error < 0.9 * of_maps, "error {error}, with maps of density {density} {of_maps}");
    }
    // Altered visibility: from another layer, from another row of texels, and for light from the opposite side.
    let (n, layers) = (16usize, sheet.layers as usize);
    let moved = |by: usize| {
        let mut other = visibility.clone();
        // Texels rotated out of the range re-enter at its other end; the far layer is not rotated.
        other.texels[4 * n * n..4 * n * n * layers].rotate_left(4 * by);
        on_hair(&measured(&truths, &|slant, truth| sheet.transmittance_by_visibility(&other, slant, truth))).0
    };
    let turned = |slant: &Slant, truth: &TransmittanceTruth| {
        let light_ts = slant.light_ts * DVec3::new(-1.0, -1.0, 1.0);
        sheet.transmittance_by_visibility(&visibility, &Slant { light_ts, ..*slant }, truth)
    };
    let turned = on_hair(&measured(&truths, &turned)).0;
    assert_eq!(moved(0), error);
    let wrong = [moved(2 * n * n), moved(4 * n), turned];
    assert!(wrong.iter().all(|wrong| *wrong > 1.1 * error), "{error}, wrongly {wrong:?}");
}

/// Checks that block-compressed texels differ little from uncompressed ones, and need a quarter of the bytes.
#[test]
fn block_compression_keeps_visibility() {
    let sheet = sheet();
    let truths = lit(&sheet);
    let plain = baked(&sheet, None, 24);
    for quality in BcQuality::ALL {
        let blocks = baked(&sheet, Some(*quality), 24);
        let mut measured = SelfShadowErrors::default();
        for (slant, truth) in &truths {
            let [found, plain] = [&blocks, &plain].map(|v| sheet.transmittance_by_visibility(v, slant, truth));
            measured.add(slant, &found, 1.0, truth);
            measured.add_blocks(&found, &plain, truth);
        }
        let loss = measured.blocks.rmse().unwrap_or(f64::NAN);
        assert!(loss > 0.0 && loss < 0.05, "{quality:?}: {loss}");
        let mean = measured.blocks.mean().unwrap_or(f64::NAN);
        assert!(mean.abs() < 0.01, "{quality:?}: {mean}");
        assert_eq!(blocks.horizon, plain.horizon);
        // Levels have 16, 8, 4, 2 and 1 texels per side; each of the last two is one block. The sum covers the layers
        // and the far layer.
        let texels: u64 = [16u64, 8, 4, 4, 4].map(|n| n * n).iter().sum();
        assert_eq!(blocks.bytes, 7 * texels);
    }
    assert_eq!(plain.bytes, 7 * 4 * (256 + 64 + 16 + 4 + 1));
}

#[test]
fn self_shadow_configurations_differ_and_rows_have_all_columns() {
    let mut recipe = natural();
    let all = configurations(&recipe);
    assert_eq!(all[0].form, SelfShadowForm::Baked { blocks: Some(BcQuality::Basic), directions: 24 });
    assert!(all.len() > 20 && all.iter().any(|c| c.form == SelfShadowForm::Baked { blocks: None, directions: 24 }));
    for (i, a) in all.iter().enumerate() {
        assert!(all[..i].iter().all(|b| b.form != a.form), "{a:?}");
        let row = cells(&a.form, 16, &SelfShadowErrors::default(), &Cost::default());
        assert_eq!(row.len(), COLUMNS.len());
        assert_eq!(row[0] == Cell::Text("baked".into()), row[6] == Cell::Empty, "{row:?}");
    }
    let maps = SelfShadowForm::Maps { shadows: ShadowParams::default(), slant: SlantForm::Corrected };
    assert!(all[1..].iter().any(|c| c.form == maps));
    // Without baked visibility, maps are the default.
    recipe.visibility.enabled = false;
    assert_eq!(configurations(&recipe)[0].form, maps);
    recipe.slice.layers = 2;
    let whole = |form| {
        matches!(form, SelfShadowForm::Baked { .. })
            || matches!(form, SelfShadowForm::Maps { shadows, .. } if shadows.map_layers.is_none())
    };
    assert!(configurations(&recipe).iter().all(|c| whole(c.form)));
    assert_eq!(slants().len(), 15);
    assert!(slants().iter().all(|s| s.light_ts.is_normalized()));
}

#[test]
fn sampling_stride_is_odd_and_gives_the_wanted_count() {
    for (count, wanted) in [(0, 10), (10, 10), (11, 10), (65536, 6000), (1 << 20, 1 << 18)] {
        let step = stride(count, wanted);
        let taken = (0..count).step_by(step).count();
        assert!(taken <= wanted && taken * 3 >= count.min(wanted), "{count} {wanted}: {taken}");
        assert!(step % 2 == 1);
    }
    let recipe =
        Recipe { slice: SliceParams { layers: 256, tile_texels: 1024, ..SliceParams::default() }, ..natural() };
    let large = Sheet::new(&recipe, Lengths { length_m: 0.02, tile_size_m: 0.08 });
    assert!(large.err().is_some_and(|e| e.to_string().contains("slice.tile_texels")));
}
