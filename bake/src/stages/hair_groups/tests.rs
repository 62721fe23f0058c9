use super::*;
use crate::stages::fixtures;
use crate::stages::groom::MapImages;
use pelage_formats::meaning::hair_groups::GrownGroup;
use pelage_import::mesh::{Material, Mesh, MeshPart, NamedPosition, RestPose};

/// Makes a ball of radius 0.1 m around the origin. Its material is "Scalp" above y = 0.03 and "Skin" below.
fn ball() -> (Mesh, RestPose, Vec<Material>) {
    let (rings, around) = (24u32, 48u32);
    let mut mesh = fixtures::ball(rings, around);
    mesh.positions.iter_mut().for_each(|p| *p *= 0.1);
    mesh.colors = mesh.normals.iter().map(|n| [if n.x < 0.0 { 0 } else { 255 }; 4]).collect();
    let border = 9;
    let scalp = (border * around * 2) as usize;
    let part = |material, first, count| MeshPart { has_uvs: true, ..fixtures::part(material, first, count) };
    mesh.parts = vec![part(0, 0, scalp), part(1, scalp, mesh.triangles.len() - scalp)];
    let rest = RestPose::of(&mesh, None);
    let materials = ["Scalp", "Skin"].map(|name| Material { name: name.into(), ..Material::default() });
    (mesh, rest, materials.to_vec())
}

fn grown(recipe: &str, files: &MapImages) -> Result<GuidedHair, BakeError> {
    let recipe = crate::recipe::Recipe::parse("recipe", recipe)?;
    let (mesh, rest, materials) = ball();
    let nodes = [("root", Vec3::ZERO), ("ear.L", Vec3::new(0.08, 0.08, 0.0)), ("ear.L", Vec3::X)];
    let nodes = nodes.map(|(name, position_ws)| NamedPosition { name: name.into(), position_ws });
    let (materials, nodes) = (&materials, &nodes);
    let ground = GroomTarget { file: "ball.glb", mesh: &mesh, rest: &rest, radius_m: 0.1, materials, nodes, files };
    groups(&recipe.strands, &ground)
}

/// Returns the groups that a recipe grows on the ball, and the warnings.
fn made(recipe: &str, files: &MapImages) -> Result<(Vec<HairGroup>, Vec<String>), BakeError> {
    grown(recipe, files).map(|hair| (hair.groups, hair.warnings))
}

fn one(keys: &str) -> Result<HairGroup, BakeError> {
    let group = format!("[[strands.group]]\nname = \"hair\"\nmaterial = \"Scalp\"\n{keys}");
    made(&group, &MapImages::default()).map(|(mut groups, _)| groups.remove(0))
}

/// Returns the points of all hairs of a group on the ball at rest.
fn hairs(group: &HairGroup) -> Vec<Vec<Vec3>> {
    let (mesh, rest, _) = ball();
    let planted = GrownGroup::new(group, &rest.positions, &mesh.triangles, u32::MAX);
    let corners = |t: u32| mesh.triangles[t as usize].map(|v| rest.positions[v as usize]);
    let guides = planted.posed_guides(corners);
    planted.hairs.iter().map(|hair| hair.points(corners(hair.root.triangle), &guides).collect()).collect()
}

#[test]
fn hair_does_not_penetrate_the_body() {
    for style in ["straight", "curly", "messy", "wet", "lying"] {
        let group =
            one(&format!("length_m = 0.25\nhairs = 500\nguides = 200\nstyle = \"{style}\"\nstray = 0\nclump = 0"))
                .unwrap();
        let hairs = hairs(&group);
        assert_eq!((hairs.len(), group.guide_roots.len()), (500, 200));
        let all = hairs.iter().flatten();
        let inside = all.clone().filter(|p| p.length() < 0.094).count();
        assert!(inside * 50 < all.clone().count(), "{style}: {inside} of {} points in the ball", all.count());
        let lower = hairs.iter().filter(|hair| hair.last().unwrap().y < hair[0].y - 0.05).count();
        assert!(lower > 450, "{style}: {lower} of 500 hang down");
        let mean = hairs.iter().map(|h| h.windows(2).map(|e| e[0].distance(e[1])).sum::<f32>()).sum::<f32>() / 500.0;
        assert!((0.15..0.35).contains(&mean), "{style}: {mean} m long");
    }
}

