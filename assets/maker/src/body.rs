//! Bodies as implicit surfaces: a smooth union of solids, each with its own comb direction.

use anyhow::bail;
use glam::{DMat3, DVec2, DVec3};

use super::{
    pose::hermite,
    remesh::{Sizing, remesh},
    sdf::{Solid, smooth_max, smooth_min},
    trimesh::TriMesh,
};

/// Comb direction of a solid, before projection onto the mesh surface.
#[derive(Clone, Copy, Debug)]
pub enum Comb {
    /// Along a fixed direction.
    Along(DVec3),
    /// Away from a point.
    From(DVec3),
}

struct BodyPart {
    solid: Solid,
    /// Rounding radius of the union with all earlier solids, metres.
    blend: f64,
    /// Whether the solid is carved out instead of added.
    carved: bool,
    comb: Comb,
    /// Bounding sphere of the solid (centre, radius in metres), and its growth rate. Outside the sphere, the solid's
    /// distance grows by at least this rate per metre of distance from the sphere.
    bound: (DVec3, f64, f64),
}

impl BodyPart {
    fn new(solid: Solid, blend: f64, carved: bool, comb: Comb) -> Self {
        let bound = solid.bound();
        Self { solid, blend, carved, comb, bound }
    }

    /// Returns true if the bounding sphere proves that the solid's distance at `p` is at least `limit`. May return
    /// false although it is.
    fn is_beyond(&self, p: DVec3, limit: f64) -> bool {
        let (centre, radius, growth) = self.bound;
        let away = if limit < 0.0 { limit } else { limit / growth } + radius;
        away < 0.0 || (p - centre).length_squared() > away * away
    }
}

/// Body as an implicit surface.
pub struct Body {
    pieces: Vec<BodyPart>,
    /// Blend width between the comb directions of neighbouring solids, metres.
    comb_width: f64,
}

impl Body {
    /// Creates a body without solids. The comb directions of neighbouring solids are blended over `comb_width` metres.
    pub fn empty(comb_width: f64) -> Self {
        Self { pieces: Vec::new(), comb_width }
    }

    /// Adds a solid by a smooth union, rounded over `blend` metres, with all earlier solids.
    pub fn add(&mut self, solid: Solid, blend: f64, comb: Comb) {
        self.pieces.push(BodyPart::new(solid, blend, false, comb));
    }

    /// Carves a solid out of all earlier solids; the edge is rounded over `blend` metres.
    pub fn carve(&mut self, solid: Solid, blend: f64, comb: Comb) {
        self.pieces.push(BodyPart::new(solid, blend, true, comb));
    }

    /// Returns the approximate signed distance, negative inside.
    pub fn distance(&self, p: DVec3) -> f64 {
        // The initial distance exceeds every blend width, so the first solid is added unchanged.
        let mut d = 1e9;
        for piece in &self.pieces {
            // Skips solids that cannot change the distance at `p`. At most points, these are the majority.
            if piece.is_beyond(p, piece.blend + if piece.carved { -d } else { d }) {
                continue;
            }
            let own = piece.solid.distance(p);
            d = if piece.carved { smooth_max(d, -own, piece.blend) } else { smooth_min(d, own, piece.blend) };
        }
        d
    }

    /// Returns the comb direction at `p`, not yet projected onto the surface: the mean of the solids' comb directions,
    /// weighted by proximity.
    pub fn comb(&self, p: DVec3) -> DVec3 {
        let added = self.pieces.iter().filter(|piece| !piece.carved);
        let near: Vec<(f64, &BodyPart)> = added.map(|piece| (piece.solid.distance(p), piece)).collect();
        let nearest = near.iter().fold(f64::MAX, |m, &(d, _)| m.min(d));
        near.iter().fold(DVec3::ZERO, |sum, &(d, piece)| {
            let q = (d - nearest) / self.comb_width;
            let weight = 1.0 / ((1.0 + q * q) * (1.0 + q * q));
            let direction = match piece.comb {
                Comb::Along(direction) => direction,
                Comb::From(point) => (p - point).normalize_or_zero(),
            };
            sum + direction * weight
        })
    }
}

/// Components to keep when a surface has several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// Component with the most triangles; the others are hollows inside an animal.
    Largest,
    /// All components.
    All,
}

