use super::*;

fn towards(angle_deg: f64, azimuth_deg: f64) -> DVec3 {
    let (a, b) = (angle_deg.to_radians(), azimuth_deg.to_radians());
    DVec3::new(a.sin() * b.cos(), a.sin() * b.sin(), a.cos())
}

/// Returns a volume of `layers` layers above layer 0. `alpha` returns the opacity for a layer (from 1), column and row.
fn volume(texels: u32, layers: usize, height: f64, alpha: impl Fn(usize, u32, u32) -> f64) -> SampledVolume {
    let texel = |k: usize, i: u32| alpha(k, i % texels, i / texels);
    let opacities: Vec<Vec<f64>> = (1..=layers).map(|k| (0..texels * texels).map(|i| texel(k, i)).collect()).collect();
    SampledVolume::from_opacities(texels, height, &opacities).unwrap_or_else(|e| panic!("{e}"))
}

/// Returns a volume in which opacity varies from texel to texel.
fn rough() -> SampledVolume {
    volume(16, 7, 0.45, |k, x, y| f64::from((x * 7 + y * 13 + k as u32 * 29) % 17) / 20.0)
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "found {a}, expected {b} ± {tolerance}");
}

#[test]
fn uniform_block_follows_the_beer_lambert_law() {
    let (layers, height, alpha) = (15, 0.4, 0.08f64);
    let block = volume(8, layers, height, |_, _, _| alpha);
    let tau = -(1.0 - alpha).ln();
    for angle in [0.0, 30.0, 45.0, 60.0, 75.0, 89.0] {
        for azimuth in [0.0, 33.0, 90.0, 200.0] {
            let light = towards(angle, azimuth);
            for k in 0..=layers {
                // A point on layer 0 has all layers in front of it; on any other layer, it has half of that layer and
                // all above it.
                let crossed = if k == 0 { layers as f64 } else { (layers - k) as f64 + 0.5 };
                let truth = (-tau * crossed / angle.to_radians().cos()).exp();
                let z = k as f64 * height / layers as f64;
                close(block.transmittance(0.3, 0.9, z, light), truth, 1e-12);
                // The length of the light's direction has no effect.
                close(block.transmittance(0.3, 0.9, z, light * 7.0), truth, 1e-12);
            }
        }
    }
}

#[test]
fn vertical_transmittance_is_the_product_of_the_layers() {
    let volume = rough();
    for (i, t) in volume.layer_transmittances(0, DVec3::Z).into_iter().enumerate() {
        let product: f64 = (1..8).map(|k| 1.0 - ((i % 16 * 7 + i / 16 * 13 + k * 29) % 17) as f64 / 20.0).product();
        close(t, product, 1e-12);
    }
}

#[test]
fn single_layer_has_a_tent_shaped_optical_depth() {
    let (layers, height, alpha) = (9, 0.3, 0.7f64);
    let single = volume(8, layers, height, |k, _, _| if k == 4 { alpha } else { 0.0 });
    let (spacing, tau) = (height / layers as f64, -(1.0 - alpha).ln());
    // Over the height, the extinction of a single layer is a tent that extends one spacing to both sides. A point
    // within the tent has the rest of it ahead.
    for (z, share) in [(0.0, 1.0), (3.0, 1.0), (3.5, 0.875), (4.0, 0.5), (4.5, 0.125), (5.0, 0.0), (9.7, 0.0)] {
        for angle in [0.0, 40.0, 75.0] {
            let truth = (-tau * share / f64::to_radians(angle).cos()).exp();
            close(single.transmittance(0.1, 0.2, z * spacing, towards(angle, 20.0)), truth, 1e-12);
        }
    }
}

/// Checks an upright sheet across u. A ray along v within the sheet meets nothing else; a ray along u crosses the whole
/// sheet once per tile.
#[test]
fn upright_sheet_absorbs_by_its_thickness() {
    let (texels, layers, height, alpha) = (16, 8, 0.5, 0.4f64);
    let sheet = volume(texels, layers, height, |_, x, _| if x == 5 { alpha } else { 0.0 });
    let extinction = -(1.0 - alpha).ln() / (height / layers as f64);
    let middle = 5.5 / 16.0;
    let light = towards(60.0, 0.0);
    // Across the sheet, extinction is a tent of one texel to both sides, equivalent to one texel's width, crossed at
    // sin(60°). The ray from the mesh surface covers 0.5·tan(60°) = 0.87 tiles. It starts so that it crosses the sheet
    // once, in the upper part of the volume.
    close(sheet.transmittance(middle - 0.3, 0.4, 0.0, light), (-extinction / 16.0 / light.x).exp(), 1e-12);
    // A ray along v in the middle plane of the sheet meets the sheet's full extinction everywhere. A ray one texel
    // beside this plane meets none.
    let along = towards(60.0, 90.0);
    close(sheet.transmittance(middle, 0.4, 0.0, along), (-extinction * height / along.z).exp(), 1e-9);
    close(sheet.transmittance(middle + 1.0 / 16.0, 0.4, 0.0, along), 1.0, 1e-12);
    close(
        sheet.transmittance(middle + 0.5 / 16.0, 0.4, 0.0, along),
        (-0.5 * extinction * height / along.z).exp(),
        1e-9,
    );
}