#[test]
fn hair_is_combed_to_both_sides_of_a_parting() {
    let group =
        one("length_m = 0.1\nhairs = 400\nparting_m = 0.02\nlength_variation = 0\nstray = 0\nclump = 0").unwrap();
    for hair in hairs(&group).iter().filter(|hair| hair[0].y > 0.06 && (hair[0].x - 0.02).abs() > 0.004) {
        let side = (hair[0].x - 0.02).signum();
        assert!(side * (hair.last().unwrap().x - hair[0].x) > 0.0, "from {} to {}", hair[0], hair.last().unwrap());
    }
}

#[test]
fn a_mask_thins_the_scalp() {
    // Vertex colours are white on the right half only.
    let group = one("mask = \"vertex\"\nhairs = 300\nlength_m = 0.01").unwrap();
    assert!(hairs(&group).iter().all(|hair| hair[0].x > -0.03));
    assert!(
        group.scalp.iter().any(|(_, share)| *share < 40_000) && group.scalp.iter().any(|(_, share)| *share == 65_535)
    );
}

#[test]
fn freedom_map_sets_guide_mobility() {
    let group = |freedom: &str| format!("[[strands.group]]\nname = \"hair\"\nmaterial = \"Scalp\"\n{freedom}\n");
    let tuft = "[[strands.tuft]]\nname = \"brow\"\nat = [0, 0.1, 0]\n";
    let recipe = [&group("freedom = \"vertex#g\""), &group(""), &group("freedom = 0.5"), tuft].concat();
    let hair = grown(&recipe, &MapImages::default()).unwrap();
    assert_eq!((hair.freedom[1].len(), hair.freedom[3].len(), hair.freedom.len()), (0, 0, 4));
    assert!(
        hair.freedom[2].len() == hair.groups[2].guide_roots.len()
            && hair.freedom[2].iter().all(|byte| (127..=128).contains(byte))
    );
    // Vertex colours are white on the right half and black on the left.
    let (mesh, rest, _) = ball();
    let corners = |t: u32| mesh.triangles[t as usize].map(|v| rest.positions[v as usize]);
    for (root, freedom) in hair.groups[0].roots().zip(&hair.freedom[0]) {
        let x = root.position(corners(root.triangle)).x;
        assert!(x.abs() < 0.02 || *freedom == if x < 0.0 { 0 } else { 255 }, "{freedom} at {x}");
    }
    let count = |value| hair.freedom[0].iter().filter(|byte| **byte == value).count();
    assert!(count(0) > 100 && count(255) > 100);
}

