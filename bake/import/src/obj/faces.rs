//! OBJ statements that define the shape: vertex data, faces, and their grouping.

use super::fault::fault;
use super::statements::{KEYWORDS, Statement, Statements};
use crate::BakeError;
use crate::json::shorten;
use crate::notes::Notes;
use glam::{Vec2, Vec3};
use pelage_formats::meaning::srgb_value_to_linear;
use std::collections::{BTreeMap, HashMap};

/// A corner of a face: indices into [`Faces::positions`], [`Faces::uvs`] and [`Faces::normals`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Corner {
    pub position: u32,
    pub uv: Option<u32>,
    pub normal: Option<u32>,
}

/// A polygon of at least three corners.
#[derive(Debug)]
pub(super) struct Face {
    pub line: usize,
    /// Index of the face's first corner in [`Faces::corners`].
    pub first: usize,
    pub count: usize,
    /// Index into [`Faces::parts`].
    pub part: usize,
}

/// Object, group and material that a face belongs to.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Part {
    pub object: String,
    pub group: String,
    /// Name given by `usemtl`; empty for none.
    pub material: String,
}

impl Part {
    /// Returns the part's description for messages.
    pub fn label(&self) -> String {
        let all = [("object", &self.object), ("group", &self.group), ("material", &self.material)];
        let named: Vec<String> = all
            .iter()
            .filter(|(_, name)| !name.is_empty())
            .map(|(what, name)| format!("{what} \"{}\"", shorten(name)))
            .collect();
        if named.is_empty() { "the faces without a name".to_owned() } else { named.join(", ") }
    }

    /// Returns the names of object and group; empty names are omitted.
    pub fn names(&self) -> Vec<String> {
        [&self.object, &self.group].into_iter().filter(|name| !name.is_empty()).cloned().collect()
    }
}

/// Faces of a file, with every index in range.
#[derive(Debug, Default)]
pub(super) struct Faces {
    /// Positions, metres.
    pub positions: Vec<Vec3>,
    /// Linear RGBA, one per position. If there are fewer, the remaining positions are white.
    pub colors: Vec<[u8; 4]>,
    /// Texture coordinates; v increases downwards.
    pub uvs: Vec<Vec2>,
    pub normals: Vec<Vec3>,
    pub corners: Vec<Corner>,
    pub list: Vec<Face>,
    pub parts: Vec<Part>,
    /// Distinct arguments of `mtllib`, with their lines.
    pub libraries: Vec<(usize, String)>,
}

impl Faces {
    /// Reads all statements; `unit_m` is the length of one unit, metres.
    pub fn read(file: &str, text: &str, unit_m: f32, notes: &mut Notes) -> Result<Self, BakeError> {
        let mut reader = Reader { file, unit_m, faces: Self::default(), ..Reader::default() };
        for statement in Statements::new(text) {
            reader.statement(&statement)?;
        }
        reader.finish(notes)
    }
}

/// Statements that do not affect fur, with the number of each.
#[derive(Default)]
struct IgnoredStatements {
    points: usize,
    lines: usize,
    free_form: usize,
    /// Number of faces with fewer than three corners, and the line of the first.
    small: (usize, usize),
    /// Number of texture coordinates that are not finite.
    uvs: usize,
    /// Unknown keywords, each with the line of its first use and its count.
    unknown: BTreeMap<String, (usize, usize)>,
}

/// Maximum number of different unknown keywords reported.
const MAX_UNKNOWN: usize = 20;

/// Lists of vertex data to which the corners of faces refer by index.
#[derive(Clone, Copy)]
enum List {
    Positions,
    Uvs,
    Normals,
}

#[derive(Default)]
struct Reader<'a> {
    file: &'a str,
    unit_m: f32,
    faces: Faces,
    /// Part to which the next face belongs.
    part: Part,
    /// Index of `part`, once a face has used it.
    part_index: Option<usize>,
    part_indices: HashMap<Part, usize>,
    left_out: IgnoredStatements,
}

