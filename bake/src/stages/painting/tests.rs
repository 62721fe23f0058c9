use super::*;
use crate::stages::fixtures::{on_threads, part};
use crate::stages::groom::{Colors, HeadShape, MaterialColor};
use crate::stages::surface::{Measures, Surface};
use glam::{Vec2, Vec4};
use pelage_formats::{Bounds, HairGroup, InkVertex, TrianglePoint};
use pelage_import::mesh::{Material, Mesh, RestPose};
use std::f32::consts::{PI, TAU};

/// Number of vertices around the x axis.
const SIDES: u32 = 40;
/// Radius of the limb, metres. The trunk is a ball of radius 1 m around the origin.
const LIMB_M: f32 = 0.1;
/// Position of the limb's end, metres along x.
const END_M: f32 = 3.5;
/// Radius and height of the branch, metres, and its position along x.
const BRANCH_M: [f32; 3] = [0.05, 0.9, 2.0];

/// Model in the form that the stage reads.
struct Animal {
    surface: Surface,
    colors: Colors,
    bounds: Bounds,
    materials: Vec<Material>,
    hair_m: Vec<f32>,
    head: Option<HeadShape>,
    groups: Vec<HairGroup>,
    ink: Vec<InkVertex>,
}

impl Animal {
    /// Returns a white animal with hair of 5 cm, combed along +x.
    fn new(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Self {
        let mut normals = vec![Vec3::ZERO; positions.len()];
        for triangle in &triangles {
            let [a, b, c] = triangle.map(|v| positions[v as usize]);
            triangle.iter().for_each(|v| normals[*v as usize] += (b - a).cross(c - a));
        }
        let normals: Vec<Vec3> = normals.into_iter().map(|n| n.normalize_or(Vec3::Y)).collect();
        // The bitangent is the combing direction.
        let tangent = |n: &Vec3| Vec3::X.cross(*n).try_normalize().unwrap_or(n.any_orthonormal_vector()).extend(1.0);
        let tangents: Vec<Vec4> = normals.iter().map(tangent).collect();
        let [min, max] = [Vec3::min, Vec3::max].map(|f| positions.iter().copied().reduce(f).unwrap());
        let center = (min + max) / 2.0;
        let radius = positions.iter().map(|p| p.distance(center)).fold(0.0, f32::max);
        let bounds = Bounds { min: min.into(), max: max.into(), center: center.into(), radius };
        let count = positions.len();
        let rest = RestPose { positions: positions.clone(), normals: normals.clone() };
        let parts = vec![part(0, 0, triangles.len())];
        let (uvs, colors) = (vec![Vec2::ZERO; count], vec![[255; 4]; count]);
        let mesh = Mesh { positions, normals, uvs, colors, triangles, parts, ..Mesh::default() };
        let surface = Surface {
            patch_of_triangle: vec![0; mesh.triangles.len()],
            mesh,
            rest,
            input_vertex: (0..count as u32).collect(),
            tile_uvs: vec![Vec2::ZERO; count],
            tangents,
            singularities: Vec::new(),
            measures: Measures::default(),
            warnings: Vec::new(),
        };
        let white = MaterialColor { factor: [1.0; 4], image: None };
        let colors = Colors { materials: vec![white; 2], vertices: vec![[255; 4]; count], ..Colors::default() };
        let material = |name: &str| Material { name: name.into(), ..Material::default() };
        let materials = vec![material("Body"), material("Body")];
        Self {
            surface,
            colors,
            bounds,
            materials,
            hair_m: vec![0.05; count],
            head: None,
            groups: Vec::new(),
            ink: Vec::new(),
        }
    }

    /// Returns the animal whose vertices near `at` have a grey, linear 0..=255; their triangles have material 1.
    fn with_patch(mut self, at: Vec3, radius_m: f32, grey: u8) -> Self {
        let mesh = &mut self.surface.mesh;
        let is_near = |v: u32| mesh.positions[v as usize].distance(at) < radius_m;
        let near: Vec<u32> = (0..mesh.positions.len() as u32).filter(|v| is_near(*v)).collect();
        near.iter().for_each(|v| self.colors.vertices[*v as usize] = [grey, grey, grey, 255]);
        let (inside, outside): (Vec<_>, Vec<_>) = mesh.triangles.iter().partition(|t| t.iter().all(|v| is_near(*v)));
        assert!(inside.len() > 10, "{} triangles", inside.len());
        mesh.parts = vec![part(0, 0, outside.len()), part(1, outside.len(), inside.len())];
        mesh.triangles = outside.into_iter().chain(inside).collect();
        self
    }

    fn canvas(&self) -> Canvas {
        Canvas::new(&self.model(), name_of_eyes)
    }

    fn painting(&self) -> StrokePool {
        painting(&self.model())
    }

    fn model(&self) -> PaintedModel<'_> {
        PaintedModel {
            surface: &self.surface,
            colors: &self.colors,
            bounds: &self.bounds,
            materials: &self.materials,
            furred: &[true; 2],
            hair_m: &self.hair_m,
            head: self.head.as_ref(),
            ink: &self.ink,
            groups: &self.groups,
            seed: 7,
        }
    }