#[test]
fn imported_guides_are_attached_to_the_scalp() {
    let strand = |x: f32, lift: f32| {
        let root = Vec3::new(x, (0.01 - x * x).sqrt(), 0.0) * (1.0 + lift);
        [root, root + Vec3::Y * 0.05, root + Vec3::new(0.02, 0.08, 0.0)]
    };
    let file = |strands: &[[Vec3; 3]]| {
        let text: String = strands
            .iter()
            .map(|s| s.map(|p| format!("{} {} {}\n", 100.0 * p.x, 100.0 * p.y, 100.0 * p.z)).concat() + "\n")
            .collect();
        let guides = pelage_import::guides::read::GuideFormat::Text.read("guides.txt", text.as_bytes()).unwrap();
        let mut files = MapImages::default();
        files.strands.insert("guides.txt".into(), guides);
        files
    };
    let recipe =
        |keys: &str| format!("[[strands.group]]\nname = \"hair\"\nmaterial = \"Scalp\"\nfile = \"guides.txt\"\n{keys}");
    // In centimetres: one strand touches the surface, one begins a little above it, and one is far away.
    let files = file(&[strand(0.01, 0.0), strand(0.03, 0.05), strand(0.02, 3.0)]);
    let (groups, warnings) = made(
        &recipe("scale_m = 0.01\nhairs = 0\npoints = 9\nguide_points = 9\nlength_variation = 0\nstray = 0"),
        &files,
    )
    .unwrap();
    assert_eq!((groups[0].guide_roots.len(), warnings.len()), (2, 1));
    assert!(warnings[0].contains("1 of 3 guides have roots farther than 0.010 m"), "{}", warnings[0]);
    for (hair, strand) in hairs(&groups[0]).iter().zip([strand(0.01, 0.0), strand(0.03, 0.05)]) {
        assert!((hair[0].length() - 0.1).abs() < 5e-4, "roots on the ball: {}", hair[0]);
        let tip = *hair.last().unwrap();
        assert!(tip.distance(strand[2]) < 0.001, "{tip}, expected {}", strand[2]);
    }
    // Hair grows only near the guides.
    let few = file(&[strand(0.01, 0.0), strand(0.012, 0.0), strand(0.014, 0.0)]);
    let (many, _) = made(&recipe("scale_m = 0.01\nhairs = 200\nstray = 0\nclump = 0"), &few).unwrap();
    assert!(hairs(&many[0]).iter().all(|hair| hair[0].distance(Vec3::new(0.012, 0.1, 0.0)) < 0.035));
    // With a larger tolerance, all strands are moved to the scalp.
    let (groups, _) = made(&recipe("scale_m = 0.01\nhairs = 0\nloose_m = 0.5"), &files).unwrap();
    assert_eq!(groups[0].guide_roots.len(), 3);
    let error = made(&recipe("scale_m = 1000000\nloose_m = 1000000"), &file(&[[Vec3::ZERO, Vec3::X, 9.0 * Vec3::Y]]))
        .unwrap_err();
    assert!(error.to_string().contains("farther than 10 m from their roots, expected a smaller scale_m"), "{error}");
    // Strands that begin at their tips are turned.
    let turned = |loose: &str| {
        let tips_first = [0.01, 0.03, 0.05].map(|x| {
            let [root, middle, tip] = strand(x, 0.0);
            [tip, middle, root]
        });
        let keys = format!("scale_m = 0.01\nhairs = 0\npoints = 9\nguide_points = 9\nlength_variation = 0\n{loose}");
        let (groups, warnings) = made(&recipe(&keys), &file(&tips_first)).unwrap();
        assert!(warnings.len() == 1 && warnings[0].contains("begin at their tips"), "{loose}: {warnings:?}");
        for (hair, x) in hairs(&groups[0]).iter().zip([0.01, 0.03, 0.05]) {
            assert!((hair[0].length() - 0.1).abs() < 5e-4, "{loose}: roots on the ball: {}", hair[0]);
            assert!(hair.last().unwrap().distance(strand(x, 0.0)[2]) < 0.02, "{loose}: {}", hair.last().unwrap());
        }
    };
    turned("");
    turned("loose_m = 0.5");
    // The file is read in metres by mistake: all strands are far away, and the error gives their extent.
    let error = made(&recipe(""), &files).unwrap_err().to_string();
    assert!(error.contains("none of the 3 strands") && error.contains("scale_m"), "{error}");
}

