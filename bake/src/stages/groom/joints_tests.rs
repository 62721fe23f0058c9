use super::*;
use crate::recipe::Recipe;
use crate::stages::fixtures::node;
use pelage_formats::Joint;

/// Builds a rig of a root, which is not a joint, and four joints: neck (0), head (1), left ear (2) and right ear (3).
fn rig() -> Animation {
    let nodes = vec![
        node("Armature", None),
        node("Neck", Some(0)),
        node("Head", Some(1)),
        node("Ear.L", Some(2)),
        node("Ear.R", Some(2)),
    ];
    let joints = (1..5).map(|node| Joint { node, inverse_bind: [0.0; 16] }).collect();
    Animation { nodes, joints, ..Animation::default() }
}

fn values(tables: &str) -> (JointValues, Vec<String>) {
    let groom = Recipe::parse("r.toml", tables).unwrap().groom;
    let mut warnings = Vec::new();
    (JointValues::new(&groom.joint, Some(&rig()), &mut warnings), warnings)
}

/// Creates a vertex that follows two joints.
fn follows(a: (u16, f32), b: (u16, f32)) -> SkinVertex {
    SkinVertex { joints: [a.0, b.0, 0, 0], weights: [a.1, b.1, 0.0, 0.0] }
}

/// Returns the hair length at four vertices, each of which follows one joint. Without tables, it is 1.
fn lengths(tables: &str) -> [f32; 4] {
    let (values, warnings) = values(tables);
    assert_eq!(warnings, Vec::<String>::new(), "{tables}");
    [0, 1, 2, 3].map(|joint| values.blend(Some(&follows((joint, 1.0), (0, 0.0))), |t| t.length, 1.0))
}

#[test]
fn joint_tables_apply_to_descendants_and_nearer_tables_win() {
    let head = "[[groom.joint]]\nname = \"head*\"\nlength = 0.25\n";
    assert_eq!(lengths(head), [1.0, 0.25, 0.25, 0.25]);
    // Only for the same joint does the order of tables matter.
    let left = "[[groom.joint]]\nname = \"ear.l\"\nlength = 0.5\n";
    assert_eq!(lengths(&format!("{left}{head}")), [1.0, 0.25, 0.5, 0.25]);
    let ears = "[[groom.joint]]\nname = \"ear*\"\nlength = 0.75\n";
    assert_eq!(lengths(&format!("{left}{ears}{head}")), [1.0, 0.25, 0.75, 0.75]);
    assert_eq!(lengths(&format!("{ears}{left}{head}")), [1.0, 0.25, 0.5, 0.75]);
    // Each key is inherited separately: a table for a nearer joint without a length keeps the length of the ancestor.
    let lean = "[[groom.joint]]\nname = \"ear*\"\nlean = 1\n";
    assert_eq!(lengths(&format!("{head}{lean}")), [1.0, 0.25, 0.25, 0.25]);
    // A table for a node that is not a joint applies to its descendants.
    assert_eq!(lengths("[[groom.joint]]\nname = \"armature\"\nlength = 0.5\n"), [0.5; 4]);
}

#[test]
fn joint_values_are_blended_by_skin_weights() {
    let (values, _) = values("[[groom.joint]]\nname = \"Head\"\nlength = 0.5\nwetness = 1\n");
    let mix = |a, b, elsewhere| values.blend(Some(&follows(a, b)), |t| t.length, elsewhere);
    assert_eq!(mix((0, 0.75), (1, 0.25), 1.0), 0.875);
    assert_eq!(mix((1, 0.75), (2, 0.25), 1.0), 0.5, "the ear says what the head says");
    let third = 1.0 / 3.0;
    assert_eq!(mix((0, 1.0), (0, 0.0), third), third, "untouched to the last bit");
    assert_eq!(values.blend(None, |t| t.length, third), third, "a vertex without joints");
    assert_eq!(mix((77, 1.0), (0, 0.0), third), third, "a joint that the skeleton has not got");
    assert!(values.has_key(|t| t.wetness) && !values.has_key(|t| t.density));
}

#[test]
fn rounded_weights_do_not_make_a_length_negative() {
    let (values, _) = values("[[groom.joint]]\nname = \"Head\"\nlength = 0\n");
    let mut below = 0;
    for i in 1..100u16 {
        let first = f32::from(i) / 100.0;
        // Importers normalise weights, so their sum may be a last bit above 1.
        let weights = [first, 0.3 * (1.0 - first), 0.7 * (1.0 - first), 1.2e-7];
        let vertex = SkinVertex { joints: [1, 2, 3, 1], weights };
        below += usize::from(weights.iter().fold(1.0, |left, weight| left - weight) < 0.0);
        assert!(values.blend(Some(&vertex), |t| t.length, 1.0) >= 0.0, "{weights:?}");
    }
    assert!(below > 10, "{below} vertices would have had a negative length");
}

#[test]
fn tables_without_effect_are_reported() {
    let tables = "[[groom.joint]]\nname = \"trunk\"\nlength = 0.5\n[[groom.joint]]\nname = \"NECK\"\nlength = 0.5\n";
    let (_, warnings) = values(tables);
    assert!(
        matches!(
            &warnings[..],
            [one] if one.contains("\"trunk\"") && one.contains("Ear.L") && !one.contains("Armature")
        ),
        "{warnings:?}"
    );
    let groom = Recipe::parse("r.toml", tables).unwrap().groom;
    let mut warnings = Vec::new();
    let values = JointValues::new(&groom.joint, None, &mut warnings);
    assert!(!values.has_key(|t| t.length));
    assert!(matches!(&warnings[..], [one] if one.contains("no skeleton")), "{warnings:?}");
    let mut warnings = Vec::new();
    JointValues::new(&[], None, &mut warnings);
    assert_eq!(warnings, Vec::<String>::new());
}