    /// Returns a position of the canvas in metres.
    fn metres(&self, canvas: &Canvas, p: Vec3) -> Vec3 {
        p * canvas.size + Vec3::from(self.bounds.center)
    }
}

/// Returns a ball with a cylinder along +x as its limb. With a branch, a thinner cylinder grows from the limb towards
/// +y.
fn limbed(has_branch: bool) -> Animal {
    let mut profile: Vec<[f32; 2]> = Vec::new();
    let neck = LIMB_M.asin();
    let balls = 40;
    profile.extend((0..=balls).map(|k| {
        let angle = PI - (PI - neck) * k as f32 / balls as f32;
        [angle.cos(), angle.sin()]
    }));
    let steps = 100;
    let from = neck.cos();
    profile.extend((1..=steps).map(|k| [from + (END_M - from) * k as f32 / steps as f32, LIMB_M]));
    profile.push([END_M + 0.5 * LIMB_M, 0.7 * LIMB_M]);
    profile.push([END_M + 0.7 * LIMB_M, 0.0]);
    profile[0][1] = 0.0;
    let mut positions = Vec::new();
    for [x, r] in &profile {
        positions.extend((0..SIDES).map(|j| {
            let angle = TAU * j as f32 / SIDES as f32;
            Vec3::new(*x, r * angle.cos(), r * angle.sin())
        }));
    }
    let [radius, height, along] = BRANCH_M;
    let first = profile.iter().position(|[x, _]| *x > along - radius).unwrap() as u32;
    let last = profile.iter().position(|[x, _]| *x > along + radius).unwrap() as u32;
    // The branch begins at a hole in the limb: from row `first` to `last`, and `wide` columns on each side of +y.
    let wide = 3;
    let column = |j: i32| j.rem_euclid(SIDES as i32) as u32;
    let at = |i: u32, j: i32| i * SIDES + column(j);
    let mut triangles = Vec::new();
    for (i, j) in (0..profile.len() as u32 - 1).flat_map(|i| (0..SIDES as i32).map(move |j| (i, j))) {
        let folded = if j >= SIDES as i32 / 2 { j - SIDES as i32 } else { j };
        if has_branch && (first..last).contains(&i) && (-wide..wide).contains(&folded) {
            continue;
        }
        triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
        triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
    }
    if has_branch {
        let mut ring: Vec<u32> = (first..last).map(|i| at(i, -wide)).collect();
        ring.extend((-wide..wide).map(|j| at(last, j)));
        ring.extend((first + 1..=last).rev().map(|i| at(i, wide)));
        ring.extend((-wide + 1..=wide).rev().map(|j| at(first, j)));
        let angles: Vec<f32> =
            ring.iter().map(|v| positions[*v as usize] - Vec3::X * along).map(|p: Vec3| p.z.atan2(p.x)).collect();
        let rings = 40;
        for k in 1..=rings {
            let share = k as f32 / rings as f32;
            // The last ring is a tip.
            let (r, y) = (if k == rings { 0.0 } else { radius }, LIMB_M + height * share);
            let above: Vec<u32> = angles
                .iter()
                .map(|a| {
                    positions.push(Vec3::new(along + r * a.cos(), y, r * a.sin()));
                    positions.len() as u32 - 1
                })
                .collect();
            for n in 0..ring.len() {
                let m = (n + 1) % ring.len();
                triangles.push([ring[n], above[n], above[m]]);
                triangles.push([ring[n], above[m], ring[m]]);
            }
            ring = above;
        }
    }
    let mut animal = Animal::new(positions, triangles);
    let outwards = animal.surface.mesh.normals[20 * SIDES as usize].dot(animal.surface.mesh.positions[20 * 40]);
    assert!(outwards > 0.9, "triangles face outwards: {outwards}");
    animal.hair_m.iter_mut().for_each(|h| *h = 0.2);
    animal
}

