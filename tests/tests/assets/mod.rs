//! Checks that the committed models equal those that the code generates, and have the properties that recipes and tests
//! rely on.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    sync::OnceLock,
};

use glam::DVec3;
use pelage_assets::{
    charts::{self, ChartReport},
    crane, crane_rig,
    glb::{Model, Primitive},
    hare, hare_rig, head, hills, ox, ox_rig, patterns, pony, pony_rig, pose, shapes,
};
use pelage_bake::recipe::Recipe;

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets").join(name)
}

/// Returns the hare. Generating it takes seconds, so the tests share it.
fn hare() -> &'static Model {
    static HARE: OnceLock<Model> = OnceLock::new();
    HARE.get_or_init(|| hare::model().unwrap())
}

/// Returns the ox, which the tests share.
fn ox() -> &'static Model {
    static OX: OnceLock<Model> = OnceLock::new();
    OX.get_or_init(|| ox::model().unwrap())
}

fn crane() -> &'static Model {
    static CRANE: OnceLock<Model> = OnceLock::new();
    CRANE.get_or_init(|| crane::model().unwrap())
}

fn hills() -> &'static Model {
    static HILLS: OnceLock<Model> = OnceLock::new();
    HILLS.get_or_init(|| hills::model().unwrap())
}

fn pony() -> &'static Model {
    static PONY: OnceLock<Model> = OnceLock::new();
    PONY.get_or_init(|| pony::model().unwrap())
}

fn head() -> &'static Model {
    static HEAD: OnceLock<Model> = OnceLock::new();
    HEAD.get_or_init(|| head::model().unwrap())
}

fn part<'a>(model: &'a Model, name: &str) -> &'a Primitive {
    model.primitives.iter().find(|p| p.name == name).unwrap()
}

/// Returns the bounding box of a part's positions.
fn bounds(p: &Primitive) -> [DVec3; 2] {
    let positions = || p.positions.iter();
    [positions().fold(DVec3::MAX, |m, &p| m.min(p)), positions().fold(DVec3::MIN, |m, &p| m.max(p))]
}

