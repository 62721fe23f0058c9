//! Patches: connected parts of a material, with size, colour and neighbours.

use super::pairs::{ROUND, components, edges};
use crate::sample::{Encoding, Wrap, bilinear};
use glam::DVec3;
use pelage_formats::meaning::luminance;
use pelage_import::mesh::{Model, RestPose};
use std::cell::LazyCell;
use std::collections::BTreeMap;

/// Triangle of the mesh at rest.
#[derive(Clone, Debug)]
pub(super) struct Face {
    /// Indices of the corners, as welded vertices.
    places: [u32; 3],
    /// Index of the material.
    pub material: usize,
    /// Centre, metres.
    pub center: DVec3,
    /// Area, square metres.
    pub area: f64,
    /// Linear luminance of the colour, 0..=1; `None` if the colour comes from an image.
    luminance: Option<f64>,
}

/// Triangles of a model at rest, with their connectivity.
pub(super) struct FaceMesh {
    /// Faces, one per triangle of the mesh.
    pub faces: Vec<Face>,
    /// Position of each welded vertex, metres.
    positions: BTreeMap<u32, DVec3>,
    /// Indices of the triangles at each edge.
    at_edge: BTreeMap<[u32; 2], Vec<usize>>,
    /// Whether each material belongs to eyes.
    eyes: Vec<bool>,
    low: DVec3,
    high: DVec3,
    area: f64,
}

/// Connected triangles of one material.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// Indices of the patch's triangles in the mesh.
    pub triangles: Vec<usize>,
    /// Area as a share of the mesh's area, 0..=1.
    pub share: f64,
    /// Centroid of the area, metres.
    pub center: DVec3,
    /// Height of the lowest point, metres.
    pub lowest: f64,
    /// Mean linear luminance.
    pub luminance: f64,
    /// Mean linear luminance of the other materials along the border, except eyes. If no such material is at the
    /// border, it is the mean of all other materials. `None` if the colours of these materials come from images.
    pub beside: Option<f64>,
    /// Whether the patch borders on eyes.
    pub touches_eyes: bool,
    corners: Vec<DVec3>,
    /// Positions of the vertices on the border, metres.
    rim: Vec<DVec3>,
}

impl FaceMesh {
    /// Analyses a model.
    ///
    /// * `places`: numbers of its vertices from [`super::pairs::weld`]
    /// * `eyes`: whether each material belongs to eyes
    pub(super) fn new(model: &Model, rest: &RestPose, places: &[u32], eyes: &[bool]) -> Self {
        let mut skin = Self {
            faces: Vec::with_capacity(model.mesh.triangles.len()),
            positions: BTreeMap::new(),
            at_edge: BTreeMap::new(),
            eyes: eyes.to_vec(),
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
            area: 0.0,
        };
        for (place, position) in places.iter().zip(&rest.positions) {
            let position = position.as_dvec3();
            skin.positions.entry(*place).or_insert(position);
            (skin.low, skin.high) = (skin.low.min(position), skin.high.max(position));
        }
        let mut material_of = vec![0; model.mesh.triangles.len()];
        for part in &model.mesh.parts {
            material_of[part.first_triangle..part.first_triangle + part.triangle_count].fill(part.material);
        }
        for (triangle, material) in model.mesh.triangles.iter().zip(material_of) {
            let [a, b, c] = triangle.map(|v| rest.positions[v as usize].as_dvec3());
            let area = (b - a).cross(c - a).length() / 2.0;
            let look = &model.materials[material];
            let luminance = look.base_color_image.is_none().then(|| {
                let color = |v: u32| model.mesh.colors.get(v as usize).copied().unwrap_or([255; 4]);
                let vertex = |v: u32| luminance(DVec3::from_slice(&color(v).map(|c| f64::from(c) / 255.0)));
                luminance(DVec3::from_slice(&look.base_color.map(f64::from)))
                    * triangle.map(vertex).into_iter().sum::<f64>()
                    / 3.0
            });
            let places = triangle.map(|v| places[v as usize]);
            for edge in edges(&places) {
                skin.at_edge.entry(edge).or_default().push(skin.faces.len());
            }
            skin.faces.push(Face { places, material, center: (a + b + c) / 3.0, area, luminance });
            skin.area += area;
        }
        skin
    }

    /// Separates the dark faces of a material: gives them the number of a new material, which is returned. A face
    /// has the colour of its texture, or else of its vertices, times that of the material.
    ///
    /// * `dark`: maximum luminance, absolute and relative to the mean of the material
    pub(super) fn separate_dark(&mut self, model: &Model, material: usize, dark: [f64; 2]) -> usize {
        let look = &model.materials[material];
        let image = look.base_color_image.and_then(|image| model.images.get(image));
        for (face, triangle) in self.faces.iter_mut().zip(&model.mesh.triangles) {
            let Some(image) = image.filter(|_| face.material == material) else { continue };
            let [a, b, c] = triangle.map(|v| model.mesh.uvs.get(v as usize).copied().unwrap_or_default());
            // Midpoints between the centre and the corners.
            let sample = |corner| {
                let color = bilinear(image, (a + b + c) / 6.0 + corner / 2.0, Wrap::Repeat, Encoding::Srgb);
                luminance(color.as_dvec4().truncate())
            };
            let texture = [a, b, c].map(sample).into_iter().sum::<f64>() / 3.0;
            face.luminance = Some(texture * luminance(DVec3::from_slice(&look.base_color.map(f64::from))));
        }
        let own = self.faces.iter().filter(|face| face.material == material);
        let average = mean(&mut own.filter_map(|face| Some((face.area, face.luminance?))));
        let most = dark[0].min(dark[1] * average.unwrap_or(0.0));
        let number = self.eyes.len();
        self.eyes.push(false);
        let is_dark = |face: &&mut Face| face.material == material && face.luminance.is_some_and(|l| l <= most);
        self.faces.iter_mut().filter(is_dark).for_each(|face| face.material = number);
        number
    }

