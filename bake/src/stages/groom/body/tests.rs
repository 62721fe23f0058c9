use super::words::{region, words};
use super::*;
use crate::stages::fixtures::{node, on_threads, part};
use crate::stages::groom::bounds;
use pelage_formats::{Animation, Joint, SkinVertex};
use pelage_import::mesh::{Mesh, RestPose};

mod combing;

/// Builds a closed surface of revolution about z through rings (z, radius). Each end is closed by a point.
fn surface_of_revolution(rings: &[(f32, f32)]) -> Mesh {
    const AROUND: u32 = 24;
    let mut mesh = Mesh::default();
    for (z, radius) in rings {
        for i in 0..AROUND {
            let (sin, cos) = libm::sincosf(std::f32::consts::TAU * i as f32 / AROUND as f32);
            mesh.positions.push(Vec3::new(radius * cos, radius * sin, *z));
        }
    }
    let last = rings.len() as u32 - 1;
    for (ring, i) in (0..last).flat_map(|ring| (0..AROUND).map(move |i| (ring, i))) {
        let [a, b] = [i, (i + 1) % AROUND].map(|i| ring * AROUND + i);
        mesh.triangles.extend([[a, b, b + AROUND], [a, b + AROUND, a + AROUND]]);
    }
    for (ring, z) in [(0, rings[0].0), (last, rings[last as usize].0)] {
        mesh.positions.push(Vec3::new(0.0, 0.0, z));
        let tip = mesh.positions.len() as u32 - 1;
        for i in 0..AROUND {
            let [a, b] = [i, (i + 1) % AROUND].map(|i| ring * AROUND + i);
            mesh.triangles.push(if ring == 0 { [b, a, tip] } else { [a, b, tip] });
        }
    }
    mesh.parts = vec![part(0, 0, mesh.triangles.len())];
    mesh.normals = mesh.positions.iter().map(|p| Vec3::new(p.x, p.y, 0.0).normalize_or(Vec3::Z)).collect();
    mesh
}

/// Builds a barrel of radius 0.3 from z = 0 to 1, followed by a rod of radius 0.03 up to 2.
fn barrel_with_rod() -> Mesh {
    let barrel = (0..=10).map(|i| (0.1 * i as f32, 0.3));
    let rod = (1..=20).map(|i| (1.0 + 0.05 * i as f32, 0.03));
    surface_of_revolution(&barrel.chain(rod).collect::<Vec<_>>())
}

fn ball() -> Mesh {
    let ring = |i: i32| {
        let (sin, cos) = libm::sincosf(std::f32::consts::PI * i as f32 / 24.0);
        (-cos, sin)
    };
    surface_of_revolution(&(1..24).map(ring).collect::<Vec<_>>())
}

/// Grooms a mesh whose second material is bare.
fn groom(mesh: &Mesh, animation: Option<&Animation>, share: f32) -> Option<BodyGroom> {
    let rest = RestPose { positions: mesh.positions.clone(), normals: mesh.normals.clone() };
    let bounds = bounds(&rest);
    let body = Body { mesh, rest: &rest, animation, furred: &[true, false], bounds: &bounds };
    BodyGroom::of(&body, share, 0.05 * bounds.radius)
}

/// Returns the mean of a value over the vertices between two z coordinates.
fn mean_between(mesh: &Mesh, values: &[f32], low: f32, high: f32) -> f32 {
    let there: Vec<f32> =
        mesh.positions.iter().zip(values).filter(|(p, _)| (low..=high).contains(&p.z)).map(|(_, v)| *v).collect();
    assert!(!there.is_empty());
    there.iter().sum::<f32>() / there.len() as f32
}

/// Builds a rig of the given nodes, each with its parent. All nodes are joints.
fn rig(nodes: &[(&str, Option<u32>)]) -> Animation {
    Animation {
        nodes: nodes.iter().map(|(name, parent)| node(name, *parent)).collect(),
        joints: (0..nodes.len() as u32).map(|node| Joint { node, inverse_bind: [0.0; 16] }).collect(),
        ..Animation::default()
    }
}

fn regions_of(nodes: &[(&str, Option<u32>)]) -> Vec<Region> {
    regions::of_nodes(&rig(nodes))
}

