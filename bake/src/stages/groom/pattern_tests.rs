use super::*;
use crate::recipe::{FilePath, GroomParams, PatternProjection};
use crate::stages::fixtures::{self, part};
use crate::stages::groom::{Maps, Vertices, colors};
use crate::stages::surface::{Source, SurfaceParams, parameterize};
use glam::Vec2;
use pelage_formats::meaning::{linear_to_srgb, srgb_to_linear};
use pelage_import::mesh::{Material, Model};

const SIDE: u32 = 512;

/// Builds a torus about the y axis with radii 0.3 m and 0.12 m, without texture coordinates. It has a bare patch of
/// another material.
fn torus() -> Model {
    let (rings, sides) = (40u32, 20u32);
    let mut mesh = fixtures::torus(rings, sides, false);
    let bare = 2 * sides as usize;
    let total = mesh.triangles.len();
    mesh.parts = vec![part(0, 0, total - bare), part(1, total - bare, bare)];
    let material = |name: &str| Material { name: name.into(), ..Material::default() };
    Model { mesh, materials: vec![material("coat"), material("bare")], ..Model::default() }
}

/// Creates an image that is smooth in both directions, so that neighbouring texels differ little.
fn waves() -> Image {
    let n = 256;
    let wave = |k: u32, times: f32| (times * k as f32 / n as f32 * std::f32::consts::TAU).sin() * 0.5 + 0.5;
    let texel = |x: u32, y: u32| [wave(x, 2.0), wave(y, 3.0), wave(x + y, 1.0)].map(linear_to_srgb);
    let texels = (0..n).flat_map(|y| (0..n).map(move |x| (x, y)));
    let rgba = texels.flat_map(|(x, y)| texel(x, y).into_iter().chain([255])).collect();
    Image { width: n, height: n, rgba }
}

struct Painted {
    surface: Surface,
    colors: Colors,
    atlas: Atlas,
}

const BOUNDS: Bounds = Bounds { min: [-0.42, -0.12, -0.42], max: [0.42, 0.12, 0.42], center: [0.0; 3], radius: 0.42 };

fn params(projection: PatternProjection) -> ColorParams {
    ColorParams { pattern: Some(FilePath("p.png".into())), pattern_projection: projection, ..ColorParams::default() }
}

fn images(image: Image) -> MapImages {
    MapImages { images: [("p.png".to_owned(), image)].into(), ..MapImages::default() }
}

fn paint(model: &Model, pattern: &Pattern<'_>) -> Painted {
    let furred = [true, false];
    let surface_params = SurfaceParams { tile_size_m: 0.1, furred: furred.to_vec(), ..SurfaceParams::default() };
    assert!(matches!(surface_params.source, Source::Patches(_)));
    let mut surface = parameterize("torus", model, &surface_params).unwrap();
    let atlas = Atlas::new(&mut surface, SIDE).unwrap();
    let (groom, none) = (GroomParams::default(), MapImages::default());
    let maps = Maps::new(&surface.mesh, &model.materials, &furred, &groom, &none, &mut Vec::new());
    let mut colors = colors(model, &Vertices::from(&surface), &maps, &furred, true).unwrap();
    pattern.paint(&atlas, &furred, &mut surface, &mut colors, &mut GroomTextures::default());
    Painted { surface, colors, atlas }
}

/// Returns the image at half its size, as mips are made: each texel is the mean of four in linear light.
fn halved(image: &Image) -> Image {
    let (width, height) = (image.width / 2, image.height / 2);
    let texel = |x: u32, y: u32, c: usize| f32::from(image.rgba[4 * (y * image.width + x) as usize + c]);
    let mut rgba = Vec::new();
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        for c in 0..4 {
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| texel(2 * x + dx, 2 * y + dy, c));
            rgba.push(match c {
                3 => (four.iter().sum::<f32>() / 4.0) as u8,
                _ => linear_to_srgb(four.iter().map(|b| srgb_to_linear(*b as u8)).sum::<f32>() / 4.0),
            });
        }
    }
    Image { width, height, rgba }
}

