//! USD as text: the prims of type `BasisCurves` that a scene shows at rest, in metres, y up.
//!
//! Read without recursion: a file may nest brackets and prims to any depth. Transforms, visibility and the first time
//! sample of each attribute are respected; references, variants and instancers are not, which is reported.

mod curve_set;
mod curves;
mod lexer;
mod xform;

#[cfg(test)]
mod tests;

use super::source::Source;
use crate::error::BakeError;
use crate::guides::Guides;
use curve_set::CurveSet;
use glam::{DMat4, DVec3, DVec4};
use lexer::{Lexer, MOST_NUMBERS, Token};
use xform::Xform;

/// Maximum depth of nested prims.
const MOST_DEPTH: usize = 256;
/// Metadata that names other files or prims.
const REFERENCES: [&str; 5] = ["references", "payload", "inherits", "specializes", "subLayers"];
/// Length of a unit if the file does not set it, metres (USD's default).
const DEFAULT_METERS_PER_UNIT: f64 = 0.01;

pub(super) fn read(source: Source<'_>) -> Result<Guides, BakeError> {
    if source.bytes.starts_with(b"PXR-USDC") || source.bytes.starts_with(b"PK") {
        let reason = "binary USD, expected USD as text: export it as .usda, or run usdcat -o hair.usda FILE";
        return Err(source.fault("byte 0".into(), reason));
    }
    let text = source.text()?;
    if !text.starts_with("#usda ") {
        let start: String = text.chars().take(8).collect();
        return Err(source.fault("line 1".into(), format!("{start:?}, expected \"#usda 1.0\"")));
    }
    let lexer = Lexer::new(source, &text);
    let mut layer = Layer {
        lexer,
        prims: Vec::new(),
        meters_per_unit: None,
        is_z_up: false,
        nodes: Vec::new(),
        curves: Vec::new(),
        other_curves: 0,
        references: 0,
        hidden: 0,
    };
    layer.read()?;
    layer.guides()
}

/// Transform of a prim.
struct Node {
    /// Index of the parent's node; `None` if the prim is in world space.
    parent: Option<usize>,
    /// Matrix to the parent's space.
    matrix: DMat4,
}

struct Prim<'a> {
    name: &'a str,
    /// Whether the prim and its children are not shown.
    is_hidden: bool,
    xform: Xform<'a>,
    /// Contents of a prim of type `BasisCurves`.
    curves: Option<CurveSet<'a>>,
    /// Index of the prim's node.
    node: usize,
    /// Number of sets of curves when the prim began.
    first_curves: usize,
}

struct Layer<'a> {
    lexer: Lexer<'a>,
    /// Prims that are open, the outermost first.
    prims: Vec<Prim<'a>>,
    meters_per_unit: Option<f64>,
    is_z_up: bool,
    /// Nodes of the open prims, and of those with curves in or below them.
    nodes: Vec<Node>,
    /// Curves of the closed prims, each with the index of its node.
    curves: Vec<(usize, CurveSet<'a>)>,
    /// Number of prims with other types of curves.
    other_curves: usize,
    /// Number of references and sets of variants.
    references: usize,
    /// Number of sets of curves that are not shown.
    hidden: usize,
}

impl<'a> Layer<'a> {
    fn read(&mut self) -> Result<(), BakeError> {
        loop {
            match self.lexer.next()? {
                Token::Break => {}
                Token::Word("def") => self.open(false)?,
                Token::Word("over" | "class") => self.open(true)?,
                Token::Mark('(') if self.prims.is_empty() => self.metadata()?,
                Token::Word(word) => self.property(word)?,
                Token::Mark('}') if !self.prims.is_empty() => self.close(),
                Token::End => match self.prims.last() {
                    Some(prim) => return Err(self.lexer.fault(format!("the file ends within prim {:?}", prim.name))),
                    None => return Ok(()),
                },
                other => return Err(self.lexer.unexpected(other, "a prim or a property")),
            }
        }
    }

