use super::*;

/// Adds strands of two points. Their x is the index of the strand.
fn add(curves: &mut Curves, count: usize) {
    for _ in 0..count {
        let x = curves.len() as f32;
        let point = |y| CurvePoint { position_ws: Vec3::new(x, y, 0.0), ..CurvePoint::default() };
        curves.push(&[point(0.0), point(1.0)], false, Vec2::new(x, 0.5));
    }
}

fn named(groups: &[(&str, usize)]) -> Curves {
    let mut curves = Curves::default();
    for (name, count) in groups {
        curves.begin_group(name);
        add(&mut curves, *count);
    }
    curves
}

fn found(curves: &Curves) -> Vec<(&str, Range<u32>)> {
    curves.groups().iter().map(|g| (g.name.as_str(), g.strands.clone())).collect()
}

fn counted(curves: &Curves) -> Vec<f32> {
    (0..curves.len()).map(|i| curves.strand(i)[0].position_ws.x).collect()
}

#[test]
fn groups_are_consecutive_and_cover_all_strands() {
    let curves = named(&[("none", 0), ("coat", 3), ("coat", 2), ("mane", 1), ("nothing", 0), ("tail", 4), ("end", 0)]);
    assert_eq!(found(&curves), [("coat", 0..5), ("mane", 5..6), ("tail", 6..10)]);
    assert_eq!(curves.points_of(&curves.groups()[1])[1].position_ws, Vec3::new(5.0, 1.0, 0.0));
    // A name may occur again later and is then another group.
    assert_eq!(found(&named(&[("a", 1), ("b", 1), ("a", 1)])), [("a", 0..1), ("b", 1..2), ("a", 2..3)]);
    assert_eq!(found(&Curves::default()), []);
    let mut unnamed = Curves::default();
    add(&mut unnamed, 2);
    assert_eq!(found(&unnamed), [("strands", 0..2)]);
    // A strand of one point is not added, and its group is not visible.
    let mut short = named(&[("coat", 1), ("dots", 0)]);
    short.push(&[CurvePoint::default()], false, Vec2::ZERO);
    assert_eq!((found(&short), short.root_uv.len()), (vec![("coat", 0..1)], 1));
}

#[test]
fn strands_keep_their_groups_when_some_are_left_out() {
    let curves = named(&[("coat", 5), ("lash", 1), ("mane", 4)]);
    let third = curves.every_nth(3);
    assert_eq!(found(&third), [("coat", 0..2), ("mane", 2..4)]);
    assert_eq!(counted(&third), [0.0, 3.0, 6.0, 9.0]);
    assert_eq!(third.root_uv, [0.0, 3.0, 6.0, 9.0].map(|x| Vec2::new(x, 0.5)));
    assert_eq!((curves.every_nth(1) == curves, curves.every_nth(0) == curves), (true, true));
    let only = curves.only_groups(&["mane", "lash"]);
    assert_eq!(found(&only), [("lash", 0..1), ("mane", 1..5)]);
    assert_eq!(counted(&only), [5.0, 6.0, 7.0, 8.0, 9.0]);
    assert!(curves.only_groups(&["tail"]).is_empty());
}

#[test]
fn appended_curves_merge_adjacent_groups_of_equal_name() {
    let mut curves = named(&[("coat", 2)]);
    curves.append(&named(&[("coat", 1), ("mane", 2)]));
    curves.append(&Curves::default());
    curves.append(&named(&[("mane", 1), ("coat", 1)]));
    assert_eq!(found(&curves), [("coat", 0..3), ("mane", 3..6), ("coat", 6..7)]);
    assert_eq!((curves.len(), curves.root_uv.len(), curves.offsets.len()), (7, 7, 8));
}
