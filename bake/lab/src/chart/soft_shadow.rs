//! Topic `soft-shadow`: accuracy and cost of the shadow-width map, compared with the soft shadow of a disc light.
//!
//! Points are distributed uniformly over the parts of the model's surface at rest that face the light, under lights
//! from several sides. The maps are the runtime's own, rendered by the adapter and read back. The truth is the fraction
//! of a disc light visible from each point, computed by [`Occluder`].

use super::errors::Errors;
use super::light_maps::LightMaps;
use super::{Cell, Panel};
use crate::stability::soft_shadow::printed_attenuation;
use crate::truth::{DiscLight, Occluder};
use glam::{Vec3, Vec4};
use pelage_bake::noise::uniform;
use pelage_import::BakeError;
use pelage_import::mesh::{Model, RestPose};
use pelage_runtime::shared::layer_shadow::slanted_path;
use pelage_runtime::shared::soft_shadow::{depth_bias, inner_attenuation};
use pelage_runtime::{PenumbraForm, ShadowParams, Study};
use rayon::prelude::*;

/// Number of points on the mesh surface. Under each light, points that face away from it are excluded.
const POINTS: u32 = 4000;
/// Number of rays from each point to the disc.
const RAYS: u32 = 256;
/// Cosine between light and normal below which a point is excluded. There, light contributes little, and facets of the
/// mesh dominate the error.
const LEAST_N_DOT_L: f32 = 0.1;
/// Directions towards lights: elevation above the horizon and azimuth around the vertical, degrees.
const LIGHTS_DEG: [(f32, f32); 6] =
    [(35.0, 20.0), (60.0, 80.0), (35.0, 140.0), (60.0, 200.0), (35.0, 260.0), (60.0, 320.0)];
/// Visible fractions of the light between which a point is in the penumbra.
const PENUMBRA: [f64; 2] = [0.05, 0.95];
/// Visible fraction of the light up to which a point is in the umbra.
const UMBRA: f64 = 0.02;
/// Visible fraction of the light from which a point is fully lit.
const LIT: f64 = 0.999;

/// Method of computing an attenuation from the maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Published form of Yang 2006, §4 and §5, with the map of that paper.
    Printed,
    /// Numerically safe variant of `Printed`, with the penumbra inside the hard edge ([`PenumbraForm::Inner`]).
    Inner,
    /// Form with the penumbra on both sides of the hard edge ([`PenumbraForm::Centred`]).
    Centred,
    /// Distance to the edge, propagated over the map in the given number of passes (Kirsch and Döllner 2003).
    Iterated(u32),
}

impl Method {
    /// Returns the name of the method in the table.
    pub fn word(self) -> &'static str {
        match self {
            Self::Printed => "printed",
            Self::Inner => "inner",
            Self::Centred => "centred",
            Self::Iterated(_) => "iterated distance",
        }
    }
}

/// Soft shadow method and settings to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct SoftShadowConfiguration {
    /// Name of the varied setting.
    pub series: &'static str,
    /// Short value of the varied setting.
    pub label: String,
    /// Method of computing the attenuation from the maps.
    pub method: Method,
    /// Shadow settings of the runtime.
    pub shadows: ShadowParams,
}

/// Columns of the chart.
pub const COLUMNS: [&str; 13] = [
    "method",
    "map_size",
    "shrink",
    "passes",
    "penumbra",
    "rmse",
    "mean_error",
    "off_by_0.1",
    "rmse_in_shadow",
    "leak_in_umbra",
    "penumbra_ratio",
    "milliseconds",
    "timing",
];

/// Panels of the chart.
pub const PANELS: [Panel; 2] = [
    Panel {
        cost: "milliseconds",
        cost_label: "drawing the maps, milliseconds",
        error: "rmse",
        error_label: "RMSE of the visible fraction of the light, all points",
        only: None,
    },
    Panel {
        cost: "milliseconds",
        cost_label: "drawing the maps, milliseconds",
        error: "rmse_in_shadow",
        error_label: "RMSE of the visible fraction of the light, points not in full light",
        only: None,
    },
];

