//! Contours that are painted as strokes. Lines along the edges between front and back faces, the naive form, break up
//! on noisy surfaces and miss open boundaries. Lines found in pixels, the form of Fang 2006, thicken where a surface is
//! seen edge on, keep their width at any distance, and take their noise from the picture.

use super::row::{DrawCallback, Drawing, DrawnRowTest, Finding, Row};
use super::{silhouette, surface};
use crate::mask::Mask;
use glam::{Mat4, Vec2, Vec3, vec3};
use pelage_bake::noise::uniform;
use pelage_bake::recipe::Recipe;
use pelage_bake::strands::PosedMesh;
use pelage_formats::{Limits, Package};
use pelage_import::BakeError;
use pelage_import::mesh::Model;
use pelage_runtime::{BrushParams, Camera, FrameParams, InkLines, InkParams, LineWidth, PassId, Projection};
use pelage_truth::{Lens, SurfaceVisibility, TrueCamera};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Row of the stability table.
pub const ROW: Row<DrawnRowTest> = Row {
    method: "painted strokes",
    cliff: "flat, noisy, open, mirrored or cut off surfaces, very near or far",
    naive: "lines along edges between front and back faces, or found in pixels",
    safe: "contours of smooth normals, linked into strokes",
    drive,
};

/// Size of the pictures, pixels.
const SIZE: (u32, u32) = (300, 300);
const FOV_Y_RAD: f32 = 0.5;
/// Optical density from which a pixel is ink.
const INK: f64 = 0.3;
/// Distance from the outline up to which ink belongs to it, pixels.
const NEAR_PX: f64 = 8.0;
/// Share of the outline up to which it may have no line where the width of lines is measured.
const MOST_BARE: f64 = 0.05;

type Found<T> = Result<T, BakeError>;

/// Returns ink of lines alone, all of the contour, on smooth paper. Lines are as wet at their ends as in the middle, so
/// that they have no gaps by design.
fn lines_alone() -> InkParams {
    InkParams::default().with(|ink| {
        ink.paper_grain = 0.0;
        ink.brush = BrushParams::default().with(|brush| {
            (brush.wash, brush.tufts, brush.ground, brush.omission, brush.dryness) = (0.0, 0.0, 0.0, 0.0, 0.0);
        });
    })
}

/// Returns the same with lines found in pixels.
fn pixel_lines() -> InkParams {
    lines_alone().with(|ink| {
        ink.lines = InkLines::Pixels;
        (ink.roughness_px, ink.dryness) = (0.0, 0.0);
    })
}

/// Package of a bare model, and its model.
struct Subject {
    model: Model,
    package: Vec<u8>,
}

impl Subject {
    fn new(name: &str, model: Model) -> Found<Self> {
        let mut recipe = Recipe::default();
        recipe.set("model.bare=[\"*\"]")?;
        let package = silhouette::bake(name, &model, &recipe)?;
        Ok(Self { model, package })
    }

    /// Returns the densities of a picture.
    fn densities(&self, draw: &mut DrawCallback<'_>, params: &FrameParams, at: Mat4) -> Found<Vec<f64>> {
        let strokes = params.style.ink().is_some_and(|ink| ink.lines == InkLines::Strokes);
        let passes = [if strokes { PassId::PAINTING_SHEET } else { PassId::INK_COMPOSITE }];
        let texels = draw(&Drawing { package: &self.package, params, size: SIZE, passes: &passes, at })?;
        let paper = params.style.ink().map_or(1.0, |ink| ink.paper.x);
        let density = |t: &[f32; 4]| f64::from(-libm::logf((t[0] / paper).clamp(1e-3, 1.0)));
        if let Some(texel) = texels.iter().find(|t| t.iter().any(|x| !x.is_finite())) {
            return Err(BakeError::Internal(format!("found the texel {texel:?}, expected finite numbers")));
        }
        Ok(texels.iter().map(density).collect())
    }

    /// Returns the pixels with ink.
    fn ink(&self, draw: &mut DrawCallback<'_>, camera: Camera, ink: InkParams) -> Found<Mask> {
        let params = FrameParams::new(camera, SIZE.into()).with_ink(ink);
        Ok(mask(self.densities(draw, &params, Mat4::IDENTITY)?.into_iter().map(|density| density >= INK).collect()))
    }