#[test]
fn axis_runs_along_the_limb() {
    let animal = limbed(false);
    let canvas = animal.canvas();
    let found = axes::axes(&canvas).axes;
    assert_eq!(found.len(), 1);
    let axis: Vec<(Vec3, f32)> =
        found[0].iter().map(|p| (animal.metres(&canvas, p.center), p.radius * canvas.size)).collect();
    // The ball's trunk ends before x = 1.3, and the limb's last rings are in its rounded end.
    assert!(axis[0].0.x < 1.3 && axis[axis.len() - 1].0.x > END_M - LIMB_M, "{axis:?}");
    let straight: Vec<_> = axis.iter().filter(|(p, _)| (1.3..END_M - LIMB_M).contains(&p.x)).collect();
    assert!(straight.len() > 60, "{}", straight.len());
    for (p, radius) in straight {
        let off = p.y.hypot(p.z);
        assert!(off < 0.05 * LIMB_M, "{off} m off the axis at {p}");
        assert!((radius - LIMB_M).abs() < 0.05 * LIMB_M, "radius {radius} at {p}");
    }
    assert!(axis.windows(2).all(|pair| pair[1].0.x > pair[0].0.x), "from the trunk to the tip");
    // The strokes along the axis are attached to both sides of the limb.
    let pool = animal.painting();
    let along: Vec<&PaintStroke> =
        pool.strokes.iter().filter(|s| s.points[12].sides[0] != s.points[12].sides[1]).collect();
    assert_eq!(along.iter().map(|s| s.kind).collect::<Vec<_>>(), LIMB_WIDTHS.map(|(kind, _)| kind));
    let position = |anchor: StrokeAnchor| {
        let [a, b, c] = anchor.vertices.map(|v| animal.surface.mesh.positions[v as usize]);
        let [v, w] = anchor.weights.map(|w| f32::from(w) / 65535.0);
        a * (1.0 - v - w) + b * v + c * w
    };
    for point in &along[0].points[2..22] {
        let middle = (position(point.sides[0]) + position(point.sides[1])) / 2.0;
        assert!(middle.y.hypot(middle.z) < 0.05 * LIMB_M, "{middle}");
        assert!((point.half_width_m - 0.9 * LIMB_M).abs() < 0.1 * LIMB_M, "{}", point.half_width_m);
    }
}

#[test]
fn forks_begin_on_their_parent() {
    let animal = limbed(true);
    let canvas = animal.canvas();
    let found = axes::axes(&canvas).axes;
    assert_eq!(found.len(), 2, "limb and branch");
    let [limb, branch] = [&found[0], &found[1]].map(|axis| axis.iter().map(|p| p.center).collect::<Vec<_>>());
    assert!(limb.contains(&branch[0]), "{}", branch[0]);
    assert!(!limb.contains(&branch[1]), "only the first point is shared");
    let [start, tip] = [branch[0], branch[branch.len() - 1]].map(|p| animal.metres(&canvas, p));
    let [radius, height, along] = BRANCH_M;
    assert!((start.x - along).abs() < 3.0 * radius && start.y.abs() < LIMB_M, "{start}");
    assert!((tip.x - along).abs() < 0.5 * radius && tip.y > LIMB_M + 0.9 * height, "{tip}");
    let end = animal.metres(&canvas, limb[limb.len() - 1]);
    assert!(end.x > END_M - LIMB_M && end.y.abs() < 0.05 * LIMB_M, "{end}");
}

