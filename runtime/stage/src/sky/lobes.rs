//! Selection of lobes that approximate a sky. Lobes are added one by one, each with the greatest gain, and moved
//! afterwards.

use super::panorama::Panorama;
use super::squares::least_squares;
use glam::DVec3;
use pelage_formats::meaning::scattering::gaussian_light::GaussianLight;

/// Number of candidate directions for lobes.
const DIRECTIONS: usize = 256;
/// Candidate standard deviations of lobes, degrees. Light from narrower sources is not broad.
const WIDTHS_DEG: [f64; 6] = [8.0, 12.0, 18.0, 27.0, 40.0, 60.0];
/// Minimum standard deviation of a moved lobe, degrees.
const LEAST_DEG: f64 = 8.0;
/// Maximum standard deviation of a moved lobe, degrees.
const MOST_DEG: f64 = 75.0;
/// Minimum fraction of the sum of squares that a lobe must explain to be added.
const MIN_GAIN: f64 = 1e-7;

/// Sky divided into cells.
pub(super) struct Cells {
    towards: Vec<DVec3>,
    /// Square roots of the cells' solid angles: the weights of the least squares.
    weights: Vec<f64>,
    /// Radiance of each cell times its weight, per colour.
    light: [Vec<f64>; 3],
    /// Sum of squares of `light` over all colours.
    size: f64,
}

impl Cells {
    pub(super) fn new(sky: &Panorama) -> Self {
        let (width, height) = sky.size();
        let mut cells = Self { towards: Vec::new(), weights: Vec::new(), light: Default::default(), size: 0.0 };
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let weight = sky.solid_angle(y).sqrt();
            cells.towards.push(sky.towards(x, y));
            cells.weights.push(weight);
            for (of, light) in cells.light.iter_mut().zip(sky.at(x, y).to_array()) {
                of.push(light * weight);
            }
        }
        cells.size = cells.light.iter().flatten().map(|x| x * x).sum();
        cells
    }

    /// Returns a lobe's radiance in each cell, times the cell's weight.
    fn column(&self, shape: &Shape) -> Vec<f64> {
        let light = shape.light();
        self.towards.iter().zip(&self.weights).map(|(way, weight)| light.radiance(*way) * weight).collect()
    }
}

#[derive(Clone, Copy)]
struct Shape {
    towards: DVec3,
    width_deg: f64,
}

impl Shape {
    fn light(&self) -> GaussianLight {
        let width = self.width_deg.to_radians();
        GaussianLight { towards: self.towards, sharpness: 1.0 / (width * width) }
    }
}

/// Lobes chosen so far.
pub(super) struct LobeSelection<'a> {
    cells: &'a Cells,
    candidates: Vec<(Shape, Vec<f64>)>,
    shapes: Vec<Shape>,
    /// Step size of each shape's next move, in thirds of its width.
    steps: Vec<f64>,
    /// Weighted light in the cells for each shape; the first column is the uniform light.
    columns: Vec<Vec<f64>>,
    /// Radiance by which each column is scaled, per colour.
    amounts: [Vec<f64>; 3],
    /// Residual: light of the cells that no column explains, per colour.
    rest: [Vec<f64>; 3],
}

impl<'a> LobeSelection<'a> {
    /// Creates a selection that contains only uniform light.
    pub(super) fn new(cells: &'a Cells) -> Self {
        let candidates = spread_evenly(DIRECTIONS).flat_map(|towards| {
            WIDTHS_DEG.map(|width_deg| {
                let shape = Shape { towards, width_deg };
                (shape, cells.column(&shape))
            })
        });
        let mut out = Self {
            cells,
            candidates: candidates.collect(),
            shapes: Vec::new(),
            steps: Vec::new(),
            columns: vec![cells.weights.clone()],
            amounts: Default::default(),
            rest: cells.light.clone(),
        };
        out.amounts = [(); 3].map(|()| vec![0.0]);
        out.solve();
        out
    }

    /// Adds the candidate that explains most of the residual. Returns false if none explains enough.
    pub(super) fn add_best(&mut self) -> bool {
        let worth = |column: &Vec<f64>| {
            let size = dot(column, column);
            self.rest.iter().map(|rest| dot(column, rest).max(0.0)).map(|met| met * met).sum::<f64>() / size.max(1e-300)
        };
        let best = self.candidates.iter().map(|(shape, column)| (shape, worth(column)));
        let Some((shape, worth)) = best.max_by(|a, b| a.1.total_cmp(&b.1)) else { return false };
        if worth <= MIN_GAIN * self.cells.size {
            return false;
        }
        self.shapes.push(*shape);
        self.steps.push(1.0);
        self.columns.push(self.cells.column(shape));
        self.amounts.iter_mut().for_each(|amounts| amounts.push(0.0));
        self.solve();
        true
    }