/// Returns the mesh surface of an animal as one primitive. It includes all materials except the eyeballs and the nose.
fn whole_skin(model: &Model) -> Primitive {
    let mut whole = Primitive::new(&model.name, 0);
    for p in model.primitives.iter().filter(|p| !["eyes", "nose"].contains(&p.name.as_str())) {
        let first = whole.len() as u32;
        whole.positions.extend(&p.positions);
        whole.normals.extend(&p.normals);
        whole.uvs.extend(&p.uvs);
        whole.colors.extend(&p.colors);
        whole.weights.extend(&p.weights);
        whole.triangles.extend(p.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    whole
}

fn report(p: &Primitive) -> ChartReport {
    charts::report(&p.positions, &p.uvs, &p.triangles)
}

/// Bit pattern of a position; the same for all copies of a vertex along a seam.
type PositionKey = [u64; 3];

fn key(p: DVec3) -> PositionKey {
    p.to_array().map(|x| (x + 0.0).to_bits())
}

/// Counts how often each edge is used in each direction, after vertices with equal positions are merged.
fn edges(p: &Primitive) -> BTreeMap<[PositionKey; 2], [u32; 2]> {
    let mut edges: BTreeMap<_, [u32; 2]> = BTreeMap::new();
    for t in &p.triangles {
        for k in 0..3 {
            let (a, b) = (key(p.positions[t[k] as usize]), key(p.positions[t[(k + 1) % 3] as usize]));
            let (edge, way) = if a < b { ([a, b], 0) } else { ([b, a], 1) };
            edges.entry(edge).or_default()[way] += 1;
        }
    }
    edges
}

fn is_closed_manifold(p: &Primitive) -> bool {
    edges(p).values().all(|ways| *ways == [1, 1])
}

/// Returns the Euler characteristic, after vertices with equal positions are merged: 2 for a ball, 0 for a torus.
fn euler_characteristic(p: &Primitive) -> i64 {
    let edges = edges(p);
    let vertices: BTreeSet<_> = edges.keys().flatten().collect();
    vertices.len() as i64 - edges.len() as i64 + p.triangles.len() as i64
}

fn volume(p: &Primitive) -> f64 {
    let corner = |v: u32| p.positions[v as usize];
    p.triangles.iter().map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0).sum()
}

#[test]
fn committed_models_match_their_generators() {
    for (name, model) in [
        ("hare", hare()),
        ("ox", ox()),
        ("crane", crane()),
        ("hills", hills()),
        ("pony", pony()),
        ("head", head()),
        ("torus", &shapes::torus()),
        ("knot", &shapes::knot()),
    ] {
        let path = folder("models").join(format!("{name}.glb"));
        let committed = fs::read(&path).unwrap();
        let made = model.to_glb().unwrap();
        assert!(
            committed == made,
            "{} differs from the generated model ({} and {} bytes); run `cargo run -p pelage-assets`",
            path.display(),
            committed.len(),
            made.len()
        );
    }
}

#[test]
fn committed_patterns_match_their_generators_and_tile() {
    for (name, made) in patterns::all() {
        let path = folder("patterns").join(format!("{name}.png"));
        let committed = image::open(&path).unwrap().into_rgb8();
        assert!(
            committed == made,
            "{} differs from the generated image; run `cargo run -p pelage-assets`",
            path.display()
        );
        // Patterns must tile: opposite borders must fit together almost as well as neighbouring rows and columns
        // inside.
        let step = |x0: u32, x1: u32| -> f64 {
            let rows = (0..patterns::SIDE)
                .map(|y| (made[(x0, y)][0].abs_diff(made[(x1, y)][0]), made[(y, x0)][0].abs_diff(made[(y, x1)][0])));
            rows.map(|(a, b)| f64::from(a) + f64::from(b)).sum()
        };
        let inside = (1..patterns::SIDE).map(|x| step(x - 1, x)).fold(0.0, f64::max);
        assert!(step(patterns::SIDE - 1, 0) <= 1.5 * inside, "{name} has a seam");
    }
}

#[test]
fn model_sizes_are_as_documented() {
    let [coat, eyes, nose] = hare().primitives.as_slice() else { panic!("the hare has three primitives") };
    assert!((4_700..=5_300).contains(&coat.triangles.len()), "{}", coat.triangles.len());
    assert!(eyes.triangles.len() + nose.triangles.len() < 1_200);
    assert!(hare().to_glb().unwrap().len() <= 400 << 10);
    assert_eq!(shapes::torus().primitives[0].triangles.len(), 570);
    assert_eq!(shapes::knot().primitives[0].triangles.len(), 2_880);

    let [low, high] = bounds(coat);
    assert!(low.y.abs() < 0.003, "the hare stands on the ground: {}", low.y);
    assert!((0.42..0.50).contains(&(high.y - low.y)), "{}", high.y - low.y);
    assert!(high.z > 0.1, "the hare must face +Z");
}

#[test]
fn the_ox_is_as_large_as_a_water_buffalo() {
    let skin = whole_skin(ox());
    assert!((5_000..=9_000).contains(&skin.triangles.len()), "{}", skin.triangles.len());
    assert!(ox().to_glb().unwrap().len() <= 500_000);
    let [low, high] = bounds(&skin);
    assert!(low.y.abs() < 0.01, "it stands on the ground: {}", low.y);
    assert!((2.5..3.1).contains(&(high.z - low.z)), "{low} {high}");
    // Checks where the materials are: hooves at the bottom, horns above the back, the muzzle foremost.
    let [hooves, horns, muzzle] = ["hooves", "horns", "muzzle"].map(|name| bounds(part(ox(), name)));
    assert!(hooves[1].y < 0.12 && horns[0].y > 0.9 && muzzle[0].z > 1.4, "{hooves:?} {horns:?} {muzzle:?}");
    assert_eq!(horns[1].y, high.y);
}

#[test]
fn crane_stands_on_its_legs_with_its_head_up() {
    let skin = whole_skin(crane());
    assert!((3_000..=6_000).contains(&skin.triangles.len()), "{}", skin.triangles.len());
    assert!(crane().to_glb().unwrap().len() <= 500_000);
    let [low, high] = bounds(&skin);
    assert!(low.y.abs() < 0.01 && (1.4..1.6).contains(&high.y), "{low} {high}");
    let [legs, plumes, beak, crown] = ["legs", "plumes", "beak", "crown"].map(|name| bounds(part(crane(), name)));
    assert!(legs[1].y < 0.6 && plumes[1].z < -0.2 && crown[0].y > 1.45, "{legs:?} {plumes:?} {crown:?}");
    assert_eq!(beak[1].z, high.z);
}

/// Returns the area of a part's triangles, m².
fn area(p: &Primitive) -> f64 {
    let corner = |v: u32| p.positions[v as usize];
    let double = |t: &[u32; 3]| (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0])).length();
    0.5 * p.triangles.iter().map(double).sum::<f64>()
}