#[test]
fn washes_cover_the_trunk() {
    let animal = limbed(false);
    let canvas = animal.canvas();
    let distance = axes::axes(&canvas).distance;
    let is_limb: Vec<bool> = distance.iter().map(|d| *d > 0.0).collect();
    let strokes = washes::washes(&canvas, &is_limb, 7);
    assert!(strokes.iter().all(|s| s.kind == StrokeKind::Pale), "a white animal has the first wash only");
    // Places that the stroke's own samples do not contain.
    let trunk: Vec<Vec3> = washes::spread_places(&canvas, 3000, 99)
        .iter()
        .filter(|p| canvas.at(&distance, p) == 0.0)
        .map(|p| p.position)
        .collect();
    assert!(trunk.len() > 2000, "{}", trunk.len());
    let share = |count: usize| {
        let is_painted = |p: &&Vec3| {
            let near = |s: &washes::SurfaceStroke| s.places.iter().any(|q| q.position.distance(**p) < s.half_width);
            strokes.iter().take(count).any(near)
        };
        trunk.iter().filter(is_painted).count() as f32 / trunk.len() as f32
    };
    let (all, few) = (share(strokes.len()), share(3));
    println!("{} strokes cover {all}, 3 strokes {few}", strokes.len());
    assert!(all >= 0.8, "{} strokes cover {all} of the trunk", strokes.len());
    assert!(few < 0.8, "3 strokes cover {few} of the trunk");
    let on_limb = strokes.iter().flat_map(|s| &s.places).filter(|p| canvas.at(&distance, p) > 0.05).count();
    assert_eq!(on_limb, 0, "the limb has its own strokes");
}

/// Returns the kinds of all spots and eyes.
fn spots_of(animal: &Animal) -> Vec<StrokeKind> {
    let kinds = animal.painting().strokes.into_iter().map(|s| s.kind);
    kinds.filter(|kind| matches!(kind, StrokeKind::Spot | StrokeKind::Eye)).collect()
}

#[test]
fn dark_patches_are_spots_and_eyes_are_recognised_by_name() {
    assert_eq!(spots_of(&limbed(false)), []);
    let low = Vec3::NEG_Y;
    let black = limbed(false).with_patch(low, 0.22, 0);
    assert_eq!(spots_of(&black), [StrokeKind::Spot]);
    let spot = black.painting().strokes.swap_remove(0);
    for point in &spot.points {
        let near = black.surface.mesh.positions[point.sides[0].vertices[0] as usize].distance(low);
        assert!(near < 0.35 && point.darkness == 1.0 && (0.0..0.3).contains(&point.half_width_m), "{point:?}");
    }
    // A patch that is too large is a colour of the coat.
    assert_eq!(spots_of(&limbed(false).with_patch(low, 0.6, 0)), []);
    // Grey eyes are too pale for spots. They are recognised by the name of their material, wherever they are.
    let mut grey = limbed(false).with_patch(low, 0.22, 30);
    assert_eq!(spots_of(&grey), []);
    grey.materials[1].name = "Eye".into();
    assert_eq!(spots_of(&grey), [StrokeKind::Eye]);
    // A small patch high on the body is an eye only if none has that name.
    let high = limbed(false).with_patch(Vec3::new(-0.95, 0.31, 0.0), 0.13, 0);
    assert_eq!(spots_of(&high), [StrokeKind::Eye]);
    let mut both = high.with_patch(low, 0.22, 0);
    both.materials[1].name = "Eye".into();
    for spot in both.painting().strokes {
        let is_low = both.surface.mesh.positions[spot.points[0].sides[0].vertices[0] as usize].y < 0.0;
        match spot.kind {
            StrokeKind::Spot => assert!(!is_low),
            StrokeKind::Eye => assert!(is_low),
            _ => {}
        }
    }
    assert_eq!(spots_of(&both).len(), 2);
}