    fn metadata(&mut self) -> Result<(), BakeError> {
        let (meters_per_unit, is_z_up) = (&mut self.meters_per_unit, &mut self.is_z_up);
        let references = &mut self.references;
        self.lexer.skip_brackets(|key, value| match (key, value) {
            ("metersPerUnit", Token::Word(number)) => {
                *meters_per_unit = number.parse().ok().filter(|unit_m: &f64| *unit_m > 0.0 && unit_m.is_finite());
            }
            ("upAxis", Token::Text(axis)) => *is_z_up = axis == "Z",
            _ => *references += usize::from(REFERENCES.contains(&key)),
        })
    }

    /// Reads the beginning of a prim, up to its first bracket.
    fn open(&mut self, mut is_hidden: bool) -> Result<(), BakeError> {
        let mut kind = "";
        if let Token::Word(word) = self.lexer.peek()? {
            kind = word;
            self.lexer.next()?;
        }
        let name = self.lexer.string()?;
        let references = &mut self.references;
        loop {
            match self.lexer.next()? {
                Token::Break => {}
                Token::Mark('(') => self.lexer.skip_brackets(|key, value| {
                    is_hidden |= key == "active" && value == Token::Word("false");
                    *references += usize::from(REFERENCES.contains(&key));
                })?,
                Token::Mark('{') => break,
                other => return Err(self.lexer.unexpected(other, "{")),
            }
        }
        if self.prims.len() == MOST_DEPTH {
            return Err(self.lexer.fault(format!("prims are nested deeper than {MOST_DEPTH} levels")));
        }
        self.other_curves += usize::from(matches!(kind, "NurbsCurves" | "HermiteCurves"));
        let curves = (kind == "BasisCurves").then(|| CurveSet::new(name));
        let (node, first_curves) = (self.nodes.len(), self.curves.len());
        self.nodes.push(Node { parent: self.prims.last().map(|prim| prim.node), matrix: DMat4::IDENTITY });
        self.prims.push(Prim { name, is_hidden, xform: Xform::default(), curves, node, first_curves });
        Ok(())
    }

    /// Ends the innermost prim. Only now are all of its properties known.
    fn close(&mut self) {
        let Some(prim) = self.prims.pop() else { return };
        let node = &mut self.nodes[prim.node];
        let (matrix, is_world) = prim.xform.matrix();
        node.matrix = matrix;
        node.parent = node.parent.filter(|_| !is_world);
        self.curves.extend(prim.curves.map(|curves| (prim.node, curves)));
        if prim.is_hidden {
            self.hidden += self.curves.len() - prim.first_curves;
            self.curves.truncate(prim.first_curves);
        }
        if self.curves.len() == prim.first_curves {
            self.nodes.truncate(prim.node);
        }
    }

    /// Reads a property whose first word is `word`: `uniform token[] name = value (metadata)`.
    fn property(&mut self, word: &'a str) -> Result<(), BakeError> {
        self.references += usize::from(word == "variantSet");
        let mut name = word;
        loop {
            match self.lexer.peek()? {
                Token::Word(word) => name = word,
                Token::Mark('=') => {
                    self.lexer.next()?;
                    self.value(name)?;
                    continue;
                }
                Token::Mark('(') => {
                    self.lexer.next()?;
                    self.lexer.skip_brackets(|_, _| ())?;
                    continue;
                }
                Token::Mark('[' | ']') | Token::Text(_) => {}
                Token::Break | Token::Mark('}') | Token::End => return Ok(()),
                other => return Err(self.lexer.unexpected(other, "a property")),
            }
            self.lexer.next()?;
        }
    }

