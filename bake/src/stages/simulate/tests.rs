use super::*;
use crate::recipe::{HairColors, Style, natural};
use crate::stages::fixtures::on_threads;

fn grow(change: impl FnOnce(&mut HairParams)) -> Strands {
    let mut params = HairParams { density: 120, ..natural().hair };
    change(&mut params);
    simulate(&params, &ColorParams::default(), &VolumeParams::default()).unwrap()
}

#[test]
fn simulated_hair_does_not_depend_on_thread_count() {
    for style in Style::ALL {
        let on = |threads| on_threads(threads, || grow(|p| p.style = *style));
        assert_eq!(on(1), on(4));
    }
}

#[test]
fn seeds_and_styles_change_the_hair() {
    let base = grow(|_| {});
    assert_ne!(base.points, grow(|p| p.seed = 2).points);
    for style in &Style::ALL[1..] {
        assert_ne!(base.points, grow(|p| p.style = *style).points, "{style:?}");
    }
}

#[test]
fn roots_cover_the_tile_evenly() {
    for density in [1u32, 2, 3, 7, 100, 700, 1023] {
        let strands = grow(|p| p.density = density);
        assert_eq!(strands.len(), density as usize);
        strands.validate().unwrap();
        let roots: Vec<_> = (0..strands.len()).map(|i| strands.points[strands.range(i).start]).collect();
        assert!(roots.iter().all(|r| (0.0..=1.0).contains(&r.x) && (0.0..=1.0).contains(&r.y) && r.z == 0.0));
        if density >= 100 {
            let mut quarters = [0u32; 4];
            for r in &roots {
                quarters[usize::from(r.x >= 0.5) + 2 * usize::from(r.y >= 0.5)] += 1;
            }
            let fair = density / 4;
            assert!(quarters.iter().all(|q| q.abs_diff(fair) <= 4 + fair / 8), "{density}: {quarters:?}");
        }
    }
}

#[test]
fn lean_bends_towards_its_direction() {
    let tip_offset = |degrees: f32, lean: f32| {
        let strands = grow(|p| {
            p.lean = lean;
            p.lean_direction_deg = degrees;
        });
        let sum: Vec3 = (0..strands.len())
            .map(|i| strands.range(i))
            .map(|r| strands.points[r.end - 1] - strands.points[r.start])
            .sum();
        sum / strands.len() as f32
    };
    let to_v = tip_offset(0.0, 0.7);
    assert!(to_v.y > 0.1 && to_v.x.abs() < 0.02, "{to_v}");
    let to_u = tip_offset(90.0, 0.7);
    assert!(to_u.x > 0.1 && to_u.y.abs() < 0.02, "{to_u}");
    assert!(tip_offset(0.0, 1.0).z < tip_offset(0.0, 0.5).z && tip_offset(0.0, 0.5).z < tip_offset(0.0, 0.0).z);
}

#[test]
fn curls_have_the_radius_and_pitch_asked_for() {
    let (radius, pitch) = (0.03, 0.2);
    let params = HairParams {
        style: Style::Curly,
        density: 1,
        lean: 0.0,
        frizz: 0.0,
        length_variation: 0.0,
        curl_radius: radius,
        curl_pitch: pitch,
        ..natural().hair
    };
    let strands = simulate(&params, &ColorParams::default(), &VolumeParams { height: 2.0 }).unwrap();
    let points = &strands.points[strands.points.len() / 2..];
    let turn = (pitch * pitch + (std::f32::consts::TAU * radius).powi(2)).sqrt();
    let per_turn = (turn / (points[1] - points[0]).length()).round() as usize;
    // After half a turn the trail is on the other side of the axis; after a whole turn it is one pitch higher.
    let across = (points[per_turn / 2] - points[0]).truncate().length();
    let along = (points[per_turn] - points[0]).length();
    assert!((across / (2.0 * radius) - 1.0).abs() < 0.12, "diameter {across}");
    assert!((along / pitch - 1.0).abs() < 0.05, "pitch {along}");
}

/// Returns the mean distance of strand tips from the mean tip of their lock. The locks are those of `wet` hair.
fn spread_of_locks(params: &HairParams, height: f32) -> f32 {
    let strands = simulate(params, &ColorParams::default(), &VolumeParams { height }).unwrap();
    let locks = Locks::new(params.seed, params.clump_count, params.density, height);
    let mut tips: std::collections::BTreeMap<u32, Vec<Vec3>> = std::collections::BTreeMap::new();
    for range in (0..strands.len()).map(|i| strands.range(i)) {
        let lock = locks.lock_at(strands.points[range.start].truncate());
        // Tips are relative to the lock's centre, so that locks are not split at the border of the tile.
        tips.entry(lock.index).or_default().push(strands.points[range.end - 1] - lock.center.extend(0.0));
    }
    let spread = |tips: &Vec<Vec3>| {
        let mean = tips.iter().sum::<Vec3>() / tips.len() as f32;
        tips.iter().map(|t| t.distance(mean)).sum::<f32>()
    };
    tips.values().map(spread).sum::<f32>() / strands.len() as f32
}

#[test]
fn wet_hair_gathers_into_locks() {
    for (height, clump_count) in [(0.4, None), (0.4, Some(60)), (0.13, Some(80)), (1.5, Some(9))] {
        let spread = |style, clump| {
            let hair = HairParams { style, clump, clump_count, density: 900, length_variation: 0.0, ..natural().hair };
            spread_of_locks(&hair, height)
        };
        let (straight, loose, wet) = (spread(Style::Straight, 1.0), spread(Style::Wet, 0.0), spread(Style::Wet, 1.0));
        assert!(wet < 0.35 * straight, "{height} {clump_count:?}: straight {straight}, wet {wet}");
        assert!(loose > 0.8 * straight, "{height} {clump_count:?}: without clumping {loose}, straight {straight}");
    }
}

