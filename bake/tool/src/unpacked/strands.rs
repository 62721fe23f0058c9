//! Converts the tile's strands (section `STRN`) to `.hair` files and a JSON file, and back.
//!
//! `strands.hair` shows the tile on a flat surface, metres, y up: u along x, v along −z, height along y. If dry and wet
//! hair are mixed, `strands_wet.hair` shows the same strands when wet. `strands.json` contains the data that a `.hair`
//! file cannot hold. An unedited strand is packed to exactly the integers it was unpacked from. Integers that cannot be
//! recovered from a `.hair` file are stored in `exact`, and are used as long as the strand still matches them.

use super::json::{File, parse, shorten_floats, to_rows};
use super::tile::{ExactStrand, Strand, TileMapping, scale_for};
use glam::Vec2;
use pelage_bake::hexadecimal::{from_hex, hex};
use pelage_bake::strands::export::write_hair;
use pelage_bake::strands::{CurvePoint, Curves};
use pelage_formats::meaning::linear_to_srgb;
use pelage_formats::{FurInfo, StoredStrandPoint, StoredStrands, StrandPoint, StrandScale};
use pelage_import::BakeError;
use pelage_import::guides::read::HairFile;
use serde::{Deserialize, Serialize};

/// Name of the JSON file.
pub const JSON: &str = "strands.json";
/// Names of the files of dry and wet strands.
pub const FILES: [&str; 2] = ["strands.hair", "strands_wet.hair"];

/// Contents of `strands.json`.
#[derive(Serialize, Deserialize)]
struct Document {
    /// Number of points of each strand.
    points_per_strand: u32,
    /// Length that the largest stored integer represents, tile widths. Edited strands that reach farther increase it.
    reach: f32,
    radius: f32,
    /// Width of the tile and height of the fur in the `.hair` files, metres.
    width_m: f32,
    height_m: f32,
    /// Set of dry strands, then the set of wet strands, if any.
    sets: Vec<Set>,
}

impl Document {
    fn frame(&self) -> TileMapping {
        let scale = StrandScale { reach: self.reach, radius: self.radius };
        TileMapping { width_m: self.width_m.into(), height_m: self.height_m.into(), scale }
    }
}

#[derive(Default, Serialize, Deserialize)]
struct Set {
    /// Light visibility of the points of each strand: four bytes per point, in hexadecimal.
    visibility: Vec<String>,
    exact: Vec<ExactStrand>,
}

/// Returns the names and contents of all files, the JSON file first. Returns `None` if reading them back would not give
/// the same strands.
pub fn write(strands: &StoredStrands, fur: &FurInfo) -> Result<Option<Vec<File>>, BakeError> {
    let each = strands.points_per_strand as usize;
    let mut document = Document {
        points_per_strand: strands.points_per_strand,
        reach: strands.scale.reach,
        radius: strands.scale.radius,
        width_m: fur.tile_size_m,
        // Fur of zero height needs a nonzero height here, so that the stored strand heights are preserved.
        height_m: if fur.height_m > 0.0 { fur.height_m } else { fur.tile_size_m },
        sets: Vec::new(),
    };
    let frame = document.frame();
    let mut files = Vec::new();
    for (number, (set, file)) in strands.points.chunks(each * strands.roots.len()).zip(FILES).enumerate() {
        let mut curves = Curves::default();
        let mut described = Set::default();
        for (strand, (points, root)) in set.chunks(each).zip(&strands.roots).enumerate() {
            let shown: Vec<CurvePoint> = points.iter().map(|point| frame.to_file(*root, point)).collect();
            let back = frame.strand(&shown, (number > 0).then_some(*root), None);
            let same = |(back, point): (&StrandPoint, &StoredStrandPoint)| {
                let back = back.stored(frame.scale);
                (back.aside, back.height, back.radius) == (point.aside, point.height, point.radius)
            };
            if !back.is_ok_and(|back| back.root == *root && back.points.iter().zip(points).all(same)) {
                let points = points.iter().map(|p| (p.aside[0], p.aside[1], p.height, p.radius)).collect();
                described.exact.push(ExactStrand { strand, root: *root, points });
            }
            described.visibility.push(hex(points.iter().map(|p| p.visibility).collect::<Vec<_>>().as_flattened()));
            curves.push(&shown, false, Vec2::ZERO);
        }
        let mut bytes = Vec::new();
        write_hair(&curves, &mut bytes).map_err(|e| BakeError::Internal(format!("writing {file}: {e}")))?;
        files.push((file.to_owned(), bytes));
        document.sets.push(described);
    }
    let mut value = serde_json::to_value(&document).map_err(|e| BakeError::Internal(format!("writing JSON: {e}")))?;
    shorten_floats(&mut value);
    let json = (JSON.to_owned(), to_rows(&value).into_bytes());
    let same = read(&json, &files).is_ok_and(|back| back == *strands);
    files.insert(0, json);
    Ok(same.then_some(files))
}