impl Reader<'_> {
    fn statement(&mut self, s: &Statement<'_>) -> Result<(), BakeError> {
        match s.keyword() {
            "v" => self.vertex(s)?,
            "vt" => {
                let ([u, v, _], _) = s.floats::<3>(self.file, 1)?;
                let uv = Vec2::new(u, 1.0 - v);
                self.left_out.uvs += usize::from(!uv.is_finite());
                self.faces.uvs.push(if uv.is_finite() { uv } else { Vec2::ZERO });
            }
            // Accepts normals that are not finite: computed normals replace them later.
            "vn" => self.faces.normals.push(s.floats::<3>(self.file, 3)?.0.into()),
            // `fo` is the deprecated form of `f`.
            "f" | "fo" => self.face(s)?,
            "o" => self.enter(|part| s.name().clone_into(&mut part.object)),
            "g" => self.enter(|part| s.name().clone_into(&mut part.group)),
            "usemtl" => self.enter(|part| s.name().clone_into(&mut part.material)),
            "mtllib" => {
                if !self.faces.libraries.iter().any(|(_, name)| name == s.name()) {
                    self.faces.libraries.push((s.line, s.name().to_owned()));
                }
            }
            "p" => self.left_out.points += 1,
            "l" => self.left_out.lines += 1,
            "curv" | "curv2" | "surf" => self.left_out.free_form += 1,
            known if KEYWORDS.contains(&known) => {}
            unknown => {
                let unknown = shorten(unknown);
                let map = &mut self.left_out.unknown;
                if map.len() < MAX_UNKNOWN || map.contains_key(&unknown) {
                    map.entry(unknown).or_insert((s.line, 0)).1 += 1;
                }
            }
        }
        Ok(())
    }

    fn vertex(&mut self, s: &Statement<'_>) -> Result<(), BakeError> {
        let (n, count) = s.numbers::<7>(self.file, 3)?;
        // A fourth number is the weight of a rational curve. A colour may follow either the position or the weight.
        let color = match count {
            6 => Some([n[3], n[4], n[5]]),
            7 => Some([n[4], n[5], n[6]]),
            5 => {
                return Err(s.fault(
                    self.file,
                    "`v` has 5 numbers, expected 3 (x y z), 4 (x y z w), 6 (x y z r g b) \
                 or 7 (x y z w r g b)",
                ));
            }
            _ => None,
        };
        let position = Vec3::new(n[0], n[1], n[2]) * self.unit_m;
        if !position.is_finite() {
            let unit = self.unit_m;
            return Err(s.fault(self.file, format!("is at {position} with units of {unit} m, expected finite numbers")));
        }
        if let Some(color) = color {
            // Tools that write colours (MeshLab, Blender) encode them as sRGB, 0..=1.
            let byte = |x: f32| (srgb_value_to_linear(x.clamp(0.0, 1.0)) * 255.0).round() as u8;
            let [r, g, b] = color.map(byte);
            self.faces.colors.resize(self.faces.positions.len(), [255; 4]);
            self.faces.colors.push([r, g, b, 255]);
        }
        self.faces.positions.push(position);
        Ok(())
    }

    fn face(&mut self, s: &Statement<'_>) -> Result<(), BakeError> {
        let first = self.faces.corners.len();
        for word in s.words() {
            let corner = self.corner(s, word)?;
            self.faces.corners.push(corner);
        }
        let count = self.faces.corners.len() - first;
        if count < 3 {
            self.faces.corners.truncate(first);
            let small = &mut self.left_out.small;
            *small = (small.0 + 1, if small.0 == 0 { s.line } else { small.1 });
            return Ok(());
        }
        let part = match self.part_index {
            Some(part) => part,
            None => {
                let next = self.faces.parts.len();
                let part = *self.part_indices.entry(self.part.clone()).or_insert(next);
                if part == next {
                    self.faces.parts.push(self.part.clone());
                }
                *self.part_index.insert(part)
            }
        };
        self.faces.list.push(Face { line: s.line, first, count, part });
        Ok(())
    }

    fn enter(&mut self, change: impl FnOnce(&mut Part)) {
        change(&mut self.part);
        self.part_index = None;
    }

    /// Parses `position`, `position/uv`, `position//normal` or `position/uv/normal`. A number after a slash may be
    /// missing.
    fn corner(&self, s: &Statement<'_>, word: &str) -> Result<Corner, BakeError> {
        let mut pieces = word.split('/');
        let index = |list: List, text: Option<&str>| match text {
            None | Some("") => Ok(None),
            Some(text) => self.index(s, word, list, text).map(Some),
        };
        let position = index(List::Positions, pieces.next())?;
        let (uv, normal) = (index(List::Uvs, pieces.next())?, index(List::Normals, pieces.next())?);
        match position {
            Some(position) if pieces.next().is_none() => Ok(Corner { position, uv, normal }),
            _ => Err(s.unexpected(self.file, word, "a corner such as 3, 3/1, 3//2 or 3/1/2")),
        }
    }

    /// Parses an index and converts it to zero-based. Does not check the upper bound, because a face may precede its
    /// vertices.
    fn index(&self, s: &Statement<'_>, word: &str, list: List, text: &str) -> Result<u32, BakeError> {
        let have = self.count(list) as i64;
        let found: i64 = text.parse().map_err(|_| s.unexpected(self.file, word, "whole numbers, such as 3/1/2"))?;
        let index = if found < 0 { have + found } else { found - 1 };
        if found == 0 || index < 0 {
            let name = list.name();
            let expected = format!("a {name} index from 1, or from -{have} to -1 counting back from here");
            return Err(s.unexpected(self.file, word, &expected));
        }
        // An index too large for u32 becomes `u32::MAX`. No list has so many entries, so the check at the end rejects
        // the index and reports the list's length.
        Ok(u32::try_from(index).unwrap_or(u32::MAX))
    }

    fn count(&self, list: List) -> usize {
        match list {
            List::Positions => self.faces.positions.len(),
            List::Uvs => self.faces.uvs.len(),
            List::Normals => self.faces.normals.len(),
        }
    }

    fn finish(mut self, notes: &mut Notes) -> Result<Faces, BakeError> {
        self.check_indices(notes)?;
        let left_out = &self.left_out;
        for (count, what) in [
            (left_out.points, "`p` statements (points)"),
            (left_out.lines, "`l` statements (lines)"),
            (left_out.free_form, "free-form curves and surfaces"),
        ] {
            if count > 0 {
                notes.warn(format!("{count} {what} left out, expected faces"));
            }
        }
        let (small, line) = left_out.small;
        if small > 0 {
            notes.warn(format!("{small} faces of fewer than 3 corners left out, the first in line {line}"));
        }
        if left_out.uvs > 0 {
            notes.warn(format!("{} texture coordinates are not finite; set to 0", left_out.uvs));
        }
        for (keyword, (line, count)) in &left_out.unknown {
            notes.warn(format!("line {line}: `{keyword}` is not an OBJ statement; {count} lines left out"));
        }
        if self.faces.list.is_empty() {
            let reason = format!(
                "the file has no faces, expected at least one; it has {} vertices, {} points and {} lines",
                self.faces.positions.len(),
                left_out.points,
                left_out.lines
            );
            return Err(BakeError::Input { file: self.file.into(), place: "whole file".into(), reason });
        }
        Ok(self.faces)
    }

    /// Checks the indices of the corners, now that all lists are complete.
    ///
    /// If the file has no normals at all, corners may still name them: exporters write `1//1` out of habit, and the
    /// shape is unaffected. The same applies to texture coordinates.
    fn check_indices(&mut self, notes: &mut Notes) -> Result<(), BakeError> {
        let [positions, uvs, normals] = [List::Positions, List::Uvs, List::Normals].map(|list| self.count(list));
        let mut ignored = [0, 0];
        for face in &self.faces.list {
            for (k, corner) in self.faces.corners[face.first..face.first + face.count].iter_mut().enumerate() {
                if uvs == 0 {
                    ignored[0] += usize::from(corner.uv.take().is_some());
                }
                if normals == 0 {
                    ignored[1] += usize::from(corner.normal.take().is_some());
                }
                for (index, count, list) in [
                    (Some(corner.position), positions, List::Positions),
                    (corner.uv, uvs, List::Uvs),
                    (corner.normal, normals, List::Normals),
                ] {
                    if let Some(index) = index.filter(|i| *i as usize >= count) {
                        let (found, name) = (u64::from(index) + 1, list.name());
                        let reason =
                            format!("corner {} has {name} {found}, expected 1..={count}: the file has no more", k + 1);
                        return Err(fault(self.file, face.line, reason));
                    }
                }
            }
        }
        for (count, list) in [(ignored[0], List::Uvs), (ignored[1], List::Normals)] {
            if count > 0 {
                let name = list.name();
                notes.warn(format!("{count} corners refer to a {name}, but the file has none; read without it"));
            }
        }
        Ok(())
    }
}

impl List {
    fn name(self) -> &'static str {
        match self {
            Self::Positions => "vertex",
            Self::Uvs => "texture coordinate",
            Self::Normals => "normal",
        }
    }
}
