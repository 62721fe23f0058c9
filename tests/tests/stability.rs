//! Where the methods of hair and slicing fail, and that ours do not: one module per row of the stability table.
//!
//! Every test runs two forms on the same data, the safe one through the public API and the naive one written out here, and asserts
//! that the first stays within its bound *and* that the second does not: a test whose data never reached the cliff would prove nothing.

#![allow(clippy::unwrap_used, reason = "tests fail by panicking")]

use glam::Vec3;
use pelage_bake::hair::{Strands, VolumeParams, simulate};
use pelage_bake::recipe::{ColorParams, HairParams, SliceParams, Style};
use pelage_bake::textures::{EXTINCTION, ShellSet, collect_layers};
use pelage_formats::{TextureFormat, decode_direction};

fn grow(hair: &HairParams, height: f32) -> Strands {
    simulate(hair, &ColorParams::default(), &VolumeParams { height }).unwrap()
}

fn slice(strands: &Strands, layers: u32, tile_texels: u32) -> ShellSet {
    let params = SliceParams { layers, tile_texels, ..SliceParams::default() };
    collect_layers(strands, &params, TextureFormat::Rgba8Unorm).unwrap()
}

/// Opacity of a texel of a layer, 0..=1.
fn opacity(set: &ShellSet, layer: usize, level: usize, texel: usize) -> f64 {
    f64::from(set.layers[layer].color[level][4 * texel + 3]) / 255.0
}

fn texels(set: &ShellSet, level: usize) -> usize {
    (set.texels as usize >> level).pow(2)
}