    /// Returns the pixels of the surface.
    fn body(&self, draw: &mut DrawCallback<'_>, camera: Camera) -> Found<Mask> {
        let params = FrameParams::new(camera, SIZE.into());
        let passes = [PassId::SKIN];
        let drawing =
            Drawing { package: &self.package, params: &params, size: SIZE, passes: &passes, at: Mat4::IDENTITY };
        Ok(mask(draw(&drawing)?.iter().map(|texel| texel[3] > 0.5).collect()))
    }

    /// Returns the naive lines: visible edges of two triangles, of which one faces the eye.
    fn edges(&self, camera: &Camera) -> Found<Mask> {
        let mesh = &self.model.mesh;
        let package = Package::open(&self.package, &Limits::default())
            .map_err(|e| BakeError::Internal(format!("cannot read back the baked package: {e}")))?;
        let sight = SurfaceVisibility::new(PosedMesh::posed("naive", &package, &[])?)?;
        let lens = Lens::Perspective { fov_y_rad: FOV_Y_RAD };
        let seen = sight.view(&TrueCamera::from_view(camera.view_from_world, lens), SIZE);
        let eye = camera.view_from_world.inverse().w_axis.truncate();
        let mut faces: BTreeMap<[u32; 2], Vec<bool>> = BTreeMap::new();
        for [a, b, c] in &mesh.triangles {
            let [p, q, r] = [a, b, c].map(|v| mesh.positions[*v as usize]);
            let faces_eye = (q - p).cross(r - p).dot(eye - p) > 0.0;
            for [from, to] in [[a, b], [b, c], [c, a]] {
                faces.entry([*from.min(to), *from.max(to)]).or_default().push(faces_eye);
            }
        }
        let mut mask = Mask::empty(SIZE.0, SIZE.1);
        for ([a, b], _) in faces.iter().filter(|(_, of)| of.len() == 2 && of[0] != of[1]) {
            let ends = [a, b].map(|v| mesh.positions[*v as usize]);
            if !seen.is_visible(((ends[0] + ends[1]) / 2.0).as_dvec3(), 1e-3) {
                continue;
            }
            let [a, b] = ends.map(|p| on_picture(camera, p));
            let parts = a.distance(b).ceil().max(1.0) as u32;
            for k in 0..=parts {
                let p = a.lerp(b, k as f32 / parts as f32).floor();
                mask.insert(p.x as i64, p.y as i64);
            }
        }
        Ok(mask)
    }

    /// Returns the widest line in default widths, and the share of the outline without one.
    fn widest(&self, draw: &mut DrawCallback<'_>, camera: Camera, ink: InkParams) -> Found<[f64; 2]> {
        let body = self.body(draw, camera)?;
        let params = FrameParams::new(camera, SIZE.into()).with_ink(ink).with(|p| p.study.template = false);
        let lines = mask(self.densities(draw, &params, Mat4::IDENTITY)?.iter().map(|d| *d >= INK).collect());
        let widest = lines.widest_stroke().width_px / f64::from(InkParams::default_width_px(SIZE.1));
        Ok([widest, bare_outline(&body, &lines)])
    }
}

/// Returns the widest line, which is infinitely wide if a part of the outline has none: no ink is not a thin line.
fn wide([widest, bare]: [f64; 2]) -> f64 {
    if bare > MOST_BARE { f64::INFINITY } else { widest }
}

fn mask(pixels: Vec<bool>) -> Mask {
    Mask { width: SIZE.0, height: SIZE.1, pixels }
}

fn on_picture(camera: &Camera, p: Vec3) -> Vec2 {
    let clip_from_world = camera.projection.clip_from_view(false) * camera.view_from_world;
    let ndc = clip_from_world.project_point3(p);
    (Vec2::new(ndc.x, -ndc.y) * 0.5 + 0.5) * Vec2::new(SIZE.0 as f32, SIZE.1 as f32)
}

fn seen_from(towards: Vec3, radius: f32) -> Camera {
    Camera::framing(Vec3::ZERO, radius, towards, FOV_Y_RAD, 1.0)
}