    /// Moves each lobe to reduce the residual, then solves for the brightness of all. The step size of a lobe grows
    /// while moves help, and halves when no move does.
    pub(super) fn move_all(&mut self) {
        for i in 0..self.shapes.len() {
            let amounts = [0, 1, 2].map(|c: usize| self.amounts[c][i + 1]);
            let alone: [Vec<f64>; 3] = std::array::from_fn(|c| {
                self.rest[c].iter().zip(&self.columns[i + 1]).map(|(rest, lit)| rest + amounts[c] * lit).collect()
            });
            // Light explained by a shape of optimal brightness.
            let worth = |column: &Vec<f64>| {
                let size = dot(column, column).max(1e-300);
                alone.iter().map(|rest| dot(column, rest).max(0.0)).map(|met| met * met / size).sum::<f64>()
            };
            let now = worth(&self.columns[i + 1]);
            let moved = neighbours(&self.shapes[i], self.steps[i]).map(|shape| {
                let column = self.cells.column(&shape);
                (worth(&column), shape, column)
            });
            let best = moved.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|best| best.0 > now);
            self.steps[i] *= if best.is_some() { 1.5 } else { 0.5 };
            self.steps[i] = self.steps[i].min(1.0);
            if let Some((_, shape, column)) = best {
                let size = dot(&column, &column).max(1e-300);
                self.shapes[i] = shape;
                for (c, alone) in alone.iter().enumerate() {
                    let amount = (dot(&column, alone) / size).max(0.0);
                    self.amounts[c][i + 1] = amount;
                    self.rest[c] = alone.iter().zip(&column).map(|(rest, lit)| rest - amount * lit).collect();
                }
                self.columns[i + 1] = column;
            }
        }
        self.solve();
    }

    /// Returns the radiance of the uniform light. Also returns direction, width in degrees and radiance of each lobe.
    pub(super) fn lights(&self) -> (DVec3, impl Iterator<Item = ((DVec3, f32), DVec3)>) {
        let of = |i: usize| DVec3::from([0, 1, 2].map(|c: usize| self.amounts[c][i]));
        let lobes =
            self.shapes.iter().enumerate().map(move |(i, shape)| ((shape.towards, shape.width_deg as f32), of(i + 1)));
        (of(0), lobes)
    }

    /// Returns the root mean square of the residual, relative to that of the light.
    pub(super) fn error(&self) -> f64 {
        let left: f64 = self.rest.iter().flatten().map(|x| x * x).sum();
        (left / self.cells.size.max(1e-300)).sqrt()
    }

    /// Solves for the brightness of all columns.
    fn solve(&mut self) {
        let count = self.columns.len();
        let mut products = vec![0.0; count * count];
        for (i, a) in self.columns.iter().enumerate() {
            for (j, b) in self.columns.iter().enumerate().take(i + 1) {
                (products[i * count + j], products[j * count + i]) = (dot(a, b), dot(a, b));
            }
        }
        for c in 0..3 {
            let light = &self.cells.light[c];
            let b: Vec<f64> = self.columns.iter().map(|column| dot(column, light)).collect();
            least_squares(&products, &b, &mut self.amounts[c]);
            self.rest[c].clone_from(&self.cells.light[c]);
            for (column, amount) in self.columns.iter().zip(&self.amounts[c]) {
                for (rest, lit) in self.rest[c].iter_mut().zip(column) {
                    *rest -= amount * lit;
                }
            }
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Returns variants of a shape: moved sideways by a third of its width, and widened and narrowed by a quarter. `step`
/// scales these changes.
fn neighbours(shape: &Shape, step: f64) -> impl Iterator<Item = Shape> {
    let Shape { towards, width_deg } = *shape;
    let (side, up) = towards.any_orthonormal_pair();
    let aside = step * (width_deg / 3.0).to_radians();
    let moved =
        [side, -side, up, -up].map(|by| Shape { towards: (towards + by * aside).normalize_or(towards), width_deg });
    let resized = [1.25, 0.8]
        .map(|by| Shape { towards, width_deg: (width_deg * libm::pow(by, step)).clamp(LEAST_DEG, MOST_DEG) });
    moved.into_iter().chain(resized)
}

/// Returns unit vectors distributed evenly over the sphere (a Fibonacci spiral).
fn spread_evenly(count: usize) -> impl Iterator<Item = DVec3> {
    const GOLDEN: f64 = 2.399_963_229_728_653;
    (0..count).map(move |i| {
        let y = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
        let (sin, cos) = libm::sincos(GOLDEN * i as f64);
        let out = (1.0 - y * y).sqrt();
        DVec3::new(out * cos, y, out * sin)
    })
}