/// Returns an egg along x from -2 to 2 m that has its head at x > 0.8.
fn snouted() -> Animal {
    let (rings, mut positions, mut triangles) = (40, Vec::new(), Vec::new());
    for k in 0..=rings {
        let (x, radius) = (-(PI * k as f32 / rings as f32).cos(), (PI * k as f32 / rings as f32).sin());
        positions.extend((0..SIDES).map(|n| {
            let angle = TAU * n as f32 / SIDES as f32;
            Vec3::new(2.0 * x, 0.5 * radius * angle.cos(), 0.5 * radius * angle.sin())
        }));
    }
    for (k, n) in (0..rings).flat_map(|k| (0..SIDES).map(move |n| (k * SIDES, n))) {
        let [a, b] = [k + n, k + (n + 1) % SIDES];
        triangles.extend([[a, b + SIDES, a + SIDES], [a, b, b + SIDES]]);
    }
    let share = positions.iter().map(|p: &Vec3| f32::from(u8::from(p.x > 0.8))).collect();
    let mut animal = Animal::new(positions, triangles);
    assert!(animal.surface.mesh.normals[20 * SIDES as usize].y > 0.9, "triangles face outwards");
    animal.head = Some(HeadShape { share, nose_m: Vec3::X * 2.0, middle_m: Vec3::X * 1.3, forward: Vec3::X });
    animal
}

/// Returns the positions of nostrils and mouth, metres, each with its darkness.
fn face_of(animal: &Animal) -> Vec<(Vec<Vec3>, f32)> {
    let canvas = animal.canvas();
    let found = face::nostrils_and_mouth(&canvas, &spots::spots(&canvas, PaintStroke::POINTS));
    let metres = |spot: &spots::Spot| spot.places.iter().map(|p| animal.metres(&canvas, p.position)).collect();
    found.iter().map(|spot| (metres(spot), spot.darkness)).collect()
}

#[test]
fn snouts_have_nostrils_above_a_mouth_on_both_sides() {
    let animal = snouted();
    let face = face_of(&animal);
    assert_eq!(face.len(), 4, "two nostrils, and a line on each side");
    for (left, right) in [(&face[0].0, &face[2].0), (&face[1].0, &face[3].0)] {
        let mirrored = left.iter().zip(right).all(|(a, b)| a.distance(*b * Vec3::new(1.0, 1.0, -1.0)) < 0.02);
        assert!(mirrored && left[12].z.abs() > 0.05, "{left:?} {right:?}");
    }
    assert!(face[0].0.iter().all(|p| p.y > 0.0 && p.x > 1.7), "{:?}", face[0]);
    assert!(face[1].0.iter().all(|p| p.y < 0.0 && p.x > 1.3), "{:?}", face[1]);
    assert!(face[0].1 > face[1].1, "nostrils are darker");
    // The nose of this model is already dark.
    assert_eq!(face_of(&snouted().with_patch(Vec3::X * 2.0, 0.12, 0)).len(), 2);
}

#[test]
fn doubtful_snouts_have_no_face() {
    let mut animal = snouted();
    animal.head.as_mut().unwrap().nose_m.z = 0.15;
    assert_eq!(face_of(&animal), [], "the nose is on one side");
    animal = snouted();
    animal.head.as_mut().unwrap().middle_m.x = 1.8;
    assert_eq!(face_of(&animal), [], "the snout is wider than long");
    animal.head = None;
    assert_eq!(face_of(&animal), []);
}

