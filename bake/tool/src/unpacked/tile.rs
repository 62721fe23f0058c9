//! Converts the tile's strands between `.hair` coordinates and the integers of a package.

use glam::{DVec2, DVec3, Vec2};
use pelage_bake::strands::CurvePoint;
use pelage_formats::meaning::srgb_to_linear;
use pelage_formats::{StoredStrandPoint, StrandPoint, StrandScale, strand_root};
use serde::{Deserialize, Serialize};

/// Stored integers of a strand that cannot be recovered from the `.hair` file.
#[derive(Serialize, Deserialize)]
pub struct ExactStrand {
    pub strand: usize,
    pub root: [u16; 2],
    /// Offsets along u and v, height, and radius of each point.
    pub points: Vec<(i16, i16, u16, u16)>,
}

/// Mapping between tile and file coordinates.
pub struct TileMapping {
    pub width_m: f64,
    pub height_m: f64,
    pub scale: StrandScale,
}

/// Strand read from a file.
pub struct Strand {
    pub root: [u16; 2],
    pub points: Vec<StrandPoint>,
    /// Stored integers, if the strand was not edited.
    pub exact: Option<Vec<StoredStrandPoint>>,
}

impl TileMapping {
    /// Converts a stored point to file coordinates.
    pub fn to_file(&self, root: [u16; 2], point: &StoredStrandPoint) -> CurvePoint {
        let found = point.decoded(self.scale);
        let [u, v] = [0, 1].map(|k| f64::from(strand_root(root)[k]) + f64::from(found.aside[k]));
        let place = DVec3::new(u * self.width_m, f64::from(found.height) * self.height_m, -v * self.width_m);
        CurvePoint {
            position_ws: place.as_vec3(),
            // The file stores the diameter, whose half must convert back exactly.
            radius_m: (f64::from(found.radius) * self.width_m) as f32,
            color: found.color.map(srgb_to_linear).into(),
            ..CurvePoint::default()
        }
    }

    /// Converts a point of the file to u, v and height.
    fn in_tile(&self, point: &CurvePoint) -> DVec3 {
        let p = point.position_ws.as_dvec3();
        DVec3::new(p.x / self.width_m, -p.z / self.width_m, p.y / self.height_m)
    }

    /// Returns the root position of a strand from its first point, and the tile that contains it.
    fn root(&self, first: &CurvePoint) -> ([u16; 2], DVec2) {
        let place = self.in_tile(first).truncate();
        let root = (place - place.floor()) * 65536.0;
        (root.to_array().map(|x| x as u16), place.floor())
    }

    /// Reads a strand from its points. Without a given root, the first point determines the root. The error names a
    /// point outside the fur.
    pub fn strand(
        &self,
        points: &[CurvePoint],
        root: Option<[u16; 2]>,
        exact: Option<&ExactStrand>,
    ) -> Result<Strand, (usize, String)> {
        if let Some(exact) = exact.filter(|exact| root.is_none_or(|root| root == exact.root)) {
            let stored: Vec<StoredStrandPoint> = exact
                .points
                .iter()
                .map(|(u, v, height, radius)| StoredStrandPoint {
                    aside: [*u, *v],
                    height: *height,
                    radius: *radius,
                    ..StoredStrandPoint::default()
                })
                .collect();
            let same = |(stored, point): (&StoredStrandPoint, &CurvePoint)| {
                let shown = self.to_file(exact.root, stored);
                (shown.position_ws, shown.radius_m) == (point.position_ws, point.radius_m)
            };
            if stored.len() == points.len() && stored.iter().zip(points).all(same) {
                let decoded = stored.iter().map(|point| point.decoded(self.scale)).collect();
                return Ok(Strand { root: exact.root, points: decoded, exact: Some(stored) });
            }
        }
        let (stands_on, tiles) = self.root(&points[0]);
        let (root, tiles) = match root {
            // Wet strands have the same roots as dry ones, but the first point may be in a neighbouring tile.
            Some(root) => (root, (self.in_tile(&points[0]).truncate() - middle(root)).round()),
            None => (stands_on, tiles),
        };
        let from = middle(root) + tiles;
        let read = |(number, point): (usize, &CurvePoint)| {
            let place = self.in_tile(point);
            let aside = (place.truncate() - from).as_vec2();
            // Excess up to half a stored unit disappears in rounding.
            let slack = 0.5 / 65535.0;
            if !(-slack..=1.0 + slack).contains(&place.z) {
                let (found, most) = (point.position_ws.y, self.height_m as f32);
                return Err((number, format!("y is {found}, expected 0 to {most}, the fur's height")));
            }
            if point.radius_m < 0.0 {
                return Err((number, format!("the thickness is {}, expected 0 or more", 2.0 * point.radius_m)));
            }
            Ok(StrandPoint {
                aside: aside.to_array(),
                height: place.z.clamp(0.0, 1.0) as f32,
                radius: (f64::from(point.radius_m) / self.width_m) as f32,
                ..StrandPoint::default()
            })
        };
        let points = points.iter().enumerate().map(read).collect::<Result<_, _>>()?;
        Ok(Strand { root, points, exact: None })
    }
}

fn middle(root: [u16; 2]) -> DVec2 {
    Vec2::from(strand_root(root)).as_dvec2()
}

/// Returns `scale`, or a larger scale if a strand exceeds it by more than rounding.
pub fn scale_for(scale: StrandScale, strands: &[Strand]) -> StrandScale {
    let points = || strands.iter().flat_map(|strand| &strand.points);
    let reach = points().flat_map(|p| p.aside).map(f32::abs).fold(0.0, f32::max);
    let radius = points().map(|p| p.radius).fold(0.0, f32::max);
    let larger = |old: f32, found: f32, most: f32| if found > old * (1.0 + 0.5 / most) { found } else { old };
    StrandScale { reach: larger(scale.reach, reach, 32767.0), radius: larger(scale.radius, radius, 65535.0) }
}
