//! Curves for pbrt-v4, to be included in a scene.
//!
//! A piece of a strand is a cubic Bézier curve whose inner control points lie on the line at a third and two thirds, which is that line exactly,
//! with the width at its two ends. A strand as one curve of many pieces would have its width run evenly from root to tip, which it does not after
//! points were left out. `splitdepth 0`: straight pieces gain nothing from being split.

use crate::strands::Curves;
use glam::Vec3;
use std::io::{self, Write};

/// Writes strands as `Shape "curve"` directives. Their material is diffuse in the mean colour of all points, because pbrt takes a material, and no
/// colour, per curve.
///
/// # Errors
/// Those of `out`.
pub fn write_pbrt(curves: &Curves, out: &mut dyn Write) -> io::Result<()> {
    let sum = curves.points.iter().map(|p| p.color.as_dvec3()).sum::<glam::DVec3>();
    let mean = (sum / curves.points.len().max(1) as f64).as_vec3().clamp(Vec3::ZERO, Vec3::ONE);
    writeln!(out, "# {} strands in {} straight pieces, metres, y up", curves.len(), curves.segments())?;
    writeln!(out, "AttributeBegin")?;
    writeln!(out, "Material \"diffuse\" \"rgb reflectance\" [{} {} {}]", mean.x, mean.y, mean.z)?;
    for strand in 0..curves.len() {
        for ends in curves.strand(strand).windows(2) {
            let (a, b) = (ends[0].position_ws, ends[1].position_ws);
            let inner = [a.lerp(b, 1.0 / 3.0), a.lerp(b, 2.0 / 3.0)];
            write!(out, "Shape \"curve\" \"string type\" \"cylinder\" \"integer splitdepth\" 0 \"point3 P\" [")?;
            for p in [a, inner[0], inner[1], b] {
                write!(out, " {} {} {}", p.x, p.y, p.z)?;
            }
            let [from, to] = [ends[0].radius_m, ends[1].radius_m].map(|radius| 2.0 * radius);
            writeln!(out, " ] \"float width0\" {from} \"float width1\" {to}")?;
        }
    }
    writeln!(out, "AttributeEnd")
}
