//! Export as USD text with `BasisCurves`, which Blender opens as hair curves with radius, colour and root coordinates.
//!
//! <https://openusd.org/release/api/class_usd_geom_basis_curves.html>. Each group is a prim below `/strands`, the
//! default prim. Curves are linear, because strands are polylines.

use super::{allowed, plain_names};
use crate::strands::{CurveGroup, Curves};
use glam::Vec3;
use std::io::{self, Write};

/// Number of items per line, for lists that are not written with one line per strand.
const ITEMS_PER_LINE: usize = 16;

/// Writes strands.
///
/// * Each point has a width (diameter of the hair, metres) and `primvars:displayColor` (linear RGB).
/// * Each strand has `primvars:surface_uv_coordinate`: the mesh's texture coordinates at its root, with v upwards as in
///   USD. Blender's own curves use the same name.
/// * The name of a group is converted to an identifier. If the conversion changes it, the `displayName` of the prim
///   keeps the original.
///
/// Fails with errors of `out`.
pub fn write_usda(curves: &Curves, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "#usda 1.0\n(\n    defaultPrim = \"strands\"")?;
    writeln!(out, concat!("    doc = \"pelage ", env!("CARGO_PKG_VERSION"), "\""))?;
    writeln!(out, "    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n")?;
    writeln!(out, "def Xform \"strands\" (\n    kind = \"component\"\n)\n{{")?;
    let names = plain_names(curves, identifier);
    for (i, (group, name)) in curves.groups().iter().zip(names).enumerate() {
        if i > 0 {
            writeln!(out)?;
        }
        write_group(curves, group, &name, out)?;
    }
    writeln!(out, "}}")
}

fn write_group(curves: &Curves, group: &CurveGroup, name: &str, out: &mut dyn Write) -> io::Result<()> {
    write!(out, "    def BasisCurves \"{name}\"")?;
    if name != group.name {
        write!(out, " (\n        displayName = \"{}\"\n    )", escaped(&group.name))?;
    }
    writeln!(out, "\n    {{\n        uniform token type = \"linear\"")?;
    let strands = group.strands.start as usize..group.strands.end as usize;
    let points = || strands.clone().map(|i| curves.strand(i).iter());
    let lines = || strands.clone().step_by(ITEMS_PER_LINE).map(|first| first..strands.end.min(first + ITEMS_PER_LINE));
    let [low, high] = extent(curves, group).map(|p| p.to_array());
    writeln!(out, "        float3[] extent = [({}), ({})]", Join(low), Join(high))?;
    let counts = lines().map(|line| line.map(|i| curves.strand(i).len()));
    write_list("int[] curveVertexCounts", None, counts, out, |count, out| write!(out, "{count}"))?;
    write_list("point3f[] points", None, points(), out, |p, out| write!(out, "({})", Join(p.position_ws.to_array())))?;
    write_list("float[] widths", Some("vertex"), points(), out, |p, out| write!(out, "{}", 2.0 * p.radius_m))?;
    write_list("color3f[] primvars:displayColor", Some("vertex"), points(), out, |p, out| {
        write!(out, "({})", Join(p.color.to_array()))
    })?;
    let coordinates = lines().map(|line| curves.root_uv[line].iter());
    write_list("float2[] primvars:surface_uv_coordinate", Some("uniform"), coordinates, out, |uv, out| {
        // glTF counts image rows from the top, USD from the bottom.
        write!(out, "({})", Join([uv.x, 1.0 - uv.y]))
    })?;
    writeln!(out, "    }}")
}

/// Returns the box around all points, extended by the largest radius. USD computes the extent of curves in the same
/// way.
fn extent(curves: &Curves, group: &CurveGroup) -> [Vec3; 2] {
    let points = curves.points_of(group);
    let places = || points.iter().map(|p| p.position_ws);
    let low = places().fold(Vec3::INFINITY, Vec3::min);
    let high = places().fold(Vec3::NEG_INFINITY, Vec3::max);
    let radius = points.iter().map(|p| p.radius_m).fold(0.0, f32::max);
    [low - radius, high + radius]
}

/// Writes a list attribute, `declaration = [...]`, with one line for each of `lines`.
fn write_list<T>(
    declaration: &str,
    interpolation: Option<&str>,
    lines: impl Iterator<Item = impl Iterator<Item = T>>,
    out: &mut dyn Write,
    write: impl Fn(T, &mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    write!(out, "        {declaration} = [")?;
    for (i, line) in lines.enumerate() {
        for (k, item) in line.enumerate() {
            let between = match (i, k) {
                (0, 0) => "",
                (_, 0) => ",\n            ",
                _ => ", ",
            };
            out.write_all(between.as_bytes())?;
            write(item, out)?;
        }
    }
    match interpolation {
        Some(interpolation) => writeln!(out, "] (\n            interpolation = \"{interpolation}\"\n        )"),
        None => writeln!(out, "]"),
    }
}

/// Numbers separated by commas; parsing them gives the same bits.
struct Join<const N: usize>([f32; N]);

impl<const N: usize> std::fmt::Display for Join<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.iter().enumerate().try_for_each(|(i, number)| {
            let between = if i > 0 { ", " } else { "" };
            write!(f, "{between}{number}")
        })
    }
}

/// Returns a non-empty name of ASCII letters, digits and `_`. It does not begin with a digit.
fn identifier(name: &str) -> String {
    let name = allowed(name, |c| c.is_ascii_alphanumeric() || c == '_');
    if name.starts_with(|c: char| !c.is_ascii_digit()) { name } else { format!("_{name}") }
}

fn escaped(text: &str) -> String {
    let plain = |c: char| match c {
        '"' | '\\' => format!("\\{c}"),
        c if c.is_control() => '_'.into(),
        c => c.into(),
    };
    text.chars().map(plain).collect()
}
