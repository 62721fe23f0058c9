use super::*;
use crate::camera::{Camera, Projection};
use crate::params::Style;
use crate::shared::detail::detail_exponent;
use glam::Vec3;
use pelage_formats::{DetailLevel, FarLayerInfo, FurInfo};

fn levels() -> Vec<DetailLevel> {
    vec![
        DetailLevel { step: 1, full_px: 16.0, gone_px: 12.0, fins: 1.0, density: 1.0 },
        DetailLevel { step: 2, full_px: 8.0, gone_px: 8.0, fins: 0.5, density: 1.25 },
        DetailLevel { step: 4, full_px: 2.0, gone_px: 1.0, fins: 0.0, density: 1.5 },
        DetailLevel { density: 1.0, ..DetailLevel::default() },
    ]
}

fn manifest() -> Manifest {
    Manifest {
        fur: FurInfo { layers: 16, height_m: 0.1, ..FurInfo::default() },
        detail: levels(),
        coat: Some(FarLayerInfo { height: 0.75, ambient_height: 0.5, light_straight: 0.75, light_slanted: 0.5 }),
        ..Manifest::default()
    }
}

fn params() -> FrameParams {
    let projection = Projection::Perspective { fov_y_rad: 1.0, aspect: 1.0, near_m: 0.1, far_m: 100.0 };
    FrameParams::new(Camera::look_at(Vec3::Z, Vec3::ZERO, projection), [834, 424])
}

/// Checks that the layers that each level draws are together as opaque as all baked layers.
#[test]
fn layer_exponents_sum_to_the_baked_layers() {
    for baked in [2u32, 3, 4, 5, 16, 17, 64] {
        for step in [1u32, 2, 4, 8] {
            for fade in [0.0, 0.3, 1.0] {
                let gone = fade * detail_pairs(baked, step) as f32;
                let sum: f32 = (1..baked).map(|k| detail_exponent(k, baked, step, gone, 1.0, 1.0)).sum();
                assert!((sum - (baked - 1) as f32).abs() < 1e-3, "{baked} layers, step {step}, fade {fade}: {sum}");
            }
        }
    }
    // The exponent decreases towards the far fur layer.
    assert_eq!(detail_exponent(15, 16, 4, 0.0, 0.75, 0.25), 3.0);
}

#[test]
fn drawing_parameters_follow_the_level() {
    let (manifest, params) = (manifest(), params());
    let at = |level, fade| InstanceDrawing::at_level(&manifest, &params, level, fade);
    let full = at(0, 0.0);
    assert!(!full.is_reduced() && full.shell_instances() == (1..16) && full.map_layers == 16);
    let fading = at(0, 0.5);
    // The next level drops seven layers: three are gone, and the fourth is half gone.
    assert!(fading.is_reduced() && fading.detail.layers == 12 && fading.shell_instances() == (0..12));
    assert_eq!((fading.step, fading.gone, fading.detail.fins, fading.map_layers), (1, 3.5, 0.75, 16));
    let half = at(1, 0.0);
    assert_eq!((half.detail.layers, half.detail.of_layers, half.map_layers, half.detail.fins), (8, 15, 9, 0.5));
    let last = at(2, 0.25);
    assert_eq!((last.detail.layers, last.detail.coat, last.weights, last.gone), (4, 0.25, [1.125, 0.25], 0.0));
    let coat = at(3, 0.5);
    assert!(!coat.has_shells() && coat.map_layers == 1 && coat.shell_instances().is_empty());
    assert_eq!((coat.detail.coat, coat.detail.fade, coat.weights), (1.0, 0.0, [0.0, 1.0]));
    assert_eq!(fading.weights, [1.0, 1.25]);
    // An explicit number of layers takes precedence.
    let eight = params.clone().with_fur(|fur| fur.layers = Some(8));
    assert_eq!(
        InstanceDrawing::at_level(&manifest, &eight, 2, 0.5),
        InstanceDrawing::at_level(&manifest, &eight, 0, 0.0)
    );
    let bare = params.clone().with(|params| params.style = Style::Bare);
    assert!(
        !InstanceDrawing::at_level(&manifest, &bare, 3, 0.0).has_shells()
            && InstanceDrawing::at_level(&manifest, &bare, 3, 0.0).detail.coat == 0.0
    );
}