/// Returns the maximum and mean difference between texture and pattern, linear. They are compared at the corners, edge
/// midpoints and interior points of furred triangles.
fn errors(painted: &Painted, pattern: &Pattern<'_>, level: u32) -> (f32, f32) {
    let Painted { surface, colors, .. } = painted;
    let mut image = Image::clone(&colors.images[colors.materials[0].image.unwrap()]);
    (0..level).for_each(|_| image = halved(&image));
    let (mut worst, mut sum, mut count) = (0.0f32, 0.0, 0.0);
    let weights = [[1., 0., 0.], [0., 1., 0.], [0.5, 0.5, 0.], [0., 0.5, 0.5], [0.5, 0., 0.5], [0.2, 0.3, 0.5]];
    let part = &surface.mesh.parts[0];
    for triangle in part.first_triangle..part.first_triangle + part.triangle_count {
        for weights in weights.map(Vec3::from) {
            let spot = SurfacePoint { triangle, weights };
            let normal = spot.interpolate(surface, &surface.rest.normals).normalize();
            let expected = pattern.color(spot.interpolate(surface, &surface.rest.positions), normal);
            let found = sample_model_uvs(surface, spot, &image, Encoding::Srgb).truncate();
            let error = (found - expected).abs().max_element();
            (worst, sum, count) = (worst.max(error), sum + error, count + 1.0);
        }
    }
    assert!(count > 8000.0, "{count}");
    (worst, sum / count)
}

#[test]
fn every_surface_point_shows_the_pattern_at_its_position() {
    let model = torus();
    let images = images(waves());
    for projection in PatternProjection::ALL.iter().copied() {
        let pattern = Pattern::new(&params(projection), &images, &BOUNDS).unwrap().unwrap();
        let painted = paint(&model, &pattern);
        assert_eq!(painted.atlas.gutter, 8, "{projection:?}");
        // Here, a texel is 2 mm wide. Over 2 mm, the waves change by at most 0.03 (period 0.28 m, steeper where box
        // projections blend). The error is slightly larger at the border of a chart. There, the filter reads the
        // gutter, into which the last triangle is extended in a straight line.
        let (worst, mean) = errors(&painted, &pattern, 0);
        assert!(worst < 0.1 && mean < 0.01, "{projection:?}: worst {worst}, mean {mean}");
        // Texels of mip level 2 are four times as wide, so the error is at most four times larger. Other charts and the
        // space between charts have no effect.
        let (worst, mean) = errors(&painted, &pattern, 2);
        assert!(worst < 0.2 && mean < 0.03, "{projection:?} at mip 2: worst {worst}, mean {mean}");
    }
}

#[test]
fn without_gutters_the_charts_bleed() {
    // Control: if everything but the charts' own texels is black, mip level 2 shows black at the borders of the charts.
    let (model, images) = (torus(), images(waves()));
    let pattern = Pattern::new(&params(PatternProjection::X), &images, &BOUNDS).unwrap().unwrap();
    let mut painted = paint(&model, &pattern);
    let image = painted.colors.materials[0].image.unwrap();
    let mut kept = vec![false; (SIDE * SIDE) as usize];
    let corners = |t: &[u32; 3]| t.map(|v| painted.surface.mesh.uvs[v as usize] * SIDE as f32);
    for triangle in &painted.surface.mesh.triangles {
        let center = corners(triangle).iter().sum::<Vec2>() / 3.0;
        kept[(center.y as u32 * SIDE + center.x as u32).min(SIDE * SIDE - 1) as usize] = true;
    }
    let texels = std::sync::Arc::make_mut(&mut painted.colors.images[image]).rgba.chunks_exact_mut(4);
    texels.zip(kept).filter(|(_, kept)| !kept).for_each(|(texel, _)| texel[..3].fill(0));
    assert!(errors(&painted, &pattern, 2).0 > 0.3, "the errors do not see black between charts");
}