#[test]
fn bone_names_are_split_into_words() {
    for (name, expected) in [
        ("mixamorig:LeftUpLeg", "mixamorig left up leg"),
        ("IKFrontLeg.L", "ik front leg l"),
        ("DEF-upper_arm.L.001", "def upper arm l"),
        ("Bip01 L Calf", "bip l calf"),
        ("Épaule_gauche", "epaule gauche"),
        ("Vorderfuß02", "vorderfuss"),
        ("ＬｅｆｔＡｒｍ", "left arm"),
        ("", ""),
    ] {
        assert_eq!(words(name).join(" "), expected, "{name}");
    }
}

#[test]
fn names_of_many_rigs_and_languages_are_understood() {
    use Region::*;
    for (name, expected) in [
        ("Head", Head),
        ("Bip01 Head", Head),
        ("kopf", Head),
        ("Tête", Head),
        ("cabeza", Head),
        ("頭", Head),
        ("头部", Head),
        ("Ear1.L", Ear),
        ("Ohr_links", Ear),
        ("oreille.G", Ear),
        ("左耳", Ear),
        ("Jaw", Muzzle),
        ("Schnauze", Muzzle),
        ("hocico", Muzzle),
        ("museau", Muzzle),
        ("b_Tail01_012", Tail),
        ("Schwanz", Tail),
        ("尻尾", Tail),
        ("wěiba", Tail),
        ("weiba_01", Tail),
        ("Bip01 Ponytail1", Mane),
        ("Neck2", Neck),
        ("cuello", Neck),
        ("首", Neck),
        ("脖子", Neck),
        ("thigh_l", UpperLeg),
        ("mixamorig:LeftUpLeg", UpperLeg),
        ("BackUpperLeg.R", UpperLeg),
        ("Oberschenkel", UpperLeg),
        ("大腿", UpperLeg),
        ("Bip01 L Calf", LowerLeg),
        ("DEF-shin.L", LowerLeg),
        ("mixamorig:LeftForeArm", LowerLeg),
        ("FrontLowerLeg.L", LowerLeg),
        ("左ひざ", LowerLeg),
        ("xiaotui", LowerLeg),
        ("左手首", Foot),
        ("左足首", Foot),
        ("Pfote", Foot),
        ("LeftHandIndex1", Foot),
        ("Hoof", Foot),
        ("fetlock.R", Foot),
        ("IKFrontLeg.L", Foot),
        ("BackLeg.L", Limb),
        ("左腕", Limb),
        ("手臂", Limb),
        ("clavicle_r", Shoulder),
        ("FrontShoulder.L", Shoulder),
        ("Chest", Chest),
        ("spine_03", Torso),
        ("pelvis", Torso),
        ("Becken", Torso),
        ("骨盆", Torso),
    ] {
        let found = region(name);
        // The accent of `ě` is the only one in this name that is not removed, so the name has no known word.
        let expected = if name == "wěiba" { None } else { Some(expected) };
        assert_eq!(found, expected, "{name}");
    }
    for name in ["", "Armature", "Bone.003", "PoleTarget.L", "searing", "legend", "Xtra01", "main"] {
        assert_eq!(region(name), None, "{name}");
    }
}

#[test]
fn unnamed_bones_inherit_the_region_of_their_parent() {
    use Region::*;
    let found = regions_of(&[
        ("Armature", None),
        ("Hips", Some(0)),
        ("LeftUpLeg", Some(1)),
        ("LeftLeg", Some(2)),
        ("LeftFoot", Some(3)),
        ("Bone.007", Some(4)),
        ("leg01", Some(1)),
        ("leg02", Some(6)),
        ("BackShoulder.L", Some(1)),
        ("BackLeg.L", Some(8)),
        ("IKBackLeg.L", Some(0)),
        ("FFB.L", Some(10)),
    ]);
    let expected = [Unknown, Torso, UpperLeg, LowerLeg, Foot, Foot, UpperLeg, LowerLeg, Shoulder, UpperLeg, Foot, Foot];
    assert_eq!(found, expected);
}

#[test]
fn numbered_spine_ends_in_neck_and_head() {
    use Region::*;
    let names: Vec<String> = (0..7).map(|i| format!("DEF-spine.00{i}")).collect();
    let mut nodes: Vec<(&str, Option<u32>)> =
        names.iter().zip(0..).map(|(name, i): (_, u32)| (name.as_str(), i.checked_sub(1))).collect();
    nodes.push(("DEF-temple.L", Some(6)));
    assert_eq!(regions_of(&nodes), [Torso, Torso, Torso, Torso, Neck, Neck, Head, Head]);
    // If a joint is named a head, the numbers are ignored.
    nodes.push(("Head", Some(6)));
    assert_eq!(regions_of(&nodes)[..7], [Torso; 7]);
}