/// Checks that the outermost layers are left out up to the limit, at the weight that they have at the level.
#[test]
fn almost_empty_outer_layers_are_not_drawn() {
    let (manifest, params) = (manifest(), params());
    let drawn = |level, fade, opacities: &[f32]| {
        let all = InstanceDrawing::at_level(&manifest, &params, level, fade);
        let left = all.without_empty_layers(opacities);
        assert_eq!((left.layers, left.map_layers, left.gone), (all.layers, all.map_layers, all.gone), "only the end");
        left.shell_instances()
    };
    let ending_in = |tips: [f32; 3]| [&[0.2; 13][..], &tips].concat();
    assert_eq!(drawn(0, 0.0, &ending_in([0.2; 3])), 1..16);
    assert_eq!(drawn(0, 0.0, &ending_in([0.001; 3])), 1..13, "0.003 together");
    assert_eq!(drawn(0, 0.0, &ending_in([0.003; 3])), 1..15, "0.006 is too much for two");
    assert_eq!(drawn(0, 0.0, &[]), 1..16, "nothing is known of them");
    // Three of seven layers are gone and the fourth is half gone. The last three represent only themselves.
    assert_eq!((drawn(0, 0.5, &ending_in([0.2; 3])), drawn(0, 0.5, &ending_in([0.001; 3]))), (0..12, 0..9));
    // The outermost layer counts 2.5 times, and the one below it has the full opacity.
    assert_eq!((drawn(1, 0.0, &ending_in([0.001; 3])), drawn(1, 0.0, &ending_in([0.002; 3]))), (0..7, 0..8));
    assert_eq!(drawn(0, 0.0, &[0.0; 16]), 1..2, "at least one layer is drawn");
    assert_eq!(drawn(3, 0.0, &[0.0; 16]), 0..0, "the far fur layer has none");
}

#[test]
fn invalid_detail_parameters_are_refused() {
    for detail in
        [Detail::Auto { bias: 0.0 }, Detail::Auto { bias: f32::NAN }, Detail::Level(-1.0), Detail::Level(f32::INFINITY)]
    {
        assert!(detail.check().unwrap_err().to_string().contains("FurParams::detail"), "{detail:?}");
    }
    Detail::Full.check().unwrap();
    Detail::Level(2.5).check().unwrap();
}

/// Checks that strands appear before layers disappear, and that the far fur layer replaces both.
#[test]
fn strands_fade_in_before_layers_fade_out() {
    let (manifest, params) = (manifest(), params());
    let layers = InstanceDrawing::at_level(&manifest, &params, 1, 0.25);
    assert_eq!(layers.with_strands(0.0), layers);
    let come = layers.with_strands(0.3);
    assert_eq!((come.detail.strands, come.layer_share, come.detail.fins), (0.5, 1.0, layers.detail.fins));
    assert!(come.is_reduced() && come.draws_shells() && come.has_strands());
    let go = layers.with_strands(0.7);
    assert!(go.detail.strands == 1.0 && (go.layer_share - 0.25).abs() < 1e-6 && go.detail.fins < layers.detail.fins);
    assert!(go.weights == layers.weights && go.draws_shells());
    let all = layers.with_strands(1.0);
    assert!(
        !all.draws_shells() && all.has_shells() && all.reported().layers == 0 && all.map_layers == layers.map_layers
    );
    let coat = InstanceDrawing::at_level(&manifest, &params, 2, 0.5);
    assert_eq!((coat.with_strands(1.0).detail.strands, coat.with_strands(1.0).weights), (0.5, coat.weights));
}