#[test]
fn pony_has_correct_proportions_and_hair_regions() {
    let skin = whole_skin(pony());
    assert!((9_000..=14_000).contains(&skin.triangles.len()), "{}", skin.triangles.len());
    assert!(pony().to_glb().unwrap().len() <= 600_000);
    let [low, high] = bounds(&skin);
    assert!(low.y.abs() < 0.005 && (1.25..1.4).contains(&high.y), "it stands on the ground, ears up: {low} {high}");
    // The height at the withers, the highest point of the mesh surface above the elbows, must be 1 m.
    let withers = skin.positions.iter().filter(|p| (0.0..0.15).contains(&p.z)).map(|p| p.y).fold(0.0, f64::max);
    assert!((0.98..1.05).contains(&withers), "{withers}");
    let [crest, poll, dock, hooves] = ["crest", "poll", "dock", "hooves"].map(|name| part(pony(), name));
    let width = |p: &Primitive| bounds(p)[1].x - bounds(p)[0].x;
    assert!((0.035..0.045).contains(&width(crest)), "{}", width(crest));
    let [withers, top] = bounds(crest);
    assert!(
        withers.y < 1.05 && top.y > 1.2 && withers.z < 0.2 && top.z > 0.5,
        "from the withers to the poll: {withers} {top}"
    );
    assert!(bounds(poll)[0].y > 1.15 && bounds(poll)[0].z > withers.z && width(poll) < 0.07, "{:?}", bounds(poll));
    assert!(bounds(dock)[1].z < -0.5 && bounds(dock)[0].y > 0.6, "{:?}", bounds(dock));
    assert!(bounds(hooves)[1].y < 0.08, "{:?}", bounds(hooves));
    // Checks that hair is short on the face, and almost absent at the eyes.
    let (coat, eyes) = (part(pony(), "body"), part(pony(), "eyes"));
    let to_eye = |p: DVec3| eyes.positions.iter().map(|e| e.distance(p)).fold(f64::MAX, f64::min);
    let lids = coat.positions.iter().zip(&coat.colors).filter(|(p, _)| to_eye(**p) < 0.003);
    let lids: Vec<f64> = lids.map(|(_, c)| c.w).collect();
    assert!(lids.len() > 4 && lids.iter().all(|l| *l < 0.2), "{lids:?}");
}

#[test]
fn head_is_life_size_with_an_even_scalp() {
    let skin = whole_skin(head());
    assert!((14_000..=20_000).contains(&skin.triangles.len()), "{}", skin.triangles.len());
    assert!(head().to_glb().unwrap().len() <= 600_000);
    let [low, high] = bounds(&skin);
    assert!(low.y.abs() < 0.005 && (0.36..0.4).contains(&high.y), "{low} {high}");
    let [scalp, brows, lashes] = ["scalp", "brows", "lashes"].map(|name| part(head(), name));
    assert!((0.055..0.07).contains(&area(scalp)), "{} m² of scalp", area(scalp));
    assert!((0.0002..0.0012).contains(&area(brows)), "{} m² of brows", area(brows));
    assert!((0.00004..0.0003).contains(&area(lashes)), "{} m² of lashes", area(lashes));
    for p in [brows, lashes] {
        assert!(bounds(p)[0].z > 0.03 && bounds(p)[0].y > 0.25, "{}: {:?}", p.name, bounds(p));
    }
    let corner = |v: u32| scalp.positions[v as usize];
    let edges = scalp.triangles.iter().flat_map(|t| (0..3).map(|k| (corner(t[k]) - corner(t[(k + 1) % 3])).length()));
    let mut edges: Vec<f64> = edges.collect();
    edges.sort_by(f64::total_cmp);
    let at = |share: f64| edges[(share * edges.len() as f64) as usize];
    assert!(at(0.1) > 0.004 && at(0.9) < 0.0105, "edges of {} to {} m", at(0.1), at(0.9));
}

