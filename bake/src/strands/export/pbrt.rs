//! Export of curves for pbrt-v4, to be included in a scene.
//!
//! Each segment of a strand is a cubic Bézier curve whose inner control points are on the line at one and two thirds.
//! Such a curve is exactly the line, with the given width at each end. In a single curve of many segments, the width
//! would change uniformly from root to tip, which is wrong if points were removed. `splitdepth` is 0, because splitting
//! straight segments has no benefit.

use super::{allowed, plain_names};
use crate::strands::{CurvePoint, Curves};
use glam::{DVec3, Vec3};
use std::io::{self, Write};

/// Writes strands as `Shape "curve"` directives, with an attribute block for each group. The material of a group is
/// named `strands/` followed by the group's name. It is diffuse, in the mean colour of the group's points, because pbrt
/// supports a material, but no colour, per curve.
///
/// Fails with errors of `out`.
pub fn write_pbrt(curves: &Curves, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "# {} strands in {} straight pieces, metres, y up", curves.len(), curves.segments())?;
    // Names are used within a quoted string and on a comment line.
    let names = plain_names(curves, |name| allowed(name, |c| !c.is_control() && !"\"\\".contains(c)));
    for (group, name) in curves.groups().iter().zip(names) {
        let mean = mean_color(curves.points_of(group));
        writeln!(out, "\n# group {name}, number of strands: {}\nAttributeBegin", group.strands.len())?;
        write!(out, "MakeNamedMaterial \"strands/{name}\" \"string type\" \"diffuse\" ")?;
        writeln!(out, "\"rgb reflectance\" [{} {} {}]", mean.x, mean.y, mean.z)?;
        writeln!(out, "NamedMaterial \"strands/{name}\"")?;
        for strand in group.strands.clone() {
            curves.strand(strand as usize).windows(2).try_for_each(|ends| write_piece(&ends[0], &ends[1], out))?;
        }
        writeln!(out, "AttributeEnd")?;
    }
    Ok(())
}

/// Returns the mean colour, linear RGB, 0..=1.
fn mean_color(points: &[CurvePoint]) -> Vec3 {
    let sum: DVec3 = points.iter().map(|p| p.color.as_dvec3()).sum();
    (sum / points.len().max(1) as f64).as_vec3().clamp(Vec3::ZERO, Vec3::ONE)
}

fn write_piece(from: &CurvePoint, to: &CurvePoint, out: &mut dyn Write) -> io::Result<()> {
    let (a, b) = (from.position_ws, to.position_ws);
    let inner = [a.lerp(b, 1.0 / 3.0), a.lerp(b, 2.0 / 3.0)];
    write!(out, "Shape \"curve\" \"string type\" \"cylinder\" \"integer splitdepth\" 0 \"point3 P\" [")?;
    for p in [a, inner[0], inner[1], b] {
        write!(out, " {} {} {}", p.x, p.y, p.z)?;
    }
    let [from, to] = [from, to].map(|point| 2.0 * point.radius_m);
    writeln!(out, " ] \"float width0\" {from} \"float width1\" {to}")
}
