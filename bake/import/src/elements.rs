//! Elements read from an accessor, tightly packed, in the component type of the file.

use super::json::JsonNode;
use crate::BakeError;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    pub fn read(at: &JsonNode<'_>) -> Result<Self, BakeError> {
        Ok(match at.unsigned()? {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return Err(at.unexpected("5120 (i8), 5121 (u8), 5122 (i16), 5123 (u16), 5125 (u32) or 5126 (f32)")),
        })
    }

    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::I8 => "i8",
            Self::U8 => "u8",
            Self::I16 => "i16",
            Self::U16 => "u16",
            Self::U32 => "u32",
            Self::F32 => "f32",
        }
    }
}

/// Elements of an accessor, tightly packed, in the component type of the file.
#[derive(Debug)]
pub(super) struct Elements {
    pub count: usize,
    /// Number of components of an element.
    pub width: usize,
    pub component: Component,
    pub normalized: bool,
    pub bytes: Vec<u8>,
}

/// Component types of floating-point data: floats, and the types that KHR_mesh_quantization adds.
pub(super) const REAL: &[Component] = &[Component::F32, Component::I8, Component::U8, Component::I16, Component::U16];

/// Component types of indices.
pub(super) const WHOLE: &[Component] = &[Component::U8, Component::U16, Component::U32];

impl Elements {
    /// Packs elements of `width` numbers each, stored as `component`. Integers hold the number itself, not a fraction
    /// of their maximum.
    pub fn from_reals(values: &[f32], width: usize, component: Component, normalized: bool) -> Self {
        let bytes = match component {
            Component::F32 => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
            Component::I8 => values.iter().flat_map(|v| (*v as i8).to_le_bytes()).collect(),
            Component::U8 => values.iter().flat_map(|v| (*v as u8).to_le_bytes()).collect(),
            Component::I16 => values.iter().flat_map(|v| (*v as i16).to_le_bytes()).collect(),
            Component::U16 => values.iter().flat_map(|v| (*v as u16).to_le_bytes()).collect(),
            Component::U32 => values.iter().flat_map(|v| (*v as u32).to_le_bytes()).collect(),
        };
        Self { count: values.len() / width, width, component, normalized, bytes }
    }

    /// Returns all components as floats. Integers are divided by their maximum if the accessor is `normalized` or if
    /// `always` is set (glTF 2.0, section 3.11).
    pub fn to_f32s(&self, always: bool) -> Vec<f32> {
        let fraction = self.normalized || always;
        let over = |x: f32, max: f32| if fraction { (x / max).max(-1.0) } else { x };
        match self.component {
            Component::F32 => self.map(f32::from_le_bytes),
            Component::I8 => self.map(|b| over(i8::from_le_bytes(b).into(), 127.0)),
            Component::U8 => self.map(|b| over(u8::from_le_bytes(b).into(), 255.0)),
            Component::I16 => self.map(|b| over(i16::from_le_bytes(b).into(), 32_767.0)),
            Component::U16 => self.map(|b| over(u16::from_le_bytes(b).into(), 65_535.0)),
            Component::U32 => self.map(|b| u32::from_le_bytes(b) as f32),
        }
    }

    /// Returns all components as whole numbers. Requires a component type in [`WHOLE`].
    pub fn to_u32s(&self) -> Vec<u32> {
        match self.component {
            Component::U8 | Component::I8 => self.map(|b| u8::from_le_bytes(b).into()),
            Component::U16 | Component::I16 => self.map(|b| u16::from_le_bytes(b).into()),
            Component::U32 | Component::F32 => self.map(u32::from_le_bytes),
        }
    }

    fn map<const N: usize, T>(&self, convert: impl Fn([u8; N]) -> T) -> Vec<T> {
        let (chunks, _) = self.bytes.as_chunks::<N>();
        chunks.iter().map(|chunk| convert(*chunk)).collect()
    }
}

pub(super) fn grouped<const N: usize>(flat: &[f32]) -> impl ExactSizeIterator<Item = [f32; N]> + '_ {
    flat.as_chunks::<N>().0.iter().copied()
}

/// Returns the number of components of an element of the type at `at`.
pub(super) fn width_of(at: &JsonNode<'_>) -> Result<usize, BakeError> {
    Ok(match at.string()? {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        "MAT4" => 16,
        // The columns of these matrix types are padded to four bytes. No attribute that is read here uses them.
        "MAT2" | "MAT3" => return Err(at.unexpected("SCALAR, VEC2, VEC3, VEC4 or MAT4 here")),
        _ => return Err(at.unexpected("SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4")),
    })
}