#[test]
fn pony_and_head_are_symmetric() {
    for model in [pony(), head()] {
        let skin = whole_skin(model);
        let places: BTreeSet<PositionKey> = skin.positions.iter().map(|p| key(*p)).collect();
        let lonely = skin.positions.iter().filter(|p| !places.contains(&key(DVec3::new(-p.x, p.y, p.z)))).count();
        assert_eq!(lonely, 0, "{}: vertices without a mirror image", model.name);
    }
}

#[test]
fn hills_are_ordered_in_depth_and_the_path_is_flat() {
    assert!(hills().primitives.iter().map(|p| p.triangles.len()).sum::<usize>() <= 12_000);
    assert!(hills().to_glb().unwrap().len() <= 500_000);
    let ridges = ["near", "middle", "far"].map(|name| part(hills(), name));
    for p in ridges {
        assert!(is_closed_manifold(p) && volume(p) > 0.0, "{}", p.name);
    }
    let ridges = ridges.map(bounds);
    for pair in ridges.windows(2) {
        assert!(pair[1][1].z < pair[0][0].z && pair[1][1].y > pair[0][1].y, "{ridges:?}");
    }
    // Checks that the animals have ground to stand on, and that no ground in front of the path hides their feet.
    let path = part(hills(), "path");
    assert!(path.positions.iter().all(|p| p.y.abs() < 1e-6 && p.z.abs() < 1.4), "{:?}", bounds(path));
    let [left, right] = bounds(path);
    assert!(left.x < -30.0 && right.x > 30.0);
    for p in &part(hills(), "ground").positions {
        assert!(p.z < 0.0 || p.y < 1e-6, "{p} is in front of the path");
        assert!(p.z.abs() > 1.6 || p.y.abs() < 1e-6, "{p} is not flat");
    }
    // The foot of a ridge must be below the ground, because a gap would be visible otherwise.
    assert!(ridges.iter().all(|r| r[0].y < -1.0), "{ridges:?}");
}

#[test]
fn surfaces_are_closed_and_face_outwards() {
    let (torus, knot) = (shapes::torus(), shapes::knot());
    let [ox, crane, pony, head] = [ox(), crane(), pony(), head()].map(whole_skin);
    let coat = &hare().primitives[0];
    let skins = [(coat, 2), (&ox, 2), (&crane, 2), (&pony, 2), (&head, 2)];
    for (p, euler) in skins.into_iter().chain([(&torus.primitives[0], 0), (&knot.primitives[0], 0)]) {
        assert!(is_closed_manifold(p), "{}", p.name);
        assert_eq!(euler_characteristic(p), euler, "{}", p.name);
        assert!(volume(p) > 0.0, "{}", p.name);
    }

    let mut torn = coat.clone();
    torn.triangles.pop();
    assert!(!is_closed_manifold(&torn), "the check must detect a missing triangle");
    let mut turned = coat.clone();
    turned.triangles[0].swap(0, 1);
    assert!(!is_closed_manifold(&turned), "the check must detect a flipped triangle");
}

#[test]
fn model_normals_are_unit_length_and_agree_with_their_triangles() {
    for model in [hare(), ox(), crane(), hills(), pony(), head(), &shapes::torus(), &shapes::knot()] {
        for p in &model.primitives {
            assert!(p.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-6), "{}", p.name);
            for t in &p.triangles {
                let [a, b, c] = t.map(|v| p.positions[v as usize]);
                let face = (b - a).cross(c - a).normalize();
                let least = t.iter().map(|&v| p.normals[v as usize].dot(face)).fold(1.0, f64::min);
                assert!(least > 0.1, "{}: cosine {least} between a normal and its triangle at {a}", p.name);
            }
        }
    }
}

#[test]
fn the_hares_hair_is_short_round_its_eyes_and_long_on_its_back() {
    let [coat, eyes, _] = hare().primitives.as_slice() else { panic!("the hare has three primitives") };
    let lengths = |near: &dyn Fn(DVec3) -> bool| -> Vec<f64> {
        coat.positions.iter().zip(&coat.colors).filter(|(p, _)| near(**p)).map(|(_, c)| c.w).collect()
    };
    let to_eye = |p: DVec3| eyes.positions.iter().map(|e| e.distance(p)).fold(f64::MAX, f64::min);
    let lids = lengths(&|p| to_eye(p) < 0.003);
    assert!(lids.len() > 4 && lids.iter().all(|l| *l < 0.15), "{lids:?}");
    let back = lengths(&|p| p.z < 0.0 && (0.1..0.22).contains(&p.y));
    assert!(back.len() > 100 && back.iter().all(|l| *l == 1.0), "{} on the back", back.len());
}