    /// Reads the value of a property: its default, or its first time sample.
    fn value(&mut self, name: &'a str) -> Result<(), BakeError> {
        let Some(name) = name.strip_suffix(".timeSamples") else { return self.attribute(name) };
        if self.lexer.next()? != Token::Mark('{') {
            return Err(self.lexer.fault(format!("{name}: expected time samples in brackets")));
        }
        let mut is_first = true;
        loop {
            match self.lexer.next()? {
                Token::Break | Token::Mark(',') => {}
                Token::Mark('}') => return Ok(()),
                // `24: value`, also with a space before the colon.
                Token::Word(_) => {
                    if self.lexer.peek()? == Token::Word(":") {
                        self.lexer.next()?;
                    }
                    if std::mem::take(&mut is_first) { self.attribute(name)? } else { self.lexer.skip_value()? }
                }
                other => return Err(self.lexer.unexpected(other, "a time")),
            }
        }
    }

    fn attribute(&mut self, name: &'a str) -> Result<(), BakeError> {
        let lexer = &mut self.lexer;
        let Some(prim) = self.prims.last_mut() else { return lexer.skip_value() };
        if name == "xformOpOrder" {
            prim.xform.order = lexer.strings()?;
            return Ok(());
        }
        if name.starts_with("xformOp:") {
            prim.xform.operations.push((name, lexer.numbers(0, 16)?));
            return Ok(());
        }
        if let Token::Text(text) = lexer.peek()? {
            prim.is_hidden |= name == "visibility" && text == "invisible";
            prim.curves.iter_mut().for_each(|curves| curves.set_token(name, text));
        }
        let Some(curves) = &mut prim.curves else { return lexer.skip_value() };
        match name {
            "curveVertexCounts" => curves.counts = lexer.numbers(0, MOST_NUMBERS)?,
            "points" => curves.points = lexer.numbers(3, MOST_NUMBERS)?,
            "widths" | "primvars:widths" => curves.widths = lexer.numbers(0, MOST_NUMBERS)?,
            "primvars:displayColor" => curves.colors = lexer.numbers(3, MOST_NUMBERS)?,
            // Colours in a palette are not read.
            "primvars:displayColor:indices" => {
                curves.has_palette = true;
                lexer.skip_value()?;
            }
            _ => lexer.skip_value()?,
        }
        Ok(())
    }

    /// Returns the strands in metres, y up.
    fn guides(self) -> Result<Guides, BakeError> {
        let mut guides = Guides::default();
        let unit_m = self.meters_per_unit.unwrap_or(DEFAULT_METERS_PER_UNIT);
        let upright = match self.is_z_up {
            true => DMat4::from_cols(DVec4::X, DVec4::NEG_Z, DVec4::Y, DVec4::W),
            false => DMat4::IDENTITY,
        };
        for (node, curves) in &self.curves {
            let mut matrix = DMat4::IDENTITY;
            let mut next = Some(*node);
            while let Some(node) = next.map(|node| &self.nodes[node]) {
                matrix = node.matrix * matrix;
                next = node.parent;
            }
            let matrix = DMat4::from_scale(DVec3::splat(unit_m)) * upright * matrix;
            let place = |reason| self.lexer.fault_in(&format!("prim {:?}", curves.name), reason);
            curves.push_to(&mut guides, &matrix).map_err(place)?;
        }
        let mut warn =
            |count: usize, text: &str| guides.warnings.extend((count > 0).then(|| format!("{count} {text}")));
        warn(self.hidden, "prims with curves are invisible, inactive or not defined, and left out");
        warn(self.other_curves, "prims have NURBS or Hermite curves, which are not read; expected BasisCurves");
        warn(self.references, "references to other prims or files, or sets of variants, are not read");
        if self.curves.is_empty() {
            let mut reason = "the file has no strands, expected a visible prim of type BasisCurves".to_owned();
            guides.warnings.iter().for_each(|warning| reason += &format!("; {warning}"));
            return Err(self.lexer.fault_in("whole file", reason));
        }
        if self.meters_per_unit.is_none() {
            guides.warnings.push(format!("it has no metersPerUnit: a unit is {unit_m} m, the default of USD"));
        }
        Ok(guides)
    }
}