#[test]
fn eyes_are_found_between_vertices_of_a_texture() {
    let mut animal = snouted();
    // The texture is projected along z. Its eye is 0.7 m behind the nose and 0.15 m above the axis.
    let size = 256_u32;
    let is_eye = |k: u32| {
        let [x, y] = [k % size, k / size].map(|i| i as f32 / size as f32 - 0.5);
        (4.0 * x - 1.3).hypot(y - 0.15) < 0.06
    };
    let rgba = (0..size * size).flat_map(|k| [if is_eye(k) { 0 } else { 200 }; 4]).collect();
    animal.colors.images = vec![std::sync::Arc::new(pelage_import::mesh::Image { width: size, height: size, rgba })];
    animal.colors.materials[0].image = Some(0);
    let uv = |p: &Vec3| Vec2::new(p.x / 4.0 + 0.5, p.y + 0.5);
    animal.surface.mesh.uvs = animal.surface.mesh.positions.iter().map(uv).collect();
    let eyes = |animal: &Animal| {
        let mut found = Vec::new();
        face::add_hidden_spots(&animal.model(), &animal.canvas(), &mut found);
        found
    };
    let found = eyes(&animal);
    assert_eq!(found.iter().map(|spot| spot.kind).collect::<Vec<_>>(), [StrokeKind::Eye; 2]);
    for eye in &found {
        let p = animal.metres(&animal.canvas(), eye.places[12].position);
        assert!((p.x - 1.3).abs() < 0.04 && (p.y - 0.15).abs() < 0.04, "{p}");
    }
    assert!(found[0].places[12].position.z * found[1].places[12].position.z < 0.0, "one on each side");
    // A single dark patch is not an eye.
    let single = |p: &Vec3| if p.z > 0.0 { uv(p) } else { Vec2::ZERO };
    animal.surface.mesh.uvs = animal.surface.mesh.positions.iter().map(single).collect();
    assert!(eyes(&animal).is_empty());
}

#[test]
fn painting_is_the_same_each_time_and_on_any_number_of_threads() {
    let animal = limbed(true).with_patch(Vec3::NEG_Y, 0.22, 0);
    // The text tells apart all bits of the numbers.
    let text = |threads| on_threads(threads, || format!("{:?}", animal.painting()));
    let first = text(1);
    assert!(first == text(1), "twice on one thread");
    assert!(first == text(2), "on two threads");
    for kind in ["Pale", "Bone", "Spot", "Tuft"] {
        assert!(first.contains(&format!("kind: {kind},")), "no stroke of kind {kind}");
    }
}

#[test]
fn ranks_ascend_from_0_to_1_within_each_kind() {
    let pool = limbed(true).painting();
    for kind in [StrokeKind::Pale, StrokeKind::Tuft] {
        let ranks: Vec<f32> = pool.strokes.iter().filter(|s| s.kind == kind).map(|s| s.rank).collect();
        assert!(ranks.len() > 5 && ranks[0] == 0.0 && ranks[ranks.len() - 1] == 1.0, "{kind:?}: {ranks:?}");
        assert!(ranks.windows(2).all(|pair| pair[0] < pair[1]), "{kind:?}: {ranks:?}");
    }
}

#[test]
fn degenerate_models_are_painted_without_panic() {
    let triangle = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    let all = vec![[0, 1, 2]];
    let without_triangles = Animal::new(triangle.clone(), Vec::new());
    let one = Animal::new(triangle.clone(), all.clone());
    let black = {
        let mut animal = Animal::new(triangle, all.clone());
        animal.colors.vertices = vec![[0, 0, 0, 255]; 3];
        animal
    };
    let point = Animal::new(vec![Vec3::ONE; 3], all.clone());
    let line = Animal::new(vec![Vec3::ZERO, Vec3::X, Vec3::X * 2.0], all);
    for (name, animal) in
        [("none", without_triangles), ("one", one), ("black", black), ("point", point), ("line", line)]
    {
        let pool = animal.painting();
        assert!(pool.size_m > 0.0 && pool.size_m.is_finite(), "{name}: {}", pool.size_m);
        for stroke in &pool.strokes {
            assert!(stroke.points.len() == PaintStroke::POINTS && (0.0..=1.0).contains(&stroke.rank), "{name}");
            for point in &stroke.points {
                assert!(point.half_width_m >= 0.0 && point.half_width_m.is_finite(), "{name}: {point:?}");
                assert!((0.0..=1.0).contains(&point.darkness), "{name}: {point:?}");
                assert!(point.sides.iter().flat_map(|side| side.vertices).all(|v| v < 3), "{name}: {point:?}");
            }
        }
    }
}