#[test]
fn hare_triangles_are_well_shaped() {
    // The quality of a triangle is 1 if it is equilateral and 0 if it is a sliver.
    let quality = |[a, b, c]: [DVec3; 3]| {
        let squares = (b - a).length_squared() + (c - b).length_squared() + (a - c).length_squared();
        2.0 * 3.0_f64.sqrt() * (b - a).cross(c - a).length() / squares
    };
    let coat = &hare().primitives[0];
    let mut all: Vec<f64> = coat.triangles.iter().map(|t| quality(t.map(|v| coat.positions[v as usize]))).collect();
    all.sort_by(f64::total_cmp);
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    assert!(mean > 0.88 && all[0] > 0.15, "mean {mean}, least {}", all[0]);
}

#[test]
fn charts_are_right_handed_with_even_density_and_correct_scale() {
    for model in [hare(), &shapes::torus(), &shapes::knot()] {
        let r = report(&model.primitives[0]);
        assert_eq!(r.flipped_triangles, 0, "{}", model.name);
        assert!((0.095..0.105).contains(&r.metres_per_uv), "{}: {r:?}", model.name);
        assert!(r.angle_distortion < 0.06 && r.area_distortion < 0.06, "{}: {r:?}", model.name);
    }
    let r = report(&hare().primitives[0]);
    assert!(r.angle_distortion < 0.03 && r.area_distortion < 0.012 && r.seam_length_ratio < 18.0, "{r:?}");

    let mut mirrored = hare().primitives[0].clone();
    for uv in &mut mirrored.uvs {
        uv[0] = -uv[0];
    }
    assert_eq!(report(&mirrored).flipped_triangles, mirrored.triangles.len(), "the check must detect mirrored charts");
}

#[test]
fn texture_coordinates_at_tube_seams_differ_by_whole_tiles() {
    for model in [shapes::torus(), shapes::knot()] {
        let p = &model.primitives[0];
        let mut seen: BTreeMap<PositionKey, [f64; 2]> = BTreeMap::new();
        let mut copies = 0;
        for (&position, uv) in p.positions.iter().zip(&p.uvs) {
            if let Some(other) = seen.insert(key(position), *uv) {
                copies += 1;
                for k in 0..2 {
                    let jump = uv[k] - other[k];
                    assert!((jump - jump.round()).abs() < 1e-9, "{}: jump {jump}", model.name);
                }
            }
        }
        assert!(copies > 0, "{} has seams", model.name);
    }
}

/// Joint of a foot, and position of the foot's tip at rest.
type Foot = (usize, DVec3);

/// Returns the models with a skeleton, each with a gait, its feet, and the distance (m) and duration (s) of a cycle of
/// the gait.
fn animals() -> Vec<(&'static Model, &'static str, Vec<Foot>, [f64; 2])> {
    vec![
        (hare(), "Walk", hare_rig::feet(), [hare_rig::HOP_M, hare_rig::HOP_S]),
        (ox(), "Walk", ox_rig::feet(), [ox_rig::CYCLE_M, ox_rig::CYCLE_S]),
        (crane(), "Walk", crane_rig::feet(), [crane_rig::CYCLE_M, crane_rig::CYCLE_S]),
        (pony(), "Walk", pony_rig::feet(), [pony_rig::CYCLE_M, pony_rig::CYCLE_S]),
        (pony(), "Gallop", pony_rig::feet(), [pony_rig::GALLOP_M, pony_rig::GALLOP_S]),
    ]
}