#[test]
fn wet_and_lying_hair_is_lower_and_wet_hair_darker() {
    let heights = |style| {
        let strands = grow(|p| p.style = style);
        strands.points.iter().map(|p| p.z).sum::<f32>() / strands.points.len() as f32
    };
    let straight = heights(Style::Straight);
    assert!(heights(Style::Wet) < 0.85 * straight && heights(Style::Lying) < 0.45 * straight);
    let (dry, wet) = (grow(|_| {}).root_color, grow(|p| p.style = Style::Wet).root_color);
    assert!((wet - dry * StyleForces::of(Style::Wet).color).length() < 1e-6);
}

#[test]
fn out_of_range_parameters_are_errors() {
    let simulate = |p: &HairParams, h: f32| simulate(p, &ColorParams::default(), &VolumeParams { height: h });
    for height in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(simulate(&natural().hair, height).unwrap_err().to_string().contains("hair.length_m"));
    }
    let error = simulate(&HairParams { density: 0, ..natural().hair }, 0.4).unwrap_err().to_string();
    assert!(error.contains("hair.density"), "{error}");
}

#[test]
fn colour_runs_from_root_to_tip() {
    let color = ColorParams { variation: 0.0, ..ColorParams::default() };
    let strands = simulate(&natural().hair, &color, &VolumeParams::default()).unwrap();
    let range = strands.range(5);
    assert!((strands.colors[range.start] - linear(HairColors::BROWN.root)).length() < 1e-6);
    assert!((strands.colors[range.end - 1] - linear(HairColors::BROWN.tip)).length() < 1e-6);
    assert_eq!(strands.range(strands.len()), 0..0);
}

/// Grows guard hair of 200 strands and underfur of 600.
fn guard_and_underfur(change: impl FnOnce(&mut HairParams, &mut UnderfurParams)) -> Strands {
    let mut hair = HairParams { density: 200, ..natural().hair };
    let mut underfur = UnderfurParams { density: 600, ..natural().underfur };
    change(&mut hair, &mut underfur);
    simulate_with_underfur(&hair, &underfur, &ColorParams::default(), &VolumeParams::default()).unwrap()
}

#[test]
fn underfur_is_shorter_and_leaves_guard_hair_unchanged() {
    let both = guard_and_underfur(|_, _| {});
    both.validate().unwrap();
    assert_eq!(both.len(), 800);
    let guard = grow(|p| p.density = 200);
    assert_eq!(both.points[..guard.points.len()], guard.points);
    let tallest = |from: usize, to: usize| {
        let points = (from..to).flat_map(|i| both.points[both.range(i)].iter());
        points.map(|p| p.z).fold(0.0, f32::max)
    };
    assert_eq!(both.height, tallest(0, 200));
    assert!(tallest(200, 800) < 0.6 * both.height);
    // Underfur has its own roots: no root coincides with that of a guard hair.
    let root = |i: usize| both.points[both.range(i).start];
    assert!((200..800).all(|i| (0..200).all(|k| root(i) != root(k))));
}

#[test]
fn underfur_has_its_own_style_but_shares_wetness() {
    let straight = guard_and_underfur(|_, _| {});
    let curly = guard_and_underfur(|_, underfur| underfur.style = Some(Style::Curly));
    assert_ne!(straight.points, curly.points);
    let wet = guard_and_underfur(|hair, _| hair.style = Style::Wet);
    assert_eq!(
        wet,
        guard_and_underfur(|hair, underfur| (hair.style, underfur.style) = (Style::Wet, Some(Style::Curly)))
    );
    assert_eq!(straight, guard_and_underfur(|_, underfur| underfur.style = Some(Style::Wet)));
}

#[test]
fn dry_hair_gathers_at_its_tips_and_underfur_in_the_same_locks() {
    // Mean displacement of points caused by clumping. `at` selects the points: tips, or points near the root.
    let moved = |clump: f32, at: fn(std::ops::Range<usize>) -> usize, strands: std::ops::Range<usize>| {
        let [loose, gathered] = [0.0, clump].map(|dry_clump| guard_and_underfur(|hair, _| hair.dry_clump = dry_clump));
        let count = strands.len() as f32;
        strands.map(|i| loose.points[at(loose.range(i))].distance(gathered.points[at(gathered.range(i))])).sum::<f32>()
            / count
    };
    let tip = |range: std::ops::Range<usize>| range.end - 1;
    let near_root = |range: std::ops::Range<usize>| range.start + range.len() / 5;
    for strands in [0..200, 200..800] {
        assert!(moved(0.8, tip, strands.clone()) > 1.5 * moved(0.3, tip, strands.clone()), "{strands:?}");
        assert!(moved(0.8, tip, strands.clone()) > 8.0 * moved(0.8, near_root, strands.clone()), "{strands:?}");
    }
    let params = HairParams { density: 900, length_variation: 0.0, ..natural().hair };
    let spread = |dry_clump| spread_of_locks(&HairParams { dry_clump, ..params.clone() }, 0.4);
    assert!(spread(1.0) < 0.7 * spread(0.0), "{} {}", spread(1.0), spread(0.0));
}
