//! How a frame is drawn.

use super::fur::FurParams;
use super::ink::InkParams;

/// How a frame is drawn.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Style {
    /// With the models' fur.
    Fur(FurParams),
    /// The skin alone, in its base colour. Its light is rolled off towards the sum of all lights, so that white skin shows its form.
    Bare,
    /// As an ink-wash painting (Fang 2006), for packages that have the style. There is no light in it: lights, shadows and casters have no
    /// effect. The paper is that of the first instance.
    Ink(InkParams),
}

/// A style without its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum StyleKind {
    /// [`Style::Fur`].
    Fur,
    /// [`Style::Bare`].
    Bare,
    /// [`Style::Ink`].
    Ink,
}

impl Default for Style {
    /// Fur with everything at its default.
    fn default() -> Self {
        Self::Fur(FurParams::default())
    }
}

impl Style {
    /// Which style it is.
    pub fn kind(&self) -> StyleKind {
        match self {
            Self::Fur(_) => StyleKind::Fur,
            Self::Bare => StyleKind::Bare,
            Self::Ink(_) => StyleKind::Ink,
        }
    }

    /// The parameters of fur, where it is that.
    pub fn fur(&self) -> Option<&FurParams> {
        if let Self::Fur(fur) = self { Some(fur) } else { None }
    }

    /// The parameters of ink, where it is that.
    pub fn ink(&self) -> Option<&InkParams> {
        if let Self::Ink(ink) = self { Some(ink) } else { None }
    }
}