#[test]
fn tufts_are_placed_at_the_nearest_surface_point() {
    let recipe = "[[strands.tuft]]\nname = \"whiskers\"\nat = [0.05, 0.0, 0.2]\nmirrored = true\n\
                  hairs = 8\nlength_m = 0.06\nspread_m = 0.01";
    let (groups, _) = made(recipe, &MapImages::default()).unwrap();
    assert_eq!((groups[0].hairs, groups[0].guide_roots.len(), groups[0].hair_count()), (0, 16, 16));
    let hairs = hairs(&groups[0]);
    for (left, right) in hairs[..8].iter().zip(&hairs[8..]) {
        assert!((left[0] - Vec3::new(0.0243, 0.0, 0.097)).length() < 0.013, "{}", left[0]);
        for (p, q) in left.iter().zip(right) {
            assert!((*p * Vec3::new(-1.0, 1.0, 1.0)).distance(*q) < 3e-3, "{p} and {q}");
        }
        assert!(left.last().unwrap().z > 0.11);
    }
}

#[test]
fn tufts_are_placed_at_joints_and_on_materials() {
    let tuft = |keys: &str| {
        let recipe = format!("[[strands.tuft]]\nname = \"tuft\"\nhairs = 8\nspread_m = 0.01\n{keys}");
        let (groups, warnings) = made(&recipe, &MapImages::default()).unwrap();
        let hairs = hairs(&groups[0]);
        let sum = hairs.iter().map(|hair| hair[0]).sum::<Vec3>();
        (sum / hairs.len() as f32, hairs, warnings)
    };
    let (middle, _, warnings) = tuft("joint = \"ear.L\"");
    assert!(middle.distance(Vec3::new(0.0707, 0.0707, 0.0)) < 0.005, "{middle}");
    assert!(warnings.len() == 1 && warnings[0].contains("2 nodes are named \"ear.L\""), "{warnings:?}");
    // The tuft is offset from the joint, and mirrored.
    let (middle, hairs, _) = tuft("joint = \"root\"\nat = [0.05, 0.0, 0.12]\nmirrored = true");
    assert!((hairs.len(), middle.x.abs() < 1e-3, middle.z > 0.08) == (16, true, true), "{middle}");
    // The nearest surface has another material, so the tuft is placed on the border of the scalp above it.
    let (middle, hairs, _) = tuft("at = [0.0, 0.0, 0.12]\nmaterial = \"Sc*p\"");
    assert!(middle.z > 0.05 && hairs.iter().all(|hair| hair[0].y > 0.03), "{middle}");
}

#[test]
fn invalid_hair_groups_are_errors_with_reasons() {
    let fails = |recipe: &str, expected: &[&str]| {
        let error = made(recipe, &MapImages::default()).unwrap_err().to_string();
        assert!(expected.iter().all(|e| error.contains(e)), "{error}, expected {expected:?}");
    };
    let group = |keys: &str| format!("[[strands.group]]\nname = \"hair\"\n{keys}");
    let place = "strands.group, table 0 \"hair\"";
    fails(&group("material = \"Mane\""), &["ball.glb", place, "\"Mane\"", "\"Scalp\", \"Skin\""]);
    fails(&group("mask = 0.0"), &[place, "the mask excludes all"]);
    fails(&group("fall = [0, 0, 0]"), &[place, "fall is [0, 0, 0]"]);
    let tuft = |keys: &str| format!("[[strands.tuft]]\nname = \"brow\"\n{keys}");
    fails(&tuft(""), &["strands.tuft, table 0 \"brow\"", "at and joint are missing"]);
    fails(
        &tuft("joint = \"ear.R\""),
        &["no joint or node is named \"ear.R\", expected one of \"ear.L\", ", "\"root\""],
    );
    fails(&tuft("at = [0, 0, 0]\nmaterial = \"Brow\""), &["\"Brow\"", "\"Scalp\", \"Skin\""]);
    let far = "[[strands.tuft]]\nname = \"brow\"\nat = [9, 9, 9]";
    fails(far, &["no skin is near"]);
    for (keys, expected) in [
        ("hairs = -1", "hairs"),
        ("points = 1", "points"),
        ("clump = 2.0", "clump"),
        ("lenght_m = 0.1", "length_m"),
        ("file = \"/etc/passwd\"", "file"),
        ("root_color = \"red\"", "root_color"),
    ] {
        fails(&group(keys), &["recipe", expected]);
    }
}
