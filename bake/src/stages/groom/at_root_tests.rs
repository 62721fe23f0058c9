use super::super::colors::MaterialColor;
use super::*;
use crate::sample::{Wrap, bilinear};
use crate::stages::fixtures::{on_threads, part};
use crate::stages::surface::Measures;
use pelage_formats::meaning::srgb_to_linear;
use pelage_import::mesh::{Image, Mesh, RestPose};

const RED: Vec4 = Vec4::new(0.8, 0.1, 0.05, 1.0);
const BLUE: Vec4 = Vec4::new(0.02, 0.05, 0.6, 1.0);
const GREEN: Vec4 = Vec4::new(0.0, 1.0, 0.0, 1.0);
/// Width of the hair tile, metres.
const TILE_M: f32 = 0.25;
/// Mean displacement of hair at the mesh surface, halfway and at the tips, tiles, along +v.
const ASIDES: [Vec2; 3] = [Vec2::ZERO, Vec2::new(0.0, 0.1), Vec2::new(0.0, 0.4)];

/// Builds a strip 1 m wide along z, whose quarter-metre squares have the given materials. +v of the tile runs along +z.
/// Tile coordinates jump at each change of material, and triangles share no vertices, as with flat shading.
fn strip(materials: &[usize]) -> Surface {
    let mut mesh = Mesh::default();
    let (mut tile_uvs, mut patches) = (Vec::new(), Vec::new());
    for (row, material) in materials.iter().enumerate() {
        for column in 0..4 {
            let corner = |dx: usize, dz: usize| Vec3::new((column + dx) as f32, 0.0, (row + dz) as f32) * 0.25;
            for triangle in [[(0, 0), (0, 1), (1, 0)], [(1, 0), (0, 1), (1, 1)]] {
                let first = mesh.positions.len() as u32;
                for (dx, dz) in triangle {
                    let place = corner(dx, dz);
                    mesh.positions.push(place);
                    tile_uvs.push(Vec2::new(place.x, place.z) / TILE_M + 5.0 * *material as f32);
                }
                mesh.triangles.push([first, first + 1, first + 2]);
                patches.push(*material as u32);
            }
        }
        mesh.parts.push(part(*material, 8 * row, 8));
    }
    let n = mesh.positions.len();
    (mesh.normals, mesh.uvs, mesh.colors) = (vec![Vec3::Y; n], vec![Vec2::ZERO; n], vec![[255; 4]; n]);
    Surface {
        rest: RestPose { positions: mesh.positions.clone(), normals: mesh.normals.clone() },
        input_vertex: (0..n as u32).collect(),
        tile_uvs,
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, -1.0); n],
        patch_of_triangle: patches,
        singularities: Vec::new(),
        measures: Measures::default(),
        warnings: Vec::new(),
        mesh,
    }
}

fn colors(surface: &Surface, of_material: &[Vec4]) -> Colors {
    Colors {
        images: Vec::new(),
        materials: of_material.iter().map(|c| MaterialColor { factor: c.to_array(), image: None }).collect(),
        vertices: vec![[255; 4]; surface.mesh.positions.len()],
        hair: Vec::new(),
    }
}

fn rooting(furred: &[bool]) -> RootColorInput<'_> {
    RootColorInput { furred, pattern: None, asides: &ASIDES, reach: 0.5, most_side: 512 }
}

fn at(surface: &Surface, spot: SurfacePoint) -> Vec3 {
    spot.interpolate(surface, &surface.rest.positions)
}

/// Returns the index of the first of the two triangles in the square at that row and column.
fn triangle(row: usize, column: usize) -> usize {
    8 * row + 2 * column
}