#[test]
fn base_colours_and_groom_maps_are_baked_into_the_pattern_texture() {
    let mut model = torus();
    // Texture coordinates follow the position. Right of the origin, the model is red; left of it, the model is bare.
    model.mesh.uvs = model.mesh.positions.iter().map(|p| Vec2::new((p.x / 0.42 + 1.0) / 2.0, 0.5)).collect();
    model.mesh.parts.iter_mut().for_each(|p| p.has_uvs = true);
    let row = |left: [u8; 4], right: [u8; 4]| Image {
        width: 32,
        height: 1,
        rgba: [[left; 16], [right; 16]].concat().concat(),
    };
    model.images =
        [row([255; 4], [255, 0, 0, 255]), row([9, 9, 9, 255], [9, 9, 9, 255])].map(std::sync::Arc::new).to_vec();
    model.materials[0].base_color_image = Some(0);
    model.materials[1].base_color_image = Some(1);
    let images = images(row([255; 4], [255; 4]));
    let pattern = Pattern::new(&params(PatternProjection::Box), &images, &BOUNDS).unwrap().unwrap();

    let furred = [true, false];
    let surface_params = SurfaceParams { tile_size_m: 0.1, furred: furred.to_vec(), ..SurfaceParams::default() };
    let mut surface = parameterize("torus", &model, &surface_params).unwrap();
    let atlas = Atlas::new(&mut surface, SIDE).unwrap();
    let (groom, none) = (GroomParams::default(), MapImages::default());
    let maps = Maps::new(&surface.mesh, &model.materials, &furred, &groom, &none, &mut Vec::new());
    let mut colors = colors(&model, &Vertices::from(&surface), &maps, &furred, true).unwrap();
    let mut grooms =
        GroomTextures { images: vec![row([0, 0, 0, 255], [255, 0, 0, 255])], of_material: vec![Some(0), None] };
    let own = surface.mesh.uvs.clone();
    pattern.paint(&atlas, &furred, &mut surface, &mut colors, &mut grooms);

    assert_eq!(colors.materials.iter().map(|m| m.image).collect::<Vec<_>>(), [Some(1), Some(0)]);
    assert_eq!((colors.images.len(), &colors.images[0]), (2, &model.images[1]), "the bare part keeps its image");
    assert_eq!((grooms.images.len(), &grooms.of_material[..]), (1, &[Some(0), None][..]));
    for part in &surface.mesh.parts {
        for v in surface.mesh.triangles[part.first_triangle..part.first_triangle + part.triangle_count].iter().flatten()
        {
            let (v, x) = (*v as usize, surface.rest.positions[*v as usize].x);
            if part.material == 1 {
                assert_eq!(surface.mesh.uvs[v], own[v]);
            } else if (0.05..0.36).contains(&x.abs()) {
                let at = |image| bilinear(image, surface.mesh.uvs[v], Wrap::Clamp, Encoding::Linear);
                let (color, groom) = (at(&colors.images[1]), at(&grooms.images[0]));
                let right = if x > 0.0 { 1.0 } else { 0.0 };
                assert!((color.y - (1.0 - right)).abs() < 0.02 && color.x > 0.98, "{x}: {color}");
                assert!((groom.x - right).abs() < 0.02 && groom.y == 0.0, "{x}: {groom}");
            }
        }
    }
}

#[test]
fn patterns_are_oriented_as_seen() {
    // The left half is black and the right half is white. The upper row is darker than the lower.
    let image = Image {
        width: 2,
        height: 2,
        rgba: [[0u8; 3], [200; 3], [60; 3], [255; 3]].map(|[r, g, b]| [r, g, b, 255]).concat(),
    };
    let images = images(image);
    let shade = |projection, wrap, p: [f32; 3], n: Vec3| {
        let color = ColorParams { pattern_wrap: wrap, pattern_size_m: Some(1.0), ..params(projection) };
        let pattern = Pattern::new(&color, &images, &Bounds::default()).unwrap().unwrap();
        linear_to_srgb(pattern.color(p.into(), n).x)
    };
    use PatternProjection::{Box, X, Y, Z};
    for (projection, upper_left) in [(X, [9., 0.25, 0.25]), (Y, [-0.25, 9., -0.25]), (Z, [-0.25, 0.25, 9.])] {
        assert_eq!(shade(projection, PatternWrap::Clamp, upper_left, Vec3::X), 0, "{projection:?}");
        let lower_right = upper_left.map(|x| if x == 9. { x } else { -x });
        assert_eq!(shade(projection, PatternWrap::Clamp, lower_right, Vec3::X), 255, "{projection:?}");
    }
    assert_eq!(shade(Z, PatternWrap::Clamp, [3.0, -3.0, 0.0], Vec3::X), 255, "the outermost texel goes on");
    assert_eq!(shade(Z, PatternWrap::Repeat, [0.75, 0.25, 0.0], Vec3::X), 0, "the image starts over");
    assert_eq!(shade(Box, PatternWrap::Clamp, [-0.25, 0.25, 0.3], Vec3::Z), 0, "seen along z");
    assert_eq!(shade(Box, PatternWrap::Clamp, [-0.25, 0.25, 0.3], Vec3::Y), 60, "seen along y");
}