#[test]
fn guides_become_locks_that_are_spread_over_the_hair() {
    let mut animal = limbed(false);
    let far_m = animal.bounds.radius;
    // Guides straight away from the surface: all triangles of one side, each with three guides, and one short guide.
    let triangles = &animal.surface.mesh.triangles;
    let root = |triangle: usize, b: f32| TrianglePoint { triangle: triangle as u32, weights: [1.0 - b, b, 0.0] };
    let straight = |length_m: f32| (1..=4).map(|k| Vec3::Z * length_m * k as f32 / 4.0).collect::<Vec<_>>();
    let mut guides: Vec<(TrianglePoint, Vec<Vec3>)> =
        (0..triangles.len() / 2).flat_map(|t| [0.1, 0.5, 0.9].map(|b| (root(t, b), straight(0.3 * far_m)))).collect();
    guides.push((root(0, 0.3), straight(0.001 * far_m)));
    let mut group = HairGroup { root_color: [0; 3], tip_color: [255; 3], ..HairGroup::default() };
    group.set_guides(&guides);
    animal.groups.push(group);
    let pool = animal.painting();
    let locks: Vec<&PaintStroke> = pool.strokes.iter().filter(|s| s.kind == StrokeKind::Lock).collect();
    assert!((8..=32).contains(&locks.len()), "{} locks", locks.len());
    for lock in &locks {
        let [first, last] = [&lock.points[0], &lock.points[PaintStroke::POINTS - 1]];
        let length_m = Vec3::from(last.offset_m.unwrap()).distance(Vec3::from(first.offset_m.unwrap()));
        assert!((length_m / far_m - 0.3).abs() < 1e-3, "{length_m}");
        assert_eq!((first.offset_m, first.darkness, last.darkness), (Some([0.0; 3]), 1.0, 0.0));
        let share = first.half_width_m / pool.size_m;
        assert!((0.003..0.02).contains(&share), "{share}");
    }
    let root = |lock: &PaintStroke| {
        let StrokeAnchor { vertices: [a, b, _], weights } = lock.points[0].sides[0];
        let [a, b] = [a, b].map(|v| animal.surface.mesh.positions[v as usize]);
        a.lerp(b, f32::from(weights[0]) / 65535.0)
    };
    for (i, lock) in locks.iter().enumerate() {
        for other in &locks[..i] {
            assert!(root(lock).distance(root(other)) > 0.01 * pool.size_m, "two locks at one place");
        }
    }
    animal.groups.clear();
    assert!(animal.painting().strokes.iter().all(|s| s.kind != StrokeKind::Lock));
}

#[test]
fn recipe_changes_the_tone_of_strokes() {
    let mut animal = limbed(false);
    let count = animal.surface.mesh.positions.len();
    let mean = |animal: &Animal| {
        let canvas = animal.canvas();
        canvas.darkness.iter().sum::<f32>() / canvas.darkness.len() as f32
    };
    animal.colors.vertices = vec![[60, 60, 60, 255]; count];
    let plain = mean(&animal);
    assert!((0.2..0.95).contains(&plain), "{plain}");
    let ink = |amount, solid| vec![InkVertex { amount, solid, line: 255, ..InkVertex::default() }; count];
    for (amount, solid, expected) in [(255, 0, plain), (0, 0, 0.0), (51, 0, 0.2 * plain), (255, 255, 1.0), (0, 51, 0.2)]
    {
        animal.ink = ink(amount, solid);
        assert!((mean(&animal) - expected).abs() < 1e-3, "{amount} {solid}: {}", mean(&animal));
    }
}