/// Transmittance of all layers above the skin, texel by texel.
fn transmittances(set: &ShellSet, level: usize) -> Vec<f64> {
    let column = |texel| (1..set.layers.len()).map(|k| 1.0 - opacity(set, k, level, texel)).product();
    (0..texels(set, level)).map(column).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

mod direction_textures {
    //! The mean of opposing tangents is zero or rounding noise; normalising it gives NaN or any direction.

    use super::*;
    use pelage_bake::textures::direction::{encode_mean, resolve};

    /// Hairs through the middle of the tile, crossing at one height, their tangents at `angle` to either side of the normal.
    fn crossing(angle_deg: f32) -> Strands {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        let middle = Vec3::new(0.5, 0.5, 0.5);
        let arm = |x: f32| Vec3::new(x * sin, 0.0, cos) * 0.4;
        Strands {
            points: vec![middle - arm(1.0), middle + arm(1.0), middle - arm(-1.0), middle + arm(-1.0)],
            radii: vec![0.02; 4],
            colors: vec![Vec3::ONE; 4],
            offsets: vec![0, 2, 4],
            height: 1.0,
            root_color: Vec3::ONE,
        }
    }

    #[test]
    fn opposing_hairs_leave_a_direction_or_say_that_there_is_none() {
        let mut naive_failures = 0;
        for angle in (0..=90).map(|a| a as f32) {
            let strands = crossing(angle);
            for format in [TextureFormat::Rg8Unorm, TextureFormat::Rgba8Unorm] {
                let params = SliceParams { layers: 5, tile_texels: 32, ..SliceParams::default() };
                let set = collect_layers(&strands, &params, format).unwrap();
                for texel in set
                    .layers
                    .iter()
                    .flat_map(|l| &l.direction)
                    .flatten()
                    .collect::<Vec<_>>()
                    .chunks(format.components() as usize)
                {
                    let mut values = [0.0, 0.0, 0.0, 1.0];
                    values.iter_mut().zip(texel).for_each(|(v, b)| *v = f32::from(**b) / 255.0);
                    let d = decode_direction(values, format);
                    assert!(d.is_finite() && d.length() < 1.01, "{angle} deg: {d}");
                }
            }
            // Where the two overlap alone, the mean leans to neither side, and its length says how far they agree.
            let tangents =
                [strands.points[1] - strands.points[0], strands.points[3] - strands.points[2]].map(Vec3::normalize);
            let (unit, confidence) = resolve((tangents[0] + tangents[1]) * 0.5);
            assert!((unit - Vec3::Z).length() < 1e-3, "{angle} deg: {unit}");
            assert!((confidence - angle.to_radians().cos()).abs() < 1e-3);

            let flat = tangents.map(|t| Vec3::new(t.x, t.y, 0.0));
            let naive = (flat[0] + flat[1]) / (flat[0] + flat[1]).length();
            let safe = resolve((flat[0] + flat[1]) * 0.5).0;
            assert!(safe.is_normalized());
            naive_failures += usize::from(!naive.is_finite());
        }
        assert!(naive_failures > 45, "opposing hairs must have cancelled in f32, did {naive_failures} times of 91");
    }

    #[test]
    fn a_cancelled_mean_is_stored_as_upright_or_as_nothing() {
        let noise = Vec3::new(3e-8, -6e-8, 0.0);
        assert_eq!(encode_mean(noise, TextureFormat::Rg8Unorm)[..2], [128, 128]);
        assert_eq!(encode_mean(noise, TextureFormat::Rgba8Unorm)[..3], [128, 128, 128]);
        // Naive: rounding noise becomes a direction as firm as any.
        let naive = noise / noise.length();
        assert!((naive.length() - 1.0).abs() < 1e-3 && naive.z == 0.0);
    }
}

mod opacity_and_layer_count {
    //! The same fur at 8 and at 64 layers must be as dense. Naive: a strand has the same opacity in each layer it crosses.

    use super::*;

    #[test]
    fn coverage_and_mean_transmittance_agree_within_two_percent() {
        for (style, density, lean) in [
            (Style::Straight, 150, 0.0),
            (Style::Straight, 700, 0.5),
            (Style::Curly, 300, 0.2),
            (Style::Messy, 500, 0.9),
        ] {
            let strands = grow(&HairParams { style, density, lean, ..HairParams::default() }, 0.4);
            let few = transmittances(&slice(&strands, 8, 64), 0);
            for layers in [16, 64] {
                let many = transmittances(&slice(&strands, layers, 64), 0);
                let difference = (mean(&few) - mean(&many)).abs();
                assert!(difference < 0.02, "{style:?}: mean transmittance differs by {difference} at {layers} layers");
                let covered = |t: &[f64]| t.iter().filter(|t| **t < 0.5).count() as f64 / t.len() as f64;
                let difference = (covered(&few) - covered(&many)).abs();
                assert!(difference < 0.02, "{style:?}: coverage differs by {difference} at {layers} layers");
            }
            // 64 layers with the opacities of 8.
            let set = slice(&strands, 8, 64);
            let naive: Vec<_> = (0..texels(&set, 0))
                .map(|texel| (1..64).map(|k| 1.0 - opacity(&set, (k * 7_usize).div_ceil(63), 0, texel)).product())
                .collect();
            let difference = (mean(&few) - mean(&naive)).abs();
            assert!(difference > 0.04, "{style:?}: the naive form differs by {difference} only");
        }
    }
}

mod product_of_stored_opacities {
    //! In a fine stack a faint hair has less than half a step of 8-bit opacity per layer. Naive: round each layer by itself.

    use super::*;

    /// Upright hairs far apart, all of one radius.
    fn faint(radius: f32, height: f32) -> Strands {
        let roots: Vec<_> =
            (0..16).map(|i| Vec3::new((i % 4) as f32 + 0.37, (i / 4) as f32 + 0.61, 0.0) * 0.25).collect();
        Strands {
            points: roots.iter().flat_map(|r| [*r, *r + Vec3::Z * height]).collect(),
            radii: vec![radius; 32],
            colors: vec![Vec3::ONE; 32],
            offsets: (0..=16).map(|i| 2 * i).collect(),
            height,
            root_color: Vec3::ONE,
        }
    }

    /// Optical depth of a whole column of each texel in f64, from the definition: the hair's depth spread by a Gaussian that sums
    /// to one over the texels.
    fn depths(strands: &Strands, n: usize, filter_width: f64) -> Vec<f64> {
        let mut depths = vec![0.0; n * n];
        for root in strands.points.iter().step_by(2) {
            let radius = f64::from(strands.radii[0]);
            let variance = 0.5 * (radius * n as f64).powi(2) + filter_width * filter_width;
            let total =
                f64::from(EXTINCTION) * std::f64::consts::PI * radius * f64::from(strands.height) * (n * n) as f64;
            let weights = |center: f32| {
                let center = f64::from(center) * n as f64;
                let of = |i: usize| {
                    let d = (i as f64 + 0.5 - center).abs();
                    let d = d.min(n as f64 - d);
                    (-0.5 * d * d / variance).exp()
                };
                let all: Vec<_> = (0..n).map(of).collect();
                let sum: f64 = all.iter().sum();
                all.into_iter().map(move |w| w / sum).collect::<Vec<_>>()
            };
            let (wx, wy) = (weights(root.x), weights(root.y));
            for (i, depth) in depths.iter_mut().enumerate() {
                *depth += total * wx[i % n] * wy[i / n];
            }
        }
        depths
    }

    #[test]
    fn the_product_follows_f64_from_4_to_256_layers() {
        let strands = faint(0.0016, 0.2);
        let depths = depths(&strands, 64, 0.5);
        let truth = mean(&depths.iter().map(|d| (-d).exp()).collect::<Vec<_>>());
        let mut worst_naive = 0.0f64;
        for layers in [4, 8, 16, 32, 64, 128, 256] {
            let stored = mean(&transmittances(&slice(&strands, layers, 64), 0));
            let relative = (stored - truth).abs() / (1.0 - truth);
            assert!(relative < 0.03, "{layers} layers cover {}, the truth is {}", 1.0 - stored, 1.0 - truth);
            let slabs = f64::from(layers - 1);
            let naive = |depth: &f64| {
                let rounded = (255.0 * (1.0 - (-depth / slabs).exp())).round() / 255.0;
                (1.0 - rounded).powf(slabs)
            };
            let naive = mean(&depths.iter().map(naive).collect::<Vec<_>>());
            worst_naive = worst_naive.max((naive - truth).abs() / (1.0 - truth));
        }
        assert!(worst_naive > 0.1, "rounding each layer by itself is off by {worst_naive} only");
    }
}

mod mip_levels {
    //! Naive: each layer's opacity is averaged by itself. Layers of one hair stand above each other, so that makes distant fur too
    //! opaque (and alpha-tested fur, whose coverage falls, too thin).

    use super::*;

    #[test]
    fn coverage_is_kept_within_two_percent_at_every_level() {
        for (style, lean) in [(Style::Straight, 0.0), (Style::Straight, 0.6), (Style::Curly, 0.2), (Style::Messy, 0.5)]
        {
            let strands = grow(&HairParams { style, lean, density: 250, ..HairParams::default() }, 0.4);
            let set = slice(&strands, 16, 64);
            let truth = mean(&transmittances(&set, 0));
            let mut worst_naive = 0.0f64;
            for level in 1..=6 {
                let kept = mean(&transmittances(&set, level));
                assert!(
                    (kept - truth).abs() < 0.02,
                    "{style:?} level {level}: transmittance {kept}, at level 0 {truth}"
                );
                let (n, side) = (64usize >> level, 1usize << level);
                let column = |texel: usize| {
                    let average = |k| {
                        let fine =
                            (0..side * side).map(|i| (texel / n * side + i / side) * 64 + texel % n * side + i % side);
                        mean(&fine.map(|fine| opacity(&set, k, 0, fine)).collect::<Vec<_>>())
                    };
                    (1..16).map(|k| 1.0 - average(k)).product::<f64>()
                };
                let naive = mean(&(0..n * n).map(column).collect::<Vec<_>>());
                worst_naive = worst_naive.max((naive - truth).abs());
            }
            assert!(worst_naive > 0.04, "{style:?}: the naive form is off by {worst_naive} only");
        }
    }

    /// Mean colour seen from above over black: premultiplied colours, layer over layer.
    #[test]
    fn mean_colour_is_kept_too() {
        let set = slice(&grow(&HairParams { density: 250, ..HairParams::default() }, 0.4), 16, 64);
        let seen = |level: usize| {
            let column = |texel: usize| {
                let (mut green, mut t) = (0.0, 1.0);
                for k in (0..16).rev() {
                    green +=
                        t * f64::from(pelage_bake::textures::srgb_to_linear(set.layers[k].color[level][4 * texel + 1]));
                    t *= 1.0 - opacity(&set, k, level, texel);
                }
                green
            };
            mean(&(0..texels(&set, level)).map(column).collect::<Vec<_>>())
        };
        let truth = seen(0);
        for level in 1..=6 {
            assert!((seen(level) / truth - 1.0).abs() < 0.03, "level {level}: {}, at level 0 {truth}", seen(level));
        }
    }
}

mod hair_simulation {
    //! Large steps, stiff curls, strong lean. Naive: explicit Euler on position and velocity.

    use super::*;

    fn arc(points: &[Vec3]) -> f32 {
        points.windows(2).map(|w| w[0].distance(w[1])).sum()
    }

    #[test]
    fn length_is_kept_and_the_volume_not_left_under_extreme_forces() {
        let mut strands_seen = 0;
        for style in Style::ALL.iter().copied() {
            for lean in [0.0, 0.5, 1.0] {
                for frizz in [0.0, 1.0] {
                    for (curl_radius, curl_pitch) in
                        [(0.0, 1e-3), (0.03, 0.18), (1.0, 1e-3), (1e-3, 1e-3), (1.0, 100.0)]
                    {
                        for height in [1e-3, 0.4, 50.0, 1e3] {
                            let hair = HairParams {
                                style,
                                lean,
                                frizz,
                                curl_radius,
                                curl_pitch,
                                density: 9,
                                length_variation: 0.0,
                                ..HairParams::default()
                            };
                            let strands = grow(&hair, height);
                            strands.validate().unwrap();
                            for strand in 0..strands.len() {
                                let points = &strands.points[strands.range(strand)];
                                let stretch = arc(points) / height;
                                assert!((stretch - 1.0).abs() < 0.01, "{hair:?} at {height}: stretched by {stretch}");
                                let slack = strands.height * 1e-5;
                                let inside = |p: &Vec3| p.z >= -slack && p.z <= strands.height + slack;
                                assert!(points.iter().all(inside), "{hair:?} at {height} leaves the volume");
                                strands_seen += 1;
                            }
                            assert!(strands.height <= height * 1.001);
                        }
                    }
                }
            }
        }
        assert_eq!(strands_seen, 9 * Style::ALL.len() * 3 * 2 * 5 * 4);
    }

    #[test]
    fn explicit_integration_of_the_same_forces_stretches_and_blows_up() {
        // A stiff curl followed in 16 steps: velocity relaxes to a turning target, position follows velocity.
        let naive = |stiffness: f32| {
            let (steps, step) = (16, 1.0 / 16.0);
            let (mut p, mut v) = (Vec3::ZERO, Vec3::Z);
            let mut points = vec![p];
            for i in 0..steps {
                let (sin, cos) = (i as f32 * 1.1).sin_cos();
                let target = Vec3::new(0.8 * cos, 0.8 * sin, 0.6);
                v += (target - v) * (stiffness * step);
                p += v * step;
                points.push(p);
            }
            arc(&points)
        };
        assert!((naive(7.0) - 1.0).abs() > 0.01, "soft: {}", naive(7.0));
        assert!(naive(60.0) > 100.0, "stiff: {}", naive(60.0));
    }
}