#[test]
fn walks_cross_materials_and_stop_at_bare_skin() {
    let surface = strip(&[0, 0, 1, 2]);
    let colors = colors(&surface, &[RED, BLUE, GREEN]);
    let rooting = rooting(&[true, true, false]);
    let ground = WalkInput::new(&surface, rooting.furred);
    let skin = ColoredSurface::new(&surface, &colors, &rooting, &ground);
    let walk = |row, by: [f64; 2]| {
        skin.walk_end(SurfacePoint { triangle: triangle(row, 1), weights: Vec3::splat(1.0 / 3.0) }, by.into())
    };
    let start = at(&surface, walk(1, [0.0, 0.0]));
    // The walk crosses the border of two materials, at which tile coordinates jump.
    let over = walk(1, [0.2, 1.0]);
    assert!(at(&surface, over).distance(start + Vec3::new(0.05, 0.0, 0.25)) < 1e-5, "{over:?}");
    assert_eq!((skin.color(walk(1, [0.0, 0.0])), skin.color(over)), (RED, BLUE));
    // Walks stop at a bare material and at the boundary of the mesh.
    let bare = walk(2, [0.0, 9.0]);
    assert!((at(&surface, bare).z - 0.75).abs() < 1e-5, "{}", at(&surface, bare));
    assert_eq!(skin.color(bare), BLUE);
    let end = walk(1, [0.0, -9.0]);
    assert!(at(&surface, end).z.abs() < 1e-5 && skin.color(end) == RED, "{}", at(&surface, end));
}

#[test]
fn texel_past_a_border_shows_the_adjacent_surface() {
    let surface = strip(&[0, 1]);
    let colors = colors(&surface, &[RED, BLUE]);
    let rooting = rooting(&[true, true]);
    let ground = WalkInput::new(&surface, rooting.furred);
    let skin = ColoredSurface::new(&surface, &colors, &rooting, &ground);
    // The point is 0.1 m beyond the edge of its triangle at z = 0.25, in the plane of the adjacent triangle.
    let beyond = SurfacePoint { triangle: triangle(0, 1), weights: Vec3::new(-0.9, 1.4, 0.5) };
    let place = skin.on_adjacent_surface(beyond);
    assert!(at(&surface, place).distance(at(&surface, beyond)) < 1e-5, "{place:?}");
    assert_eq!((skin.color(beyond), skin.color(place)), (RED, BLUE));
}

#[test]
fn only_hair_over_another_colour_is_painted() {
    let mixed = |materials: &[usize], of_material: &[Vec4], furred: &[bool]| {
        let mut surface = strip(materials);
        let before = surface.mesh.clone();
        let colors = colors(&surface, of_material);
        let atlas = RootAtlas::new(&mut surface, &colors, &rooting(furred));
        assert!(atlas.is_some() || surface.mesh == before, "nothing was painted, and the mesh is another");
        atlas.map(|atlas| atlas.of_material)
    };
    assert_eq!(mixed(&[0, 1], &[RED, RED], &[true; 2]), None);
    assert_eq!(mixed(&[0, 1], &[RED, BLUE], &[true, false]), None, "what is bare has no hair");
    // Hair of material 0 hangs over material 1. Hair of material 1 hangs over material 2, which has the same colour.
    assert_eq!(mixed(&[0, 1, 2], &[RED, BLUE, BLUE], &[true; 3]), Some(vec![false, true, false]));
    assert_eq!(mixed(&[0, 2, 1], &[RED, BLUE, GREEN], &[true, true, false]), None, "bare skin parts them");
    // A difference of one byte does not count as a border.
    assert_eq!(mixed(&[0, 1], &[RED, RED * 1.005], &[true; 2]), None);
}

struct Painted {
    surface: Surface,
    colors: Colors,
    info: RootsInfo,
}

fn paint(materials: &[usize], of_material: &[Vec4], furred: &[bool]) -> Painted {
    let mut surface = strip(materials);
    let rooting = rooting(furred);
    let uncut = colors(&surface, of_material);
    let atlas = RootAtlas::new(&mut surface, &uncut, &rooting).unwrap();
    let mut colors = colors(&surface, of_material);
    let mut grooms = GroomTextures { images: Vec::new(), of_material: vec![None; of_material.len()] };
    atlas.paint(&rooting, &mut surface, &mut colors, &mut grooms);
    assert!(grooms.images.is_empty());
    Painted { info: atlas.info([RootOffset::default(); ROOT_HEIGHTS]), surface, colors }
}

