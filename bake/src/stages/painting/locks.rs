//! Locks of guided hair, such as manes and tails: some of the guides, spread over the hair, each painted with one
//! stroke of a split brush.

use super::canvas::{anchor, darkness_of};
use super::model::PaintedModel;
use glam::{Mat3, Vec3};
use pelage_formats::meaning::hair_groups::triangle_frame;
use pelage_formats::meaning::srgb_to_linear;
use pelage_formats::{HairGroup, StrokeAnchor};

/// Maximum number of locks of a group.
const MOST: usize = 32;
/// Distance between two locks, in units of the model's size.
const APART: f32 = 0.022;
/// Half width of a lock over its distance from the next.
const HALF_WIDTH: f32 = 0.42;
/// Range of the half width, in units of the model's size.
const RANGE: [f32; 2] = [0.004, 0.016];
/// Length below which a guide is no lock, in units of the model's size.
const LEAST_LENGTH: f32 = 0.015;

/// Lock of hair.
pub(super) struct Lock {
    pub(super) root: StrokeAnchor,
    /// Points relative to the root, which is the first, in the frame of its triangle, metres.
    pub(super) offsets_m: Vec<Vec3>,
    /// Half width, in units of the model's size.
    pub(super) half_width: f32,
    /// Darkness of root and tip.
    pub(super) darkness: [f32; 2],
}

/// Guide as it lies on the model at rest.
struct Guide {
    index: usize,
    /// Root and middle of the guide, metres.
    places: [Vec3; 2],
    length_m: f32,
}

impl Guide {
    /// Returns the distance between two guides, metres.
    fn distance(&self, other: &Self) -> f32 {
        let [root, middle] = [0, 1].map(|k| self.places[k].distance(other.places[k]));
        0.5 * (root + middle)
    }
}

/// Returns the locks of a model whose size, the diagonal of its bounds, is `size_m`.
pub(super) fn locks(model: &PaintedModel<'_>, size_m: f32) -> Vec<Lock> {
    model.groups.iter().flat_map(|group| locks_of(group, model, size_m)).collect()
}

fn locks_of(group: &HairGroup, model: &PaintedModel<'_>, size_m: f32) -> Vec<Lock> {
    let (triangles, positions) = (&model.surface.mesh.triangles, &model.surface.rest.positions);
    let roots: Vec<_> = group.roots().collect();
    let corners = |triangle: u32| triangles[triangle as usize].map(|v| positions[v as usize]);
    let guides = roots.iter().enumerate().map(|(index, root)| {
        let frame: Mat3 = triangle_frame(corners(root.triangle));
        let points = group.guide(index);
        let place = |p: Vec3| root.position(corners(root.triangle)) + frame * p;
        let length_m = points.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        Guide { index, places: [place(points[0]), place(points[points.len() / 2])], length_m }
    });
    let guides: Vec<Guide> = guides.filter(|guide| guide.length_m > LEAST_LENGTH * size_m).collect();
    let [root, tip] = [group.root_color, group.tip_color].map(|c| darkness_of(Vec3::from(c.map(srgb_to_linear))));
    let chosen = spread(&guides, APART * size_m);
    let lock = |(guide, apart): (&Guide, f32)| Lock {
        root: anchor(
            triangles[roots[guide.index].triangle as usize],
            roots[guide.index].weights[1],
            roots[guide.index].weights[2],
        ),
        offsets_m: group.guide(guide.index),
        half_width: (HALF_WIDTH * apart / size_m).clamp(RANGE[0], RANGE[1]),
        darkness: [root, tip],
    };
    chosen.into_iter().map(lock).collect()
}

/// Returns guides that are at least `apart` from each other, the longest first, then always the one farthest from all
/// before it. Each has its distance from the next.
fn spread(guides: &[Guide], apart: f32) -> Vec<(&Guide, f32)> {
    let Some(mut next) = guides.iter().max_by(|a, b| a.length_m.total_cmp(&b.length_m)) else { return Vec::new() };
    let mut far = vec![f32::INFINITY; guides.len()];
    let mut chosen: Vec<&Guide> = Vec::new();
    while chosen.len() < MOST {
        chosen.push(next);
        far.iter_mut().zip(guides).for_each(|(far, guide)| *far = far.min(guide.distance(next)));
        let Some(k) = (0..guides.len()).max_by(|a, b| far[*a].total_cmp(&far[*b])).filter(|k| far[*k] > apart) else {
            break;
        };
        next = &guides[k];
    }
    let nearest = |guide: &Guide| {
        let others = chosen.iter().filter(|other| other.index != guide.index);
        others.map(|other| other.distance(guide)).fold(f32::INFINITY, f32::min)
    };
    chosen.iter().map(|guide| (*guide, nearest(guide).min(2.0 * apart))).collect()
}