/// Returns a flat rectangle around the origin, across x and y.
fn sheet(quads: u32) -> Model {
    let at = |i: u32, j: u32| i * (quads + 1) + j;
    let place = |k: u32| k as f32 / quads as f32 - 0.5;
    let grid = (0..=quads).flat_map(|i| (0..=quads).map(move |j| (i, j)));
    let quad =
        |i: u32, j: u32| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
    surface::model(
        grid.map(|(i, j)| vec3(place(i), place(j), 0.0)).collect(),
        (0..quads).flat_map(|i| (0..quads).flat_map(move |j| quad(i, j))).collect(),
    )
}

/// Returns a ball with a thick bend.
fn bent() -> Model {
    let ball = surface::sphere(40, 60).mesh;
    let bend = |p: &Vec3| vec3(0.5 * p.x + 0.5 * p.y * p.y - 0.2, p.y, 0.5 * p.z);
    surface::model(ball.positions.iter().map(bend).collect(), ball.triangles)
}

/// Returns a model of dark colour.
fn dark(mut model: Model) -> Model {
    model.mesh.colors.fill([70, 70, 70, 255]);
    model
}

fn mean(densities: &[f64], body: &Mask) -> f64 {
    let of_body = densities.iter().zip(&body.pixels).filter(|(_, is_body)| **is_body).map(|(density, _)| *density);
    of_body.sum::<f64>() / body.count().max(1) as f64
}

/// Returns the share of the body's outline that has no line within [`NEAR_PX`]. The border of the picture is not an
/// outline of a body that crosses it.
fn bare_outline(body: &Mask, lines: &Mask) -> f64 {
    let far = lines.distances();
    let in_picture = |x: i64, y: i64| (0..i64::from(SIZE.0)).contains(&x) && (0..i64::from(SIZE.1)).contains(&y);
    let inside = |x: i64, y: i64| body.contains(x, y) || !in_picture(x, y);
    let is_border = |i: usize| {
        let (x, y) = ((i % SIZE.0 as usize) as i64, (i / SIZE.0 as usize) as i64);
        inside(x, y) && !(inside(x + 1, y) && inside(x - 1, y) && inside(x, y + 1) && inside(x, y - 1))
    };
    let border: Vec<usize> = (0..body.pixels.len()).filter(|i| is_border(*i)).collect();
    border.iter().filter(|i| far[**i] > NEAR_PX).count() as f64 / border.len().max(1) as f64
}

/// Returns the share of the ink that is inside the body, farther than [`NEAR_PX`] from its outline.
fn ink_within(body: &Mask, lines: &Mask) -> f64 {
    let outside = Mask { pixels: body.pixels.iter().map(|p| !p).collect(), ..*body }.distances();
    let within = (0..lines.pixels.len()).filter(|i| lines.pixels[*i] && outside[*i] > NEAR_PX).count();
    within as f64 / lines.count().max(1) as f64
}

fn drive(draw: &mut DrawCallback<'_>) -> Found<Vec<Finding>> {
    Ok(vec![
        card(draw)?,
        noisy(draw)?,
        open(draw, "an open sheet", sheet(20))?,
        open(draw, "one triangle", one_triangle())?,
        cut_off(draw)?,
        far(draw)?,
        near(draw)?,
        mirrored(draw)?,
    ])
}

fn one_triangle() -> Model {
    surface::model(vec![vec3(-0.6, -0.4, 0.0), vec3(0.6, -0.4, 0.0), vec3(0.0, 0.6, 0.0)], vec![[0, 1, 2]])
}

/// Angles between the eye and a card, degrees.
const CARD_DEG: [f32; 6] = [0.0, 0.5, 1.0, 2.0, 3.0, 4.0];

fn card(draw: &mut DrawCallback<'_>) -> Found<Finding> {
    let subject = Subject::new("card", sheet(40))?;
    let mut most = [0.0_f64; 2];
    for degrees in CARD_DEG {
        let angle = degrees.to_radians();
        let camera = seen_from(vec3(angle.cos(), 0.0, angle.sin()), 0.7);
        for (most, ink) in most.iter_mut().zip([pixel_lines(), lines_alone()]) {
            *most = most.max(wide(subject.widest(draw, camera, ink)?));
        }
    }
    Ok(Finding {
        case: "a flat card, edge on and up to 4 degrees from it".into(),
        measure: "widest line, in default widths",
        naive: most[0],
        safe: most[1],
        bound: 1.25,
        fails_above: 2.0,
    })
}

/// Noise of a scan over the distance between its vertices. At 1.2, a share of 0.44 of our lines is inside the outline.
/// All of it is creases: noise makes angles above 60° between faces. Contours of smooth normals have no line there.
const NOISE: f32 = 0.75;