/// Compares the exact integral with midpoint steps, whose error is proportional to the square of the step length.
#[test]
fn steps_converge_to_the_integral() {
    let volume = rough();
    let extinction = |p: DVec3| {
        let (n, q) =
            (volume.texels as i64, p * DVec3::new(16.0, 16.0, 1.0 / volume.spacing) - DVec3::new(0.5, 0.5, 0.0));
        if !(0.5..volume.layers as f64 + 0.5).contains(&q.z) {
            return 0.0;
        }
        let mut sum = 0.0;
        for corner in 0..8i64 {
            let step = [corner & 1, corner >> 1 & 1, corner >> 2];
            let cell = [0, 1, 2].map(|a| q[a].floor() as i64 + step[a]);
            let weight: f64 = (0..3).map(|a| 1.0 - (q[a] - cell[a] as f64).abs()).product();
            let layer = cell[2].clamp(1, volume.layers as i64) - 1;
            let index = (layer * n + cell[1].rem_euclid(n)) * n + cell[0].rem_euclid(n);
            sum += weight * volume.extinction[index as usize];
        }
        sum
    };
    for (angle, azimuth) in [(20.0, 10.0), (60.0, 100.0), (75.0, 222.0)] {
        let light = towards(angle, azimuth);
        let start = DVec3::new(0.37, 0.61, 2.3 * volume.spacing);
        let length = ((volume.layers as f64 + 0.5) * volume.spacing - start.z) / light.z;
        let stepped = |steps: u32| {
            let step = length / f64::from(steps);
            let depth: f64 = (0..steps).map(|i| step * extinction(start + light * step * (f64::from(i) + 0.5))).sum();
            (-depth).exp()
        };
        let exact = volume.transmittance(start.x, start.y, start.z, light);
        let errors = [200, 2_000, 20_000].map(|steps| (stepped(steps) - exact).abs());
        assert!(errors[2] < 1e-7 && errors[2] < errors[0] / 20.0, "{angle}°: {exact}, errors {errors:?}");
        assert!(exact > 1e-6, "{angle}°: {exact} is too dark to compare");
    }
}

#[test]
fn transmittance_is_periodic_and_within_its_range() {
    let volume = rough();
    for i in 0..200 {
        let f = f64::from(i);
        let (u, v, z) = ((f * 0.618).fract(), (f * 0.381).fract(), 0.5 * (f * 0.271).fract());
        let light = towards(89.0 * (f * 0.137).fract(), 360.0 * (f * 0.911).fract());
        let t = volume.transmittance(u, v, z, light);
        assert!((0.0..=1.0).contains(&t), "{t}");
        close(volume.transmittance(u + 3.0, v - 2.0, z, light), t, 1e-9);
        // From a point farther up along the ray, less of the volume is ahead.
        assert!(volume.transmittance(u + 0.1 * light.x, v + 0.1 * light.y, z + 0.1 * light.z, light) >= t - 1e-12);
    }
    for light in [DVec3::X, -DVec3::Z, DVec3::ZERO, DVec3::NAN, DVec3::new(1.0, 0.0, -1e-9)] {
        assert_eq!(volume.transmittance(0.5, 0.5, 0.1, light), 0.0, "{light}");
    }
    assert_eq!(volume.transmittance(0.5, 0.5, 1.0, towards(60.0, 0.0)), 1.0);
    // An almost horizontal ray is absorbed, or counts as never leaving the fur.
    assert!(volume.transmittance(0.5, 0.5, 0.1, DVec3::new(1.0, 0.3, 1e-12)) < 1e-15);
    let empty = self::volume(4, 2, 0.1, |_, _, _| 0.0);
    assert_eq!(empty.transmittance(0.5, 0.5, 0.0, towards(80.0, 12.0)), 1.0);
    assert_eq!(empty.transmittance(0.5, 0.5, 0.01, DVec3::new(1.0, 0.0, 1e-12)), 0.0);
}

#[test]
fn opaque_texels_are_capped_and_malformed_volumes_refused() {
    let opaque = volume(2, 1, 0.1, |_, _, _| 1.0);
    close(opaque.transmittance(0.5, 0.5, 0.0, DVec3::Z), 0.03, 1e-12);
    for (texels, height, opacities) in [
        (2, 0.1, vec![]),
        (2, 0.1, vec![vec![0.0; 3]]),
        (0, 0.1, vec![vec![]]),
        (1, 0.0, vec![vec![0.5]]),
        (1, f64::NAN, vec![vec![0.5]]),
        (1, 0.1, vec![vec![1.5]]),
        (1, 0.1, vec![vec![f64::NAN]]),
    ] {
        assert!(SampledVolume::from_opacities(texels, height, &opacities).is_err(), "{texels} {height} {opacities:?}");
    }
    assert!(SampledVolume::new(&ShellSet::default(), 0.1).is_err());
}