#[test]
fn joint_weights_sum_to_one_and_clips_loop() {
    for (model, ..) in animals() {
        let joints = model.skeleton.as_ref().unwrap();
        assert!((10..=40).contains(&joints.len()), "{}: {} joints", model.name, joints.len());
        for p in &model.primitives {
            for weights in &p.weights {
                let sum: f64 = weights.iter().map(|w| w.1).sum();
                assert!((sum - 1.0).abs() < 1e-9);
                assert!(weights.iter().all(|w| w.1 >= 0.0 && (w.0 as usize) < joints.len()));
            }
        }
        for clip in &model.clips {
            let seconds = *clip.channels[0].times.last().unwrap();
            for channel in &clip.channels {
                assert!(channel.times.windows(2).all(|t| t[0] < t[1]));
                assert_eq!((channel.times[0], *channel.times.last().unwrap()), (0.0, seconds), "{}", clip.name);
                let n = channel.values.len();
                let width = n / channel.times.len();
                assert_eq!(channel.values[..width], channel.values[n - width..], "first and last key agree");
            }
        }
        assert!(model.clips.iter().any(|c| c.name == "Walk"));
    }
    let names: Vec<&str> = hare().clips.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["EarBreath", "Walk"]);
}

/// Samples a foot's tip at `steps` times of a gait. Returns its height above the lowest point (m) and its backward
/// speed (m/s).
fn foot_path(model: &Model, gait: &str, (joint, tip): Foot, seconds: f64, steps: u32) -> Vec<[f64; 2]> {
    let clip = model.clips.iter().find(|c| c.name == gait).unwrap();
    let at = |k: u32| {
        let time = seconds * f64::from(k % steps) / f64::from(steps);
        pose::skin_transforms(model, clip, time)[joint].transform_point3(tip)
    };
    let path: Vec<DVec3> = (0..=steps).map(at).collect();
    let lowest = path.iter().map(|p| p.y).fold(f64::MAX, f64::min);
    let step_s = seconds / f64::from(steps);
    path.windows(2).map(|p| [p[0].y.max(p[1].y) - lowest, (p[0].z - p[1].z) / step_s]).collect()
}

#[test]
fn planted_feet_move_at_the_speed_of_the_ground() {
    for (model, gait, feet, [metres, seconds]) in animals() {
        let high = model.primitives[0].positions.iter().map(|p| p.y).fold(0.0, f64::max);
        for foot in feet {
            let path = foot_path(model, gait, foot, seconds, 48);
            // Touch-down and lift-off are excluded.
            let low = |k: usize| path[k % 48][0] < 0.006 * high;
            let down: Vec<f64> = (0..48).filter(|&k| low(k + 47) && low(k) && low(k + 1)).map(|k| path[k][1]).collect();
            let (slow, fast) = down.iter().fold((f64::MAX, f64::MIN), |m, v| (m.0.min(*v), m.1.max(*v)));
            let (mean, ground) = (down.iter().sum::<f64>() / down.len() as f64, metres / seconds);
            assert!(
                down.len() >= 6,
                "{} {gait}: joint {} is on the ground in {} of 48 steps",
                model.name,
                foot.0,
                down.len()
            );
            assert!(
                (mean / ground - 1.0).abs() < 0.08 && slow > 0.7 * ground && fast < 1.3 * ground,
                "{} {gait}: joint {} goes at {slow} to {fast}, mean {mean} m/s on a ground of {ground}",
                model.name,
                foot.0
            );
        }
    }
}

#[test]
fn every_recipe_parses_and_names_materials_that_exist() {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder("recipes")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let recipe = Recipe::parse(&name, &fs::read_to_string(&path).unwrap()).unwrap_or_else(|e| panic!("{e}"));
        recipe.validate().unwrap_or_else(|e| panic!("{name}: {e}"));
        // Each generated model is checked only with the recipe of the same name.
        let model = match name.as_str() {
            "hare.toml" => Some(hare()),
            "ox.toml" => Some(ox()),
            "crane.toml" => Some(crane()),
            "hills.toml" => Some(hills()),
            "pony.toml" => Some(pony()),
            "head.toml" => Some(head()),
            _ => None,
        };
        if let Some(model) = model {
            let materials: Vec<&str> = model.materials.iter().map(|m| m.name.as_str()).collect();
            assert!(recipe.model.bare.iter().flatten().all(|b| materials.contains(&b.as_str())), "{materials:?}");
        }
        names.push(name);
    }
    names.sort();
    assert_eq!(
        names,
        [
            "alpaca.toml",
            "cow.toml",
            "crane.toml",
            "fox.toml",
            "hare.toml",
            "head.toml",
            "hedgehog.toml",
            "hills.toml",
            "knot.toml",
            "ox.toml",
            "pony.toml",
            "shiba.toml",
            "spots.toml",
            "tabby.toml",
            "torus.toml",
            "wolf.toml",
            "zebra.toml"
        ]
    );
}