fn noisy(draw: &mut DrawCallback<'_>) -> Found<Finding> {
    let ball = surface::sphere(186, 190).mesh;
    let step = std::f32::consts::PI / 186.0;
    let moved = |(i, p): (usize, &Vec3)| *p * (1.0 + NOISE * step * (uniform(7, i as u64) - 0.5));
    let positions = ball.positions.iter().enumerate().map(moved).collect();
    let triangles = ball.triangles.len();
    let subject = Subject::new("scan", surface::model(positions, ball.triangles))?;
    let camera = seen_from(vec3(0.3, 0.2, 1.0), 1.2);
    let body = subject.body(draw, camera)?;
    let lines = subject.ink(draw, camera, lines_alone())?;
    let edges = subject.edges(&camera)?;
    Ok(Finding {
        case: format!("a ball of {triangles} noisy triangles"),
        measure: "share of the lines inside the outline, and of the outline without a line",
        naive: ink_within(&body, &edges) + bare_outline(&body, &edges),
        safe: ink_within(&body, &lines) + bare_outline(&body, &lines),
        bound: 0.05,
        fails_above: 0.12,
    })
}

fn open(draw: &mut DrawCallback<'_>, case: &str, model: Model) -> Found<Finding> {
    let subject = Subject::new("open", model)?;
    let camera = seen_from(vec3(0.3, 0.2, 1.0), 0.8);
    let body = subject.body(draw, camera)?;
    let lines = subject.ink(draw, camera, lines_alone())?;
    Ok(Finding {
        case: case.into(),
        measure: "share of the outline without a line, and of the lines inside it",
        naive: bare_outline(&body, &subject.edges(&camera)?),
        safe: bare_outline(&body, &lines) + ink_within(&body, &lines),
        bound: 0.05,
        fails_above: 0.9,
    })
}

/// Shift of a picture whose animal crosses the border, pixels.
const SHIFT_PX: u32 = 150;
/// Columns at the border that are not compared: there, the cut model has an edge of its own.
const AT_BORDER_PX: usize = 12;
/// Mean densities of a picture with thin lines, neither paper nor black.
const LINES: RangeInclusive<f64> = 0.005..=0.1;

fn cut_off(draw: &mut DrawCallback<'_>) -> Found<Finding> {
    let height_m = 2.4;
    let metres = |px: f32| px * height_m / SIZE.1 as f32;
    let parallel = Projection::Orthographic { height_m, aspect: 1.0, near_m: 0.1, far_m: 10.0 };
    let subject = Subject::new("crossing", bent())?;
    // The naive form knows only what is in the picture, whose right border is here.
    let border = metres(0.5 * SIZE.0 as f32 - SHIFT_PX as f32);
    let mut visible = bent();
    let of = &mut visible.mesh;
    of.triangles.retain(|t| t.iter().all(|v| of.positions[*v as usize].x < border));
    let visible = Subject::new("cut", surface::model(visible.mesh.positions, visible.mesh.triangles))?;
    let mut picture = |subject: &Subject, shift_px: u32| {
        let aside = Vec3::X * metres(shift_px as f32);
        let camera = Camera::look_at(vec3(0.0, 0.0, 5.0) - aside, -aside, parallel);
        // The relief of the paper moves along.
        let ink = lines_alone().with(|ink| ink.paper_period_px = SHIFT_PX as f32);
        subject.densities(draw, &FrameParams::new(camera, SIZE.into()).with_ink(ink), Mat4::IDENTITY)
    };
    let [whole, cut, naive] = [picture(&subject, 0)?, picture(&subject, SHIFT_PX)?, picture(&visible, SHIFT_PX)?];
    let (width, shift) = (SIZE.0 as usize, SHIFT_PX as usize);
    let compared = || (0..whole.len()).filter(|i| i % width + shift + AT_BORDER_PX < width);
    let all: f64 = compared().map(|i| whole[i]).sum();
    let drawn = all / compared().count() as f64;
    if !LINES.contains(&drawn) {
        return Err(BakeError::Internal(format!("found the density {drawn} of lines, expected {LINES:?}")));
    }
    let change = |of: &[f64]| compared().map(|i| (whole[i] - of[i + shift]).abs()).sum::<f64>() / all;
    Ok(Finding {
        case: "a body that crosses the border; naive: lines of the part in the picture".into(),
        measure: "change of the part in the picture, over its density",
        naive: change(&naive),
        safe: change(&cut),
        bound: 0.1,
        fails_above: 0.2,
    })
}