/// Reads the strands; file names are for messages.
pub fn read((json_file, json): &File, files: &[File]) -> Result<StoredStrands, BakeError> {
    let fault = |file: &str, place: String, reason: String| BakeError::Input { file: file.to_owned(), place, reason };
    let document: Document = parse(json_file, json)?;
    if document.sets.len() != files.len() {
        let reason = format!("found {} sets, expected {}, one for each .hair file", document.sets.len(), files.len());
        return Err(fault(json_file, "/sets".into(), reason));
    }
    let lengths = [("reach", document.reach), ("radius", document.radius)];
    let metres = [("width_m", document.width_m), ("height_m", document.height_m)];
    if let Some((key, found)) = lengths.into_iter().chain(metres).find(|(_, x)| !(*x > 0.0 && x.is_finite())) {
        return Err(fault(json_file, format!("/{key}"), format!("{found}, expected a finite number above 0")));
    }
    let frame = document.frame();
    let each = document.points_per_strand as usize;
    let mut sets: Vec<Vec<Strand>> = Vec::new();
    let mut looks = Vec::new();
    for (number, (set, (file, bytes))) in document.sets.iter().zip(files).enumerate() {
        let hair = HairFile::read(file, bytes)?;
        if hair.thickness.is_empty() || hair.colors.is_empty() {
            let reason = "the arrays lack thickness or colours, expected both".to_owned();
            return Err(fault(file, "byte 12".into(), reason));
        }
        let (found, expected) = (hair.strands.len(), set.visibility.len());
        if found != expected {
            let reason = format!(
                "found {found} strands, expected {expected}, the length of /sets/{number}/visibility in {JSON}"
            );
            return Err(fault(file, "byte 4".into(), reason));
        }
        if let Some(odd) = hair.strands.iter().position(|points| *points as usize != each) {
            let reason =
                format!("found {} points, expected {each}, as in /points_per_strand of {JSON}", hair.strands[odd]);
            return Err(fault(file, format!("strand {odd}"), reason));
        }
        if number > 0 && found != sets[0].len() {
            let reason = format!("found {found} strands, expected {}, as many as in {}", sets[0].len(), files[0].0);
            return Err(fault(file, "byte 4".into(), reason));
        }
        let mut exact = vec![None; found];
        for (k, entry) in set.exact.iter().enumerate() {
            let place = format!("/sets/{number}/exact/{k}");
            let slot = exact.get_mut(entry.strand).ok_or_else(|| {
                let reason = format!("{}, expected less than the {found} strands", entry.strand);
                fault(json_file, format!("{place}/strand"), reason)
            })?;
            if entry.points.len() != each {
                let reason = format!("{} points, expected {each}", entry.points.len());
                return Err(fault(json_file, format!("{place}/points"), reason));
            }
            *slot = Some(entry);
        }
        let mut strands = Vec::new();
        for (strand, range) in hair.ranges().enumerate() {
            let points: Vec<CurvePoint> = range
                .clone()
                .map(|k| CurvePoint {
                    position_ws: hair.points[k],
                    radius_m: 0.5 * hair.thickness[k],
                    ..CurvePoint::default()
                })
                .collect();
            let digits = &set.visibility[strand];
            let light = from_hex(digits).filter(|bytes| bytes.len() == 4 * each).ok_or_else(|| {
                let reason = format!("{digits:?}, expected {} hexadecimal digits", 8 * each);
                fault(json_file, format!("/sets/{number}/visibility/{strand}"), reason)
            })?;
            let colors = hair.colors[range].iter().map(|c| c.to_array().map(linear_to_srgb));
            looks.extend(colors.zip(light.as_chunks::<4>().0.iter().copied()));
            let root = sets.first().map(|dry| dry[strand].root);
            let read = frame.strand(&points, root, exact[strand]);
            strands.push(read.map_err(|(k, reason)| fault(file, format!("strand {strand}, point {k}"), reason))?);
        }
        sets.push(strands);
    }
    let roots = sets.first().map(|dry| dry.iter().map(|strand| strand.root).collect()).unwrap_or_default();
    let strands: Vec<Strand> = sets.into_iter().flatten().collect();
    let scale = scale_for(frame.scale, &strands);
    let whole = |strand: &Strand| match &strand.exact {
        Some(exact) if scale == frame.scale => exact.clone(),
        _ => strand.points.iter().map(|point| point.stored(scale)).collect::<Vec<_>>(),
    };
    let points = strands.iter().flat_map(whole).zip(looks);
    let points = points.map(|(point, (color, visibility))| StoredStrandPoint { color, visibility, ..point });
    Ok(StoredStrands { points_per_strand: document.points_per_strand, scale, roots, points: points.collect() })
}
