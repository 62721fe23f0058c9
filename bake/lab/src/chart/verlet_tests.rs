use super::*;

/// Returns the error of a method in all scenes together.
fn off(guide: &Guide, form: &MotionForm) -> MotionDeviation {
    let of = |scene: &Scene| MotionDeviation::of(guide, form, *scene, &guide.truth(*scene, false).places);
    Scene::ALL.iter().map(of).fold(MotionDeviation::default(), MotionDeviation::and)
}

#[test]
fn rows_differ_and_each_point_count_has_one_default() {
    let all = configurations();
    for points in POINTS {
        let of: Vec<_> = all.iter().filter(|c| c.points == points).collect();
        assert!(of.len() > 20 && of.iter().filter(|c| c.default).count() == 1);
        for (i, a) in of.iter().enumerate() {
            assert!(of[..i].iter().all(|b| (b.series, &b.label) != (a.series, &a.label) && b.form != a.form), "{a:?}");
        }
    }
    // A scene with 1080 solves has three per step.
    let of = MotionDeviation { squares: 1.0, count: 4, solved: 1080, ..MotionDeviation::default() };
    let row = cells(&all[0], &[of; 3], Some(5.0), &[]);
    assert_eq!(row.len(), COLUMNS.len());
    assert_eq!(row[3], Cell::Number(50.0));
    assert_eq!(row[10], Cell::Number(480.0));
}

/// Checks that the scenes discriminate: without motion, all methods would seem accurate; with whipping hair, none
/// would.
#[test]
fn scenes_move_hair_and_are_resolved_at_60_frames_per_second() {
    for points in POINTS {
        let guide = Guide::new(points);
        for scene in Scene::ALL {
            let truth = guide.truth(scene, false);
            assert!(
                truth.change <= TRUTH_TOLERANCE,
                "{points} points, {scene:?}: halving the steps changes the motion by {}",
                truth.change
            );
            let mut swung = 0.0f64;
            for (frame, places) in (1..).zip(&truth.places) {
                let (root, frame) = scene.root_at(time_s(frame));
                let groomed = root + frame * guide.points[points - 1].as_dvec3();
                swung = swung.max(places[points - 1].distance(groomed) / f64::from(guide.length()));
            }
            let known = MotionDeviation::of(&guide, &MotionForm::Straight, scene, &truth.places);
            println!(
                "{points} points, {scene:?}: swing {swung:.2}, error of a root known only at frames {:.1e}",
                known.rms()
            );
            assert!(swung > 0.1 && known.rms() < 1e-3, "{points} points, {scene:?}: {swung}, {known:?}");
        }
    }
}

/// Checks that all methods but the published one converge to the truth with short steps, because they solve the same
/// equations.
#[test]
fn solvers_converge_to_the_reference() {
    let guide = Guide::new(7);
    let ours = |steps_per_s: f32| MotionForm::Ours(Solver { steps_per_s, ..Solver::default() });
    let sweeps = |steps_per_s: u32| MotionForm::Sweeps { steps_per_s, sweeps: 64 };
    let yielding = |steps_per_s: u32| MotionForm::Yielding { steps_per_s };
    for [coarse, fine] in [[ours(120.0), ours(960.0)], [sweeps(120), sweeps(960)], [yielding(240), yielding(1920)]] {
        let (few, many) = (off(&guide, &coarse), off(&guide, &fine));
        println!("{coarse:?}: {:.4}, {fine:?}: {:.4}", few.rms(), many.rms());
        assert!(many.rms() < 0.005 && many.rms() < 0.3 * few.rms(), "{coarse:?}: {few:?}, {fine:?}: {many:?}");
    }
    let leader = |steps_per_s| off(&guide, &MotionForm::Leader { steps_per_s });
    assert!(leader(120).rms() < 0.1 && leader(120).stretch < 1e-5, "{:?}", leader(120));
    let printed = off(&guide, &MotionForm::Printed { sweeps: 4 });
    let now = off(&guide, &MotionForm::Ours(Solver::default()));
    assert!(printed.rms() > 3.0 * now.rms() && printed.stretch > 0.1 && now.stretch < 1e-4, "{printed:?}, {now:?}");
}