    /// Marks a material as belonging to eyes.
    pub(super) fn add_eyes(&mut self, material: usize) {
        self.eyes[material] = true;
    }

    /// Returns the mean linear luminance of all faces whose colour is known, weighted by area.
    pub(super) fn mean_luminance(&self) -> f64 {
        mean(&mut self.faces.iter().filter_map(|face| Some((face.area, face.luminance?)))).unwrap_or(0.0)
    }

    /// Returns the centre of the model's bounding box, metres.
    pub(super) fn middle(&self) -> DVec3 {
        (self.low + self.high) / 2.0
    }

    /// Returns half the diagonal of the model's bounding box, metres.
    pub(super) fn radius(&self) -> f64 {
        self.low.distance(self.high) / 2.0
    }

    /// Returns the lowest and the highest y coordinate, metres.
    pub(super) fn heights(&self) -> (f64, f64) {
        (self.low.y, self.high.y)
    }

    /// Returns the patches of a material of uniform colour, in the order of their first triangles.
    pub(super) fn patches(&self, material: usize) -> Vec<Patch> {
        let own: Vec<usize> = (0..self.faces.len()).filter(|i| self.faces[*i].material == material).collect();
        let places: Vec<[u32; 3]> = own.iter().map(|i| self.faces[*i].places).collect();
        let elsewhere = LazyCell::new(|| {
            let others = self.faces.iter().filter(|face| face.material != material && !self.eyes[face.material]);
            mean(&mut others.filter_map(|face| Some((face.area, face.luminance?))))
        });
        let patch = |piece: &Vec<usize>| self.patch(material, piece.iter().map(|i| own[*i]).collect(), || *elsewhere);
        components(&places).iter().map(patch).collect()
    }

    /// Measures a patch.
    ///
    /// * `elsewhere`: mean linear luminance of the other materials
    fn patch(&self, material: usize, triangles: Vec<usize>, elsewhere: impl Fn() -> Option<f64>) -> Patch {
        let place = |place: &u32| self.positions.get(place).copied().unwrap_or_default();
        let faces = || triangles.iter().map(|i| &self.faces[*i]);
        let (mut rim, mut beside, mut touches_eyes) = (Vec::new(), Vec::new(), false);
        for edge in faces().flat_map(|face| edges(&face.places)) {
            let at_edge = self.at_edge.get(&edge).map_or(&[][..], Vec::as_slice);
            let others = || at_edge.iter().map(|i| &self.faces[*i]).filter(|face| face.material != material);
            if at_edge.len() == 1 || others().next().is_some() {
                rim.extend(edge.iter().map(place));
            }
            touches_eyes |= others().any(|face| self.eyes[face.material]);
            let length = place(&edge[0]).distance(place(&edge[1]));
            let told = others().filter(|face| !self.eyes[face.material]).filter_map(|face| face.luminance);
            beside.extend(told.map(|luminance| (length, luminance)));
        }
        let area: f64 = faces().map(|face| face.area).sum();
        let corners: Vec<DVec3> = faces().flat_map(|face| face.places).map(|p| place(&p)).collect();
        Patch {
            share: if self.area > 0.0 { area / self.area } else { 0.0 },
            center: faces().map(|face| face.center * face.area).sum::<DVec3>() / area.max(f64::MIN_POSITIVE),
            lowest: corners.iter().map(|p| p.y).fold(f64::INFINITY, f64::min),
            luminance: mean(&mut faces().map(|face| (face.area, face.luminance.unwrap_or(1.0)))).unwrap_or(1.0),
            beside: mean(&mut beside.into_iter()).or_else(elsewhere),
            touches_eyes,
            corners,
            rim,
            triangles,
        }
    }
}

impl Patch {
    /// Returns how far the patch extends from a point in the direction of a unit vector, metres.
    pub(super) fn reach(&self, direction: DVec3, from: DVec3) -> f64 {
        self.corners.iter().map(|p| (*p - from).dot(direction)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether the patch is a closed surface that is about as round as a ball.
    pub(super) fn is_ball(&self) -> bool {
        let (mut volume, mut area) = (0.0, 0.0);
        for [a, b, c] in self.corners.as_chunks().0.iter().map(|corners: &[DVec3; 3]| corners.map(|p| p - self.center))
        {
            volume += a.dot(b.cross(c)) / 6.0;
            area += (b - a).cross(c - a).length() / 2.0;
        }
        self.rim.is_empty() && 36.0 * std::f64::consts::PI * volume * volume >= ROUND * area * area * area
    }

    /// Whether the patch protrudes from its border, like a cap or a thorn and unlike a flat spot. It must extend at
    /// least 1.3 times as far from the centre of the border as the border itself.
    pub(super) fn is_tip(&self) -> bool {
        let middle = self.rim.iter().sum::<DVec3>() / self.rim.len().max(1) as f64;
        let width = self.rim.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        let length = self.corners.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        width > 0.0 && length >= 1.3 * width
    }
}

/// Returns the mean of values with weights; `None` without weight.
fn mean(weighed: &mut dyn Iterator<Item = (f64, f64)>) -> Option<f64> {
    let (sum, all) = weighed.fold((0.0, 0.0), |(sum, all), (weight, v)| (sum + weight * v, all + weight));
    (all > 0.0).then(|| sum / all)
}