impl Painted {
    fn image(&self, material: usize) -> &Image {
        &self.colors.images[self.colors.materials[material].image.unwrap()]
    }

    /// Returns the base colour of hair that is seen at a point and displaced from its root by `aside`, computed as in
    /// FORMAT.md.
    fn seen(&self, spot: SurfacePoint, aside: Vec2) -> Vec3 {
        let material = material_of_triangles(&self.surface)[spot.triangle];
        let [a, b, c] = self.surface.mesh.triangles[spot.triangle].map(|v| self.surface.mesh.uvs[v as usize]);
        let uv = a * spot.weights.x + b * spot.weights.y + c * spot.weights.z;
        let root = uv - aside * self.info.uv_per_tile[material];
        let own = Vec4::from(self.colors.materials[material].factor);
        (own * bilinear(self.image(material), root, Wrap::Repeat, Encoding::Srgb)).truncate()
    }
}

#[test]
fn hair_has_the_colour_of_its_root() {
    let painted = paint(&[0, 0, 1, 1, 2], &[RED, BLUE, GREEN], &[true, true, false]);
    assert_eq!(painted.info.uv_per_tile[0], 0.0, "no hair of another colour reaches it");
    let surface = &painted.surface;
    for t in (triangle(2, 0)..triangle(4, 0)).filter(|t| surface.patch_of_triangle[*t] == 1) {
        let corners = surface.mesh.triangles[t].map(|v| v as usize);
        let step = |of: &[Vec2]| of[corners[1]] - of[corners[0]];
        let (uv, tile) = (step(&surface.mesh.uvs), step(&surface.tile_uvs));
        assert!(uv.distance(tile * painted.info.uv_per_tile[1]) < 1e-6, "{t}: coordinates do not run as the tile's");
        for spot in sample_points(surface, t) {
            for aside in [0.0, 0.1, 0.25, 0.45] {
                // The border of the colours is at 0.5 m; skip texels that mix both.
                let root_m = at(surface, spot).z - aside * TILE_M;
                let texel_m = TILE_M / (painted.info.uv_per_tile[1] * painted.image(1).width as f32);
                if (root_m - 0.5).abs() < 1.5 * texel_m {
                    continue;
                }
                let expected = if root_m < 0.5 { RED } else { BLUE };
                let found = painted.seen(spot, Vec2::new(0.0, aside));
                assert!(found.distance(expected.truncate()) < 0.01, "{root_m} m: {found}, expected {expected}");
            }
        }
    }
}

#[test]
fn bare_skin_keeps_its_colour_and_colours_no_hair() {
    // Hair of material 1 hangs over material 2; material 0, which is bare, is nearby.
    let painted = paint(&[0, 1, 2], &[GREEN, RED, BLUE], &[false, true, true]);
    assert_eq!(painted.colors.materials[0], MaterialColor { factor: GREEN.to_array(), image: None });
    assert_eq!(painted.colors.materials[2].factor, [1.0; 4]);
    let texels = painted.image(2).rgba.chunks_exact(4).map(|t| [t[0], t[1], t[2]].map(srgb_to_linear));
    let green = texels.filter(|t| t[1] > 0.2).count();
    assert_eq!(green, 0, "texels of bare skin");
    let start = SurfacePoint { triangle: triangle(2, 1), weights: Vec3::splat(1.0 / 3.0) };
    assert!(painted.seen(start, Vec2::new(0.0, 0.45)).distance(RED.truncate()) < 0.01);
}

#[test]
fn root_colours_do_not_depend_on_thread_count() {
    let on = |threads| {
        let painted = on_threads(threads, || paint(&[0, 1, 0, 1], &[RED, BLUE], &[true; 2]));
        (painted.image(1).clone(), painted.surface.mesh, painted.info)
    };
    let (one, four) = (on(1), on(4));
    assert!(one.0.rgba == four.0.rgba && one.1 == four.1 && one.2 == four.2);
}
