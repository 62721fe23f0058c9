//! Compares the shader functions for levels of detail with an explicit reference: Rust twin and GPU.
#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_runtime::shared::detail;
use pelage_tests::compute::evaluate;
use pelage_tests::gpu::gpu;

/// Returns by enumeration the layers that a level draws.
fn drawn_layers(baked: u32, step: u32) -> Vec<u32> {
    (1..baked).rev().step_by(step as usize).collect::<Vec<_>>().into_iter().rev().collect()
}

#[test]
fn level_layers_on_the_gpu_match_the_cpu_and_the_definition() {
    let mut cases = Vec::new();
    let mut truths = Vec::new();
    for baked in [2u32, 3, 5, 16, 17, 64, 256] {
        for step in [1u32, 2, 4, 8] {
            let list = drawn_layers(baked, step);
            assert_eq!(detail::detail_count(baked, step) as usize, list.len());
            for layer in 1..baked {
                // A drawn layer represents itself and the layers below it, down to the next drawn layer.
                let below = list.iter().rev().find(|k| **k < layer).copied().unwrap_or(0);
                let stood_for = if list.contains(&layer) { (layer - below) as f32 } else { 0.0 };
                let nth = list.iter().position(|k| *k == layer);
                cases.push([[layer as f32, baked as f32, step as f32, nth.unwrap_or(0) as f32]]);
                truths.push([stood_for, list[nth.unwrap_or(0)] as f32]);
            }
        }
    }
    let twin = |[c]: &[[f32; 4]; 1]| {
        let [layer, baked, step, nth] = c.map(|x| x as u32);
        [detail::represented_layers(layer, baked, step) as f32, detail::detail_layer(nth, baked, step, 0.0) as f32]
    };
    cases.iter().zip(&truths).for_each(|(case, truth)| assert_eq!(twin(case), *truth, "{case:?}"));
    let Some(gpu) = gpu("layers_of_levels") else { return };
    let expression = "vec4(f32(layers_stood_for(u32(in_0.x), u32(in_0.y), u32(in_0.z))), \
                      f32(detail_layer(u32(in_0.w), u32(in_0.y), u32(in_0.z), 0.0)), 0.0, 0.0)";
    for ((case, truth), found) in cases.iter().zip(&truths).zip(evaluate(gpu, detail::WGSL, expression, &cases)) {
        assert_eq!(&found[..2], truth, "{case:?} on the device");
    }
}

/// Checks the transition between two levels.
#[test]
fn layers_between_levels_on_the_gpu_match_the_cpu() {
    let mut cases: Vec<[[f32; 4]; 1]> = Vec::new();
    for baked in [2u32, 5, 16, 17, 64] {
        for step in [1u32, 2, 4] {
            let pairs = detail::detail_pairs(baked, step);
            for gone in (0..=2 * pairs).map(|half| 0.5 * half as f32) {
                for index in 0..detail::detail_count(baked, step) - gone as u32 {
                    cases.push([[index as f32, baked as f32, step as f32, gone]]);
                }
            }
        }
    }
    let Some(gpu) = gpu("layers_between_levels") else { return };
    let expression = "vec4(f32(detail_layer(u32(in_0.x), u32(in_0.y), u32(in_0.z), in_0.w)), \
                      detail_fade(1u + u32(in_0.x) % (u32(in_0.y) - 1u), u32(in_0.y), u32(in_0.z), in_0.w), \
                      detail_exponent(1u + u32(in_0.x) % (u32(in_0.y) - 1u), u32(in_0.y), u32(in_0.z), in_0.w, \
                      1.0, 1.25), 0.0)";
    for (case, found) in cases.iter().zip(evaluate(gpu, detail::WGSL, expression, &cases)) {
        let ([index, baked, step], gone) = ([case[0][0], case[0][1], case[0][2]].map(|x| x as u32), case[0][3]);
        let layer = 1 + index % (baked - 1);
        let twin = [
            detail::detail_layer(index, baked, step, gone) as f32,
            detail::detail_fade(layer, baked, step, gone),
            detail::detail_exponent(layer, baked, step, gone, 1.0, 1.25),
        ];
        assert_eq!(found[..3], twin, "{case:?}");
    }
}

#[test]
fn exponents_heights_and_light_on_the_gpu_match_the_cpu() {
    let cases: Vec<[[f32; 4]; 1]> =
        (0..200).map(|i| [[(1 + i % 15) as f32, (i % 7) as f32 / 7.0, 1.0 + (i % 5) as f32, 0.1 * i as f32]]).collect();
    let Some(gpu) = gpu("exponents_heights_and_light") else { return };
    let expression = "vec4(detail_exponent(u32(in_0.x), 16u, 2u, 7.0 * in_0.y, 1.0, 1.25), \
                      visible_height(in_0.x / 15.0, in_0.z, 16u), coat_light(in_0.z, 1.0, in_0.w), \
                      light_within(0.05 * in_0.w, in_0.z))";
    for (case, found) in cases.iter().zip(evaluate(gpu, detail::WGSL, expression, &cases)) {
        let [layer, fade, number, slope] = case[0];
        let twin = [
            detail::detail_exponent(layer as u32, 16, 2, 7.0 * fade, 1.0, 1.25),
            detail::visible_height(layer / 15.0, number, 16),
            detail::far_layer_light(number, 1.0, slope),
            detail::light_within(0.05 * slope, number),
        ];
        // The tolerance of the last value is larger, because a device's logarithm of numbers near 1 is imprecise.
        for ((found, twin), least) in found.iter().zip(twin).zip([1e-6, 1e-6, 1e-6, 1e-4]) {
            assert!((found - twin).abs() <= least * twin.abs().max(1.0), "{case:?}: {found}, expected {twin}");
        }
    }
}

#[test]
fn light_within_a_layer_matches_the_stack_it_represents() {
    for alpha in [0.01, 0.2, 0.77, 0.99f32] {
        for layers in [1, 2, 4, 7] {
            let (mut seen, mut lit, mut behind, mut light) = (0.0, 0.0, 1.0, 1.0);
            for _ in 0..layers {
                seen += behind * alpha;
                lit += behind * light * alpha;
                behind *= 1.0 - alpha;
                light *= (1.0 - alpha).sqrt();
            }
            let found = detail::light_within(alpha, layers as f32);
            assert!((found - lit / seen).abs() < 2e-5, "{alpha}, {layers}: {found}, expected {}", lit / seen);
        }
    }
    // The function is continuous where a layer begins to represent several, and defined for absent and for opaque hair.
    assert!((detail::light_within(0.5, 1.001) - 1.0).abs() < 1e-3);
    for alpha in [0.0, 1.0] {
        assert!((0.0..=1.0).contains(&detail::light_within(alpha, 4.0)));
    }
}