/// Returns the closed mesh of the zero set of `field` inside the box from `low` to `high`. All vertices are on the
/// surface. The surface is first meshed on cubes of `cell` metres, which must be finer than the thinnest part. The
/// result is then remeshed to `sizing`.
pub fn mesh(
    field: &dyn Fn(DVec3) -> f64,
    [low, high]: [DVec3; 2],
    cell: f64,
    sizing: Sizing,
    keep: Keep,
) -> anyhow::Result<TriMesh> {
    let mut mesh = TriMesh::from_field(field, low, high, cell);
    if let Err((a, _)) = mesh.neighbours() {
        bail!(
            "the surface is not manifold at {}; it needs grid cells smaller than {cell} m",
            mesh.positions[a as usize]
        );
    }
    if keep == Keep::Largest {
        mesh.keep_largest_component();
    }
    remesh(&mut mesh, field, sizing, 12);
    Ok(mesh)
}

/// Returns the hull of the spheres of radius `ra` at `a` and `rb` at `b`.
pub fn cone(a: DVec3, ra: f64, b: DVec3, rb: f64) -> Solid {
    Solid::RoundCone { a, b, ra, rb }
}

/// Returns the hull of two spheres, flattened along x to the fraction `share` of its width. Its axis must lie in a
/// plane parallel to the yz-plane.
pub fn oval(a: DVec3, ra: f64, b: DVec3, rb: f64, share: f64) -> Solid {
    Solid::Oval { a, b, ra, rb, across: DVec3::X, share }
}

/// Returns one solid along the smooth curve through `points` (position and radius), with `steps` segments between
/// neighbouring points.
pub fn chain(points: &[(DVec3, f64)], steps: usize) -> Solid {
    Solid::Chain { line: curve(points, steps) }
}

/// Returns an ellipsoid with half lengths `radii` along the columns of `axes`.
pub fn ellipsoid(centre: DVec3, radii: DVec3, axes: DMat3) -> Solid {
    Solid::Ellipsoid { centre, radii, axes }
}

/// Returns a smooth curve through `points` (position and radius) with `steps` segments between neighbouring points. The
/// curve is a Catmull-Rom spline, straight at the ends.
pub fn curve(points: &[(DVec3, f64)], steps: usize) -> Vec<(DVec3, f64)> {
    let vector = |k: usize| points[k].0.extend(points[k].1);
    let last = points.len() - 1;
    let mut line = vec![points[0]];
    for k in 0..last {
        let (from, to) = (vector(k), vector(k + 1));
        let before = if k == 0 { from * 2.0 - to } else { vector(k - 1) };
        let after = if k + 1 == last { to * 2.0 - from } else { vector(k + 2) };
        line.extend((1..=steps).map(|i| {
            let s = i as f64 / steps as f64;
            let p = hermite(from, (to - before) * 0.5, to, (after - from) * 0.5, s);
            (p.truncate(), p.w)
        }));
    }
    line
}

/// Returns the signed distance to an almond shape, such as the opening between two eyelids. Two arcs bound it, between
/// corners that are 2 * `half` apart. They rise to `over` above the line between the corners and drop to `under` below
/// it.
pub fn almond(q: DVec2, half: f64, over: f64, under: f64) -> f64 {
    let arc = |q: DVec2, height: f64| {
        let radius = (half * half + height * height) / (2.0 * height);
        (q - DVec2::new(0.0, height - radius)).length() - radius
    };
    // Shifts the highest point of the upper lid towards +x and the lowest point of the lower lid towards -x.
    let shift = DVec2::new(0.08 * half, 0.0);
    arc(q - shift, over).max(arc(DVec2::new(q.x, -q.y) + shift, under))
}

/// Returns a smooth bump: 1 at `x` = 0, nearly 0 for |`x`| > `width`.
pub fn bump(x: f64, width: f64) -> f64 {
    let q = 2.0 * x / width;
    let q = 1.0 + q * q;
    1.0 / (q * q)
}

/// Mirrors `v` across the plane x = 0.
pub fn mirror(v: DVec3) -> DVec3 {
    DVec3::new(-v.x, v.y, v.z)
}

/// Returns `v` if `side` is +1, its mirror image if -1.
pub fn on_side(side: f64, v: DVec3) -> DVec3 {
    if side > 0.0 { v } else { mirror(v) }
}

/// Returns the rotation about x that turns +Z downwards. The sine and cosine of the angle have the ratio `sin : cos`.
pub fn pitch(sin: f64, cos: f64) -> DMat3 {
    let length = (sin * sin + cos * cos).sqrt();
    let (s, c) = (sin / length, cos / length);
    DMat3::from_cols(DVec3::X, DVec3::new(0.0, c, s), DVec3::new(0.0, -s, c))
}

/// Returns a smooth step: 0 below `low`, 1 above `high`.
pub fn ramp(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