/// Densities of a body that is neither paper nor black throughout.
const TONES: RangeInclusive<f64> = 0.1..=2.0;

/// Distance of a far body, over that at which it fills the picture.
const FAR: f32 = 20.0;

fn far(draw: &mut DrawCallback<'_>) -> Found<Finding> {
    let subject = Subject::new("far", dark(bent()))?;
    let mut tone = |ink: InkParams, distance: f32| {
        let camera = seen_from(vec3(0.3, 0.2, 1.0), 1.2 * distance);
        let body = subject.body(draw, camera)?;
        let params = FrameParams::new(camera, SIZE.into()).with_ink(ink);
        let densities = subject.densities(draw, &params, Mat4::IDENTITY)?;
        Ok::<_, BakeError>((mean(&densities, &body), body.count()))
    };
    let mut change = |ink: InkParams| {
        let [(near, _), (far, pixels)] = [tone(ink.clone(), 1.0)?, tone(ink, FAR)?];
        if !TONES.contains(&near) {
            return Err(BakeError::Internal(format!("found the density {near} of a body, expected {TONES:?}")));
        }
        Ok::<_, BakeError>(((far / near - 1.0).abs(), pixels))
    };
    let (naive, pixels) = change(pixel_lines().with(|ink| ink.width = LineWidth::Pixels(9.0)))?;
    let (safe, _) = change(InkParams::default())?;
    Ok(Finding {
        case: format!("a dark body of {pixels} pixels"),
        measure: "change of its mean density, over that of a near body",
        naive,
        safe,
        bound: 0.15,
        fails_above: 1.0,
    })
}

fn near(draw: &mut DrawCallback<'_>) -> Found<Finding> {
    let subject = Subject::new("near", surface::torus())?;
    // The camera is at the hole's rim and looks along the tube.
    let (eye, target) = (vec3(0.0, 0.15, 0.45), vec3(0.9, 0.3, -0.4));
    let far = Projection::Perspective { fov_y_rad: 0.9, aspect: 1.0, near_m: 0.01, far_m: 10.0 };
    let camera = Camera::look_at(eye, target, far);
    Ok(Finding {
        case: "a ring with the camera in its hole".into(),
        measure: "widest line, in default widths",
        naive: wide(subject.widest(draw, camera, pixel_lines().with(|ink| ink.width = LineWidth::Metres(0.05)))?),
        safe: wide(subject.widest(draw, camera, lines_alone())?),
        // Two lines may meet.
        bound: 2.0,
        fails_above: 4.0,
    })
}

fn mirrored(draw: &mut DrawCallback<'_>) -> Found<Finding> {
    let ball = || dark(surface::sphere(40, 60));
    let subject = Subject::new("mirrored", ball())?;
    // A renderer that keeps the winding of a mirrored instance draws its inside.
    let mut inside_out = ball();
    inside_out.mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    inside_out.mesh.normals.iter_mut().for_each(|n| *n = -*n);
    let inside_out = Subject::new("inside out", inside_out)?;
    let camera = seen_from(vec3(0.0, 0.1, 1.0), 1.2);
    let body = subject.body(draw, camera)?;
    let painted = FrameParams::new(camera, SIZE.into()).with_ink(InkParams::default());
    let plain = mean(&subject.densities(draw, &painted, Mat4::IDENTITY)?, &body);
    if !TONES.contains(&plain) {
        return Err(BakeError::Internal(format!("found the density {plain} of a ball, expected {TONES:?}")));
    }
    let change = |found: f64| (found / plain - 1.0).abs();
    // The light stays on the left, so that other strokes are in shadow: with it on the right, the change is 0.012.
    let flipped = Mat4::from_scale(vec3(-1.0, 1.0, 1.0));
    Ok(Finding {
        case: "a dark ball, mirrored".into(),
        measure: "change of its mean density",
        naive: change(mean(&inside_out.densities(draw, &painted, Mat4::IDENTITY)?, &body)),
        safe: change(mean(&subject.densities(draw, &painted, flipped)?, &body)),
        bound: 0.15,
        fails_above: 0.3,
    })
}