#[test]
fn thickness_is_the_distance_through_the_body() {
    let mesh = barrel_with_rod();
    let rest = RestPose { positions: mesh.positions.clone(), normals: mesh.normals.clone() };
    let skin = WeldedMesh::new(&mesh, &rest, Vec3::ZERO, 2.0);
    let thickness = thickness::thickness(&skin);
    let of = |z: f32| {
        let place = skin.positions.iter().position(|p| (p.z * 2.0 - z).abs() < 1e-4).unwrap();
        thickness[place].unwrap() * 2.0
    };
    assert!((0.5..0.8).contains(&of(0.5)), "barrel of 0.6: {}", of(0.5));
    assert!((0.05..0.08).contains(&of(1.5)), "rod of 0.06: {}", of(1.5));
    // A sheet has no far side, so its thickness is unknown.
    let sheet = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        normals: vec![Vec3::Z; 3],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let rest = RestPose { positions: sheet.positions.clone(), normals: sheet.normals.clone() };
    assert_eq!(thickness::thickness(&WeldedMesh::new(&sheet, &rest, Vec3::ZERO, 1.0)), [None; 3]);
}

#[test]
fn vertices_are_welded_and_distances_are_geodesic() {
    let mesh = barrel_with_rod();
    // Mesh with the same triangles, which share no vertices.
    let torn = Mesh {
        positions: mesh.triangles.iter().flatten().map(|v| mesh.positions[*v as usize]).collect(),
        triangles: (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        ..Mesh::default()
    };
    let skins = [&mesh, &torn].map(|mesh| {
        let rest = RestPose { positions: mesh.positions.clone(), normals: Vec::new() };
        WeldedMesh::new(mesh, &rest, Vec3::ZERO, 1.0)
    });
    assert_eq!(skins[0].positions, skins[1].positions);
    assert!(skins[1].pieces.iter().all(|piece| *piece == 0));
    let [whole, torn] = skins.map(|skin| {
        let seed = skin.positions.iter().position(|p| p.z == 2.0).unwrap() as u32;
        let distances = skin.distances([(seed, 0.25)].into_iter(), 1.0);
        let at = |z: f32| skin.positions.iter().zip(&distances).find(|(p, _)| (p.z - z).abs() < 1e-4).map(|(_, d)| *d);
        [at(1.5).unwrap(), at(0.5).unwrap()]
    });
    assert_eq!(whole, torn);
    assert!((whole[0] - 0.75).abs() < 0.1, "half a metre and the quarter it begins with: {}", whole[0]);
    assert_eq!(whole[1], f32::INFINITY, "beyond its reach");
}

#[test]
fn smoothing_stays_within_bounds_and_keeps_the_sum() {
    let mesh = surface_of_revolution(&(0..=60).map(|i| (i as f32 / 60.0, 0.1)).collect::<Vec<_>>());
    let rest = RestPose { positions: mesh.positions.clone(), normals: Vec::new() };
    let skin = WeldedMesh::new(&mesh, &rest, Vec3::ZERO, 1.0);
    let step: Vec<f32> = skin.positions.iter().map(|p| if p.z < 0.5 { 0.0 } else { 1.0 }).collect();
    let spread = skin.spread(&step, 0.05);
    let sum = |values: &[f32]| values.iter().zip(&skin.areas).map(|(v, a)| f64::from(v * a)).sum::<f64>();
    assert!((sum(&spread) / sum(&step) - 1.0).abs() < 1e-3);
    let at = |z: f32| {
        let near = |p: &Vec3| (p.z - z).abs() < 1e-3 && p.truncate().length() > 0.05;
        spread[skin.positions.iter().position(near).unwrap()]
    };
    assert!((at(0.5) - 0.5).abs() < 0.2 && at(0.25) < 0.01 && at(0.75) > 0.99, "{} {}", at(0.25), at(0.75));
    // There are no jumps: neighbouring rings differ little.
    let jump = (1..60).map(|i| (at(i as f32 / 60.0) - at((i - 1) as f32 / 60.0)).abs()).fold(0.0, f32::max);
    assert!(jump < 0.25, "{jump}");
}

#[test]
fn thin_parts_have_short_dense_hair_that_lies_flat() {
    let mesh = barrel_with_rod();
    let by_body = groom(&mesh, None, 1.0).unwrap();
    let on = |values: &[f32]| [mean_between(&mesh, values, 0.3, 0.7), mean_between(&mesh, values, 1.5, 1.9)];
    let [thick, thin] = on(&by_body.length);
    assert!(thick > 0.9 && thin < 0.3, "{thick} {thin}");
    assert_eq!(by_body.length.iter().copied().fold(0.0, f32::max), 1.0, "the longest hair keeps its length");
    let [thick, thin] = on(&by_body.lean);
    assert!(thick < 0.05 && thin > 0.4, "{thick} {thin}");
    let [thick, thin] = on(by_body.density.as_ref().unwrap());
    assert!((thick - 1.0).abs() < 0.05 && thin > 1.5, "{thick} {thin}");
    // Hair on the belly is longer than on the back.
    let of_barrel = |sign: f32| {
        let here = |p: &Vec3| p.y * sign > 0.25 && (0.3..0.7).contains(&p.z);
        mesh.positions.iter().zip(&by_body.length).find(|(p, _)| here(p)).map(|(_, v)| *v).unwrap()
    };
    assert!(of_barrel(-1.0) > 1.05 * of_barrel(1.0));
    let half = groom(&mesh, None, 0.5).unwrap();
    let [_, half_thin] = on(&half.length);
    let [_, thin] = on(&by_body.length);
    assert!((half_thin - 0.5 * (1.0 + thin)).abs() < 1e-3, "{half_thin} {thin}");

    let said = by_body.decision(1.0, 0.02);
    assert_eq!(said.line, "groom.by_body = 1");
    assert!(said.chosen.starts_with("at most 20 mm: thick parts 1") && said.chosen.contains("thin parts"), "{said:?}");
}

#[test]
fn uniform_bodies_get_no_groom() {
    assert_eq!(groom(&ball(), None, 1.0), None);
    assert_eq!(
        groom(&surface_of_revolution(&(0..=40).map(|i| (0.05 * i as f32, 0.2)).collect::<Vec<_>>()), None, 1.0),
        None
    );
    let mut bare = barrel_with_rod();
    assert_eq!(groom(&bare, None, 0.0), None, "not asked for");
    bare.parts[0].material = 1;
    assert_eq!(groom(&bare, None, 1.0), None, "no hair anywhere");
    assert_eq!(groom(&Mesh::default(), None, 1.0), None);
}

/// Builds the barrel with its rod, and a joint for the end of the barrel and one for the rod, with the given names.
fn rigged(end: &str, rod: &str) -> (Mesh, Animation) {
    let mut mesh = barrel_with_rod();
    let follows = |joint| SkinVertex { joints: [joint, 0, 0, 0], weights: [1.0, 0.0, 0.0, 0.0] };
    let joint = |p: &Vec3| if p.z < 0.15 { 1 } else { 2 * u16::from(p.z > 1.0) };
    mesh.skin = mesh.positions.iter().map(|p| follows(joint(p))).collect();
    (mesh, rig(&[("Spine", None), (end, Some(0)), (rod, Some(0))]))
}

#[test]
fn names_win_over_thickness() {
    let of = |(end, rod): (&str, &str)| {
        let (mesh, rig) = rigged(end, rod);
        let by_body = groom(&mesh, Some(&rig), 1.0).unwrap();
        (mean_between(&mesh, &by_body.length, 1.5, 1.9), by_body.decision(1.0, 0.1).chosen)
    };
    let [(tail, said), (paw, _), (bone, unnamed)] = [("Shin", "Tail"), ("Neck", "Paw.L"), ("Spine2", "Stick")].map(of);
    assert!(tail > 0.95, "a tail is thin and long-haired: {tail}");
    assert!(said.contains("tail 1") && said.contains("back ") && said.contains("belly "), "{said}");
    assert!(paw < 0.25, "{paw}");
    assert!(bone < 0.3 && unnamed.contains("thin parts"), "where no name tells, thickness does: {bone} {unnamed}");
}

#[test]
fn muzzles_are_split_from_forward_facing_heads() {
    let mut mesh = surface_of_revolution(&(0..=20).map(|i| (0.1 * i as f32, 0.3)).collect::<Vec<_>>());
    let follows = |joint| SkinVertex { joints: [joint, 0, 0, 0], weights: [1.0, 0.0, 0.0, 0.0] };
    mesh.skin = mesh.positions.iter().map(|p| follows(u16::from(p.z > 1.0))).collect();
    let mut rig = rig(&[("Spine", None), ("Head", Some(0))]);
    rig.nodes[1].translation = [0.0, 0.0, 1.0];
    let forward = groom(&mesh, Some(&rig), 1.0).unwrap();
    let ends = [mean_between(&mesh, &forward.length, 1.2, 1.4), mean_between(&mesh, &forward.length, 1.8, 2.0)];
    assert!(ends[1] < 0.7 * ends[0], "{ends:?}");
    assert!(forward.decision(1.0, 0.1).chosen.contains("muzzle"));
    // The joint of an upright head is below it.
    rig.nodes[1].translation = [0.0, -2.0, 1.4];
    let upright = groom(&mesh, Some(&rig), 1.0).unwrap();
    assert!(!upright.decision(1.0, 0.1).chosen.contains("muzzle"));
}

#[test]
fn hair_is_short_beside_small_bare_parts_only() {
    // The barrel has a few bare triangles in its middle.
    let bared = |count: usize| {
        let mut mesh = surface_of_revolution(&(0..=40).map(|i| (0.05 * i as f32, 0.3)).collect::<Vec<_>>());
        let first = mesh.triangles.len() / 2;
        let all = mesh.triangles.len();
        mesh.parts = vec![part(0, 0, first), part(1, first, count), part(0, first + count, all - first - count)];
        let at = mesh.positions[mesh.triangles[first][0] as usize];
        (groom(&mesh, None, 1.0), mesh, at)
    };
    let (by_body, mesh, at) = bared(4);
    let by_body = by_body.unwrap();
    let at_distance = |low: f32, high: f32| {
        let there = mesh.positions.iter().zip(&by_body.length).filter(|(p, _)| (low..high).contains(&p.distance(at)));
        there.map(|(_, v)| *v).fold((f32::INFINITY, 0.0f32), |(low, high), v| (low.min(v), high.max(v)))
    };
    assert!(at_distance(0.0, 0.01).1 < 0.2, "{:?}", at_distance(0.0, 0.01));
    assert!(at_distance(0.4, 5.0).0 > 0.85, "{:?}", at_distance(0.4, 5.0));
    assert!(by_body.decision(1.0, 0.1).chosen.contains("near bare parts"));
    // A bare third of the area is a garment, not an eye or a nose.
    assert_eq!(bared(700).0, None);
}

#[test]
fn hair_reaches_beyond_soles_by_a_quarter_of_the_limbs_radius() {
    // Greatest reach beyond the end of the rod, relative to its radius, of hair that lies flat along it.
    let reach = |turn_rad: f32, name: Option<&str>| {
        let (mut mesh, rig) = rigged("Spine1", name.unwrap_or("Stick"));
        let turn = glam::Quat::from_rotation_x(turn_rad);
        let along: Vec<f32> = mesh.positions.iter().map(|p| p.z).collect();
        mesh.positions.iter_mut().chain(&mut mesh.normals).for_each(|v| *v = turn * *v);
        let by_body = groom(&mesh, name.map(|_| &rig), 1.0).unwrap();
        let longest = 0.05 * bounds(&RestPose { positions: mesh.positions, normals: Vec::new() }).radius;
        let beyond = along.iter().zip(by_body.length).map(|(z, length)| (z - 2.0 + length * longest) / 0.03);
        beyond.fold(0.0, f32::max)
    };
    let down = std::f32::consts::FRAC_PI_2;
    for name in [None, Some("Hoof.L")] {
        assert!((0.15..0.3).contains(&reach(down, name)), "{name:?}: {}", reach(down, name));
    }
    // Ends that are not on the ground have no sole.
    assert!(reach(-down, None) > 0.35, "{}", reach(-down, None));
}

#[test]
fn body_groom_does_not_depend_on_thread_count() {
    let mesh = barrel_with_rod();
    let on = |threads| on_threads(threads, || groom(&mesh, None, 1.0).unwrap());
    assert_eq!(on(1), on(3));
}
