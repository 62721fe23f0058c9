//! Rendering style of a frame.

use super::fur::FurParams;
use super::ink::InkParams;

/// Rendering style of a frame.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Style {
    /// Fur of the models.
    Fur(FurParams),
    /// Bare mesh surface in its base colour. The more light it receives, the more that light is compressed: even the
    /// sum of all lights does not exceed white. White surfaces thus keep visible shading.
    Bare,
    /// Ink-wash painting (Fang 2006), for packages with an ink style. The style is unlit: lights, shadows and casters
    /// have no effect. The paper is that of the first instance.
    Ink(InkParams),
}

/// Style of a frame without its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum StyleKind {
    /// Kind of [`Style::Fur`].
    Fur,
    /// Kind of [`Style::Bare`].
    Bare,
    /// Kind of [`Style::Ink`].
    Ink,
}

impl Default for Style {
    /// Returns the fur style with default parameters.
    fn default() -> Self {
        Self::Fur(FurParams::default())
    }
}

impl Style {
    /// Returns the kind of the style.
    pub fn kind(&self) -> StyleKind {
        match self {
            Self::Fur(_) => StyleKind::Fur,
            Self::Bare => StyleKind::Bare,
            Self::Ink(_) => StyleKind::Ink,
        }
    }

    /// Returns the fur parameters, if this is [`Style::Fur`].
    pub fn fur(&self) -> Option<&FurParams> {
        if let Self::Fur(fur) = self { Some(fur) } else { None }
    }

    /// Returns the ink parameters, if this is [`Style::Ink`].
    pub fn ink(&self) -> Option<&InkParams> {
        if let Self::Ink(ink) = self { Some(ink) } else { None }
    }
}