/// Lists what to measure, the runtime's default first.
pub fn configurations() -> Vec<SoftShadowConfiguration> {
    let base = ShadowParams::default();
    let mut out = vec![SoftShadowConfiguration {
        series: "as the runtime does",
        label: String::new(),
        method: Method::Centred,
        shadows: base,
    }];
    let mut add = |series, label: String, method: Method, shadows: ShadowParams| {
        if !out.iter().any(|c: &SoftShadowConfiguration| c.shadows == shadows && c.method == method) {
            out.push(SoftShadowConfiguration { series, label, method, shadows });
        }
    };
    for map_size in [128, 256, 1024] {
        add("map size", format!("{map_size}²"), Method::Centred, base.with(|s| s.map_size = map_size));
    }
    for shrink in [2, 4, 8, 16, 32] {
        add("shrink", format!("1/{shrink}"), Method::Centred, base.with(|s| s.shrink = shrink));
    }
    for penumbra in [0.03, 0.3] {
        add("penumbra", penumbra.to_string(), Method::Centred, base.with(|s| s.penumbra = penumbra));
    }
    for (map_size, shrink) in [(256, 4), (512, 4), (512, 8), (1024, 16)] {
        add(
            "inner penumbra",
            format!("{map_size}², 1/{shrink}"),
            Method::Inner,
            base.with(|s| (s.map_size, s.shrink) = (map_size, shrink)),
        );
    }
    for (map_size, shrink) in [(256, 4), (512, 4), (512, 8), (1024, 4)] {
        add(
            "as published",
            format!("{map_size}², 1/{shrink}"),
            Method::Printed,
            base.with(|s| (s.map_size, s.shrink) = (map_size, shrink)),
        );
    }
    for passes in [4, 8, 16, 32] {
        add("iterated distance", passes.to_string(), Method::Iterated(passes), base);
    }
    out
}

/// Returns the settings with which the runtime renders the maps of a configuration.
pub fn runtime_settings(configuration: &SoftShadowConfiguration) -> (ShadowParams, Study) {
    let inner = configuration.method != Method::Centred;
    let penumbra = if inner { PenumbraForm::Inner } else { PenumbraForm::Centred };
    (configuration.shadows, Study::default().with(|study| study.penumbra = penumbra))
}

/// Returns unit directions towards the lights, in world space.
pub fn lights() -> Vec<Vec3> {
    let towards = |(up, about): (f32, f32)| {
        let (up, about) = (up.to_radians().sin_cos(), about.to_radians().sin_cos());
        Vec3::new(up.1 * about.0, up.0, up.1 * about.1)
    };
    LIGHTS_DEG.into_iter().map(towards).collect()
}

/// Mesh surface of a model at rest, with points on it.
pub struct SampledSurface {
    occluder: Occluder,
    points: Vec<Point>,
}

/// Point of the mesh surface.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Point {
    position_ws: Vec3,
    /// Normal interpolated between the vertices, as in the runtime's shading.
    normal_ws: Vec3,
    /// Normal of the triangle.
    face_ws: Vec3,
}

impl SampledSurface {
    /// Spreads points over the surface of `model` with uniform density.
    ///
    /// # Errors
    ///
    /// Same as [`Occluder::new`].
    pub fn new(model: &Model) -> Result<Self, BakeError> {
        let rest = RestPose::of(&model.mesh, model.animation.as_ref());
        let triangles = &model.mesh.triangles;
        let occluder = Occluder::new(&rest.positions, triangles)?;
        let mut points = spread(&rest, triangles, POINTS);
        points.retain(|p| !is_buried(&occluder, p));
        Ok(Self { occluder, points })
    }

    fn facing(&self, towards_light: Vec3) -> impl Iterator<Item = &Point> {
        let faces = move |normal: Vec3| normal.dot(towards_light) > LEAST_N_DOT_L;
        self.points.iter().filter(move |p| faces(p.normal_ws) && faces(p.face_ws))
    }

    /// Returns the visible fraction of the light's disc at each point that faces the light, 0..=1. `penumbra` is as in
    /// [`ShadowParams::penumbra`].
    pub fn truth(&self, towards_light: Vec3, penumbra: f32) -> Vec<f64> {
        let light =
            DiscLight::Directional { towards_light_ws: towards_light.as_dvec3(), penumbra: f64::from(penumbra) };
        let points: Vec<&Point> = self.facing(towards_light).collect();
        let share =
            |p: &&Point| self.occluder.visible_share(p.position_ws.as_dvec3(), p.face_ws.as_dvec3(), &light, RAYS);
        points.par_iter().map(share).collect()
    }

