use super::*;
use glam::Mat4;
use pelage_runtime::Sphere;

fn view() -> LightView {
    let sphere = Sphere { center: Vec3::ZERO, radius: 0.5 };
    LightView {
        clip_from_world: Mat4::IDENTITY,
        map_from_world: Mat4::IDENTITY,
        range_m: 1.0,
        extent: 1.0,
        near_m: None,
        sphere,
    }
}

/// Checks two adjacent texels with two slabs each; every slab is 0.1 deep.
#[test]
fn opacity_map_lookups_return_the_drawn_values() {
    let step = (1.0 / OPACITY_STEP) as u32;
    let near = |depth: f32| (1.0 - depth).to_bits();
    let texels = vec![near(0.25), near(0.5), 0, 0, step, 2 * step, step, 0, 0, 0, 0, 0];
    let opacity =
        DeepOpacity { size: 2, slabs: 2, slabs_per_depth: 10.0, density: 0.5, texel_m: 0.25, ..DeepOpacity::default() };
    let map = DeepMap { view: view(), opacity, form: OpacityForm::Deep, texels };
    let light = |u: f32, v: f32, depth: f32| map.light_at(Vec3::new(u, v, depth));
    for (u, depth, optical) in
        [(0.25, 0.2, 0.0), (0.25, 0.3, 0.25), (0.25, 0.4, 1.0), (0.25, 0.9, 1.5), (0.75, 0.55, 0.25), (0.75, 0.9, 0.5)]
    {
        let expected = (-optical as f32).exp();
        assert!((light(u, 0.25, depth) - expected).abs() < 1e-5, "{u}, {depth}: {}", light(u, 0.25, depth));
        // This lookup is halfway to the texel below, which has no hair. The next lookup is beyond the map's edge, and
        // is clamped to it.
        assert!((light(u, 0.5, depth) - 0.5 * (1.0 + expected)).abs() < 1e-5);
        assert!((light(u, -3.0, depth) - expected).abs() < 1e-5);
    }
    assert_eq!(map.texel_widths(0.125), 2.0);
    assert!((light(0.5, 0.25, 0.9) - 0.5 * ((-1.5f32).exp() + (-0.5f32).exp())).abs() < 1e-5);
}

#[test]
fn published_planes_ignore_hair_behind_the_last_plane() {
    let shadows = ShadowParams::default().with(|s| s.slabs = PLANES);
    let hair = [(0.1, 1.0), (0.97, 1.0)];
    let light = |form, depth| {
        let opacity = columns_of(form, &shadows, 1.0, 0.1);
        let (first, slabs) = column(form, &opacity, hair.iter().copied());
        light_in_column(form, &opacity, first, &slabs, depth)
    };
    let behind_both = f32::exp(-2.0);
    assert!((light(OpacityForm::WholeDepth, 1.0) - behind_both).abs() < 1e-4);
    assert!((light(OpacityForm::Printed, 1.0) - 1.0).abs() < 1e-4, "hair behind the last plane casts no shadow");
    let behind_one = f32::exp(-1.0);
    assert!((light(OpacityForm::Printed, 15.0 / 16.0) - behind_one).abs() < 1e-4);
    assert!((light(OpacityForm::Deep, 0.5) - behind_both).abs() < 1e-4, "the last slab contains all hair behind it");
    assert!(light(OpacityForm::Deep, 0.1) > 0.999);
}

/// Checks that thinner slabs make smaller steps, and that planes over the whole depth of a ball make large ones. In the
/// published form, light reappears at the far end of the ball.
#[test]
fn map_forms_differ_on_a_ball() {
    let ball = Ball { depth_m: 1.0, fur_m: 0.02 };
    let of = |form, slabs| ball.measure(form, &ShadowParams::default().with(|s| s.slabs = slabs));
    let deep = [4, 8, 16].map(|slabs| of(OpacityForm::Deep, slabs));
    for ((step, error), expected) in deep.into_iter().zip([1.0f64, 0.5, 0.25]) {
        assert!(
            (step - (1.0 - (-expected).exp())).abs() < 0.02,
            "step {step}, expected that of slabs with optical depth {expected}"
        );
        assert!(error < 0.06, "{error}");
    }
    let [whole, printed] = [OpacityForm::WholeDepth, OpacityForm::Printed].map(|form| of(form, PLANES));
    assert!(whole.0 > 0.9 && whole.1 > 0.5, "{whole:?}");
    assert!(printed.0 > 0.99 && printed.1 > 0.7, "{printed:?}");
}

#[test]
fn every_form_is_measured_at_every_size() {
    let all = configurations();
    assert_eq!(all.len(), 1 + 5 * 3 + 1);
    assert_eq!(all.iter().filter(|c| c.default).count(), 1);
    for form in [OpacityForm::Deep, OpacityForm::WholeDepth, OpacityForm::Printed] {
        for size in [256, 512, 1024] {
            let of = |c: &&OpacityShadowConfiguration| {
                c.study.opacity == form && c.shadows.map_size == size && c.study.thin_texels
            };
            assert_eq!(all.iter().filter(of).count(), if form == OpacityForm::Deep { 3 } else { 1 });
        }
    }
    for c in &all {
        let cells = cells(c, &OpacityShadowMeasures::default(), "timestamp-query");
        assert_eq!(cells.len(), COLUMNS.len());
        assert!(PANELS.iter().all(|p| COLUMNS.contains(&p.cost) && COLUMNS.contains(&p.error)));
    }
}