    /// Returns the visible fractions at the same points as computed by a method from the runtime's maps. `shrink` is
    /// the factor by which these maps were reduced.
    pub fn by_method(&self, maps: &LightMaps, towards_light: Vec3, method: Method, shrink: u32) -> Vec<f64> {
        // The runtime no longer makes the maps that the other methods need, so they are computed here from its depth
        // maps.
        let size = maps.size as usize;
        let blurred = if method == Method::Printed { paper_width(&occlusion(maps), size, shrink) } else { Vec::new() };
        let distances = if let Method::Iterated(passes) = method {
            iterated_distances(&occlusion(maps), size, passes)
        } else {
            Vec::new()
        };
        let share = |p: &Point| {
            let (place, n_dot_l) = (maps.project(p.position_ws), p.normal_ws.dot(towards_light));
            let sd = (place.z - maps.bilinear(&maps.depths[0], place)) * maps.soft.range_m;
            match method {
                Method::Iterated(passes) => return iterated(maps, &distances, passes, place, sd, n_dot_l),
                Method::Printed => {
                    let sw = maps.bilinear(&blurred, place) * maps.soft.blur * place.w;
                    return printed_attenuation(sd, sw, 1.0 / maps.soft.penumbra);
                }
                Method::Inner | Method::Centred => {}
            }
            maps.light_past_objects(place, n_dot_l, method == Method::Centred)
        };
        self.facing(towards_light).map(|p| f64::from(share(p))).collect()
    }
}

/// Returns true if nothing is visible from a point, because it is on a surface inside another one, such as the back of
/// an eye.
fn is_buried(occluder: &Occluder, p: &Point) -> bool {
    // The light is a disc about the normal that fills the sky down to 14 degrees above the tangent plane.
    let (position, normal) = (p.position_ws.as_dvec3(), p.face_ws.as_dvec3());
    let sky = DiscLight::Directional { towards_light_ws: normal, penumbra: 8.0 };
    occluder.visible_share(position, normal, &sky, 256) == 0.0
}

/// Distributes `count` points over triangles: the surface is divided into `count` consecutive pieces of equal area,
/// with one point in each.
fn spread(rest: &RestPose, triangles: &[[u32; 3]], count: u32) -> Vec<Point> {
    let corners = |t: &[u32; 3]| t.map(|i| rest.positions[i as usize]);
    let area = |t: &[u32; 3]| {
        let [a, b, c] = corners(t);
        f64::from((b - a).cross(c - a).length())
    };
    let total: f64 = triangles.iter().map(area).sum();
    let mut points = Vec::new();
    let (mut before, mut next) = (0.0, 0);
    for t in triangles {
        before += area(t);
        let [a, b, c] = corners(t);
        while next < count && (f64::from(next) + 0.5) * total <= before * f64::from(count) {
            let [x, y] = [0, 1].map(|n| uniform(u64::from(next), n));
            // Folds the unit square into a triangle.
            let (x, y) = if x + y > 1.0 { (1.0 - x, 1.0 - y) } else { (x, y) };
            let normal = |i: usize| rest.normals[t[i] as usize];
            points.push(Point {
                position_ws: a + (b - a) * x + (c - a) * y,
                normal_ws: (normal(0) * (1.0 - x - y) + normal(1) * x + normal(2) * y).normalize_or_zero(),
                face_ws: (b - a).cross(c - a).normalize_or_zero(),
            });
            next += 1;
        }
    }
    points
}

/// Returns the paper's occlusion map: true where the farthest surface facing the light is behind the nearest one.
fn occlusion(maps: &LightMaps) -> Vec<bool> {
    // The threshold is the smallest gap between surfaces in the runtime's filter. Its unit is rendered depth, which is
    // linear for distant lights.
    maps.depths[0].iter().zip(&maps.depths[1]).map(|(near, far)| far - near > 1e-3).collect()
}

/// Returns the distance of each shadowed texel from the shadow's edge, in texels and at most `passes`; 0 for lit
/// texels. In each pass, a texel takes the least sum of a neighbour's distance and the step to that neighbour (Kirsch
/// and Döllner 2003).
fn iterated_distances(occluded: &[bool], size: usize, passes: u32) -> Vec<f32> {
    let mut distances: Vec<f32> = occluded.iter().map(|o| if *o { passes as f32 } else { 0.0 }).collect();
    for _ in 0..passes {
        let before = distances.clone();
        distances.par_chunks_mut(size).enumerate().for_each(|(y, row)| {
            for (x, distance) in row.iter_mut().enumerate() {
                for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)] {
                    let neighbour = |x: usize, d: isize| x.checked_add_signed(d).filter(|x| *x < size);
                    let (Some(x), Some(y)) = (neighbour(x, dx), neighbour(y, dy)) else { continue };
                    let way = if dx != 0 && dy != 0 { std::f32::consts::SQRT_2 } else { 1.0 };
                    *distance = distance.min(before[y * size + x] + way);
                }
            }
        });
    }
    distances
}

/// Returns the attenuation of Kirsch and Döllner 2003 at a point `sd` metres behind the surface nearest to the light.
/// The depth bias is that of pelage's own methods.
fn iterated(maps: &LightMaps, distances: &[f32], passes: u32, place: Vec4, sd: f32, n_dot_l: f32) -> f32 {
    let texel = maps.soft.texel * place.w;
    let bias = depth_bias(place.w, slanted_path(n_dot_l), &maps.soft);
    let sw = maps.bilinear(distances, place) * texel;
    inner_attenuation(sd - bias, sw, maps.soft.penumbra, passes as f32 * texel)
}

/// Returns the paper's shadow-width map: occlusion rendered `shrink` times smaller, then enlarged to its former size.
fn paper_width(occluded: &[bool], size: usize, shrink: u32) -> Vec<f32> {
    let shrink = shrink as usize;
    let small = size.div_ceil(shrink);
    let block = |i: usize| {
        let (x0, y0) = (i % small * shrink, i / small * shrink);
        let texels = (0..shrink * shrink).map(|j| (x0 + j % shrink, y0 + j / shrink));
        let inside = texels.filter(|(x, y)| *x < size && *y < size).map(|(x, y)| occluded[y * size + x]);
        let (count, hit) = inside.fold((0, 0), |(count, hit), o| (count + 1, hit + u32::from(o)));
        hit as f32 / count.max(1) as f32
    };
    let blocks: Vec<f32> = (0..small * small).map(block).collect();
    let place = |x: usize| {
        let x = ((x as f32 + 0.5) / shrink as f32 - 0.5).clamp(0.0, small as f32 - 1.0);
        (x as usize, (x as usize + 1).min(small - 1), x.fract())
    };
    let texel = |i: usize| {
        let ((x0, x1, fx), (y0, y1, fy)) = (place(i % size), place(i / size));
        let row = |y: usize| blocks[y * small + x0] * (1.0 - fx) + blocks[y * small + x1] * fx;
        row(y0) * (1.0 - fy) + row(y1) * fy
    };
    (0..size * size).into_par_iter().map(texel).collect()
}

/// Errors of a configuration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SoftShadowErrors {
    all: Errors,
    shadow: Errors,
    umbra: Errors,
    /// Number of points in the penumbra, first according to the fast method, then according to the truth.
    penumbra: [u64; 2],
}

impl SoftShadowErrors {
    /// Adds the attenuations computed under a light.
    pub fn add(&mut self, fast: &[f64], truth: &[f64]) {
        let pairs = || fast.iter().copied().zip(truth.iter().copied());
        self.all = self.all.and(Errors::of(pairs()));
        self.shadow = self.shadow.and(Errors::of(pairs().filter(|(_, truth)| *truth < LIT)));
        self.umbra =
            self.umbra.and(Errors::of(pairs().filter(|(_, truth)| *truth < UMBRA).map(|(fast, _)| (fast, 0.0))));
        let within =
            |shares: &[f64]| shares.iter().filter(|share| (PENUMBRA[0]..PENUMBRA[1]).contains(*share)).count() as u64;
        self.penumbra = [self.penumbra[0] + within(fast), self.penumbra[1] + within(truth)];
    }
}

/// Returns the cells of a row, in the order of [`COLUMNS`]. `timing` is the source of the milliseconds.
pub fn cells(
    configuration: &SoftShadowConfiguration,
    measured: &SoftShadowErrors,
    milliseconds: f64,
    timing: &str,
) -> Vec<Cell> {
    let number = |x: Option<f64>| x.map_or(Cell::Empty, Cell::Number);
    let (shadows, m) = (&configuration.shadows, measured);
    let passes = if let Method::Iterated(passes) = configuration.method { Some(passes) } else { None };
    let [fast, truth] = m.penumbra.map(|count| count as f64);
    vec![
        Cell::Text(configuration.method.word().into()),
        Cell::Number(shadows.map_size.into()),
        number(passes.is_none().then_some(shadows.shrink.into())),
        number(passes.map(f64::from)),
        Cell::Number(shadows.penumbra.into()),
        number(m.all.rmse()),
        number(m.all.mean()),
        number(m.all.large_error_fraction()),
        number(m.shadow.rmse()),
        number(m.umbra.mean()),
        number((truth > 0.0).then_some(fast / truth)),
        Cell::Number(milliseconds),
        Cell::Text(timing.into()),
    ]
}

#[cfg(test)]
#[path = "soft_shadow_tests.rs"]
mod tests;
