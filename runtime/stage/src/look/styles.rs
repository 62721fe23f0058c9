//! Built-in looks, which `--look NAME` and the front ends offer.

use super::{Look, LookBrush, LookInk, LookStyle};
use std::sync::LazyLock;

/// Look that is part of the crate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuiltInLook {
    /// Name.
    pub name: &'static str,
    /// Description in one sentence.
    pub about: &'static str,
    /// Text of the look file.
    pub text: &'static str,
}

/// Built-in looks: styles of ink painting.
pub const BUILT_IN_LOOKS: [BuiltInLook; 4] = [
    BuiltInLook {
        name: "gongbi",
        about: "Fine lines of even width around even washes, on sized paper.",
        text: "[picture]\nstyle = \"ink\"\n[ink]\nlines = \"strokes\"\npressure = 0.3\n[brush]\nstrokes = 110\n\
               wash = 0.6\nwetness = 0.8\ndryness = 0.1\ntufts = 90\nline_width = 0.6\nomission = 0.15\n\
               ground = 0\nsheet = \"sized\"\n",
    },
    BuiltInLook {
        name: "xieyi",
        about: "Few, broad and free strokes; much is left to the paper.",
        text: "[picture]\nstyle = \"ink\"\n[ink]\nlines = \"strokes\"\n[brush]\nstrokes = 26\nwash = 1.3\n\
               wetness = 0.9\ndryness = 0.65\ntufts = 16\nline_width = 1.7\nground = 0.7\n",
    },
    BuiltInLook {
        name: "dry",
        about: "Dry brush: broken lines and fur of single bristles, hardly any wash.",
        text: "[picture]\nstyle = \"ink\"\n[ink]\nlines = \"strokes\"\n[brush]\nstrokes = 120\nwash = 0.3\n\
               wetness = 0.1\ndryness = 1\ntufts = 140\nline_width = 1.1\nomission = 0.6\nground = 0.3\n",
    },
    BuiltInLook {
        name: "wet",
        about: "Wet washes that run into each other, few lines.",
        text: "[picture]\nstyle = \"ink\"\n[ink]\nlines = \"strokes\"\n[brush]\nstrokes = 40\nwash = 1.35\n\
               wetness = 1\ndryness = 0.1\ntufts = 12\nline_width = 0.9\nground = 0.8\n",
    },
];

/// Name of the look with all knobs of ink at their defaults, beside those in [`BUILT_IN_LOOKS`].
pub const DEFAULT_INK: &str = "default";

/// Style of ink: its name, its description, and the tables of the look that it sets.
type InkStyle = (&'static str, &'static str, LookInk, LookBrush);

/// Styles of ink, read only once, because a window asks for them in each frame.
static INK_STYLES: LazyLock<Vec<InkStyle>> = LazyLock::new(|| {
    let default = BuiltInLook { name: DEFAULT_INK, about: "All knobs of ink at their defaults.", text: "" };
    let read = |style: &BuiltInLook| {
        let mut look = Look::default();
        look.read(style.text).ok().map(|()| (style.name, style.about, look.ink, look.brush))
    };
    std::iter::once(&default).chain(&BUILT_IN_LOOKS).filter_map(read).collect()
});

impl Look {
    /// Returns name and description of each style of ink: [`DEFAULT_INK`], then [`BUILT_IN_LOOKS`].
    pub fn ink_styles() -> impl Iterator<Item = (&'static str, &'static str)> {
        INK_STYLES.iter().map(|(name, about, ..)| (*name, *about))
    }

    /// Changes the look to ink in the style of a built-in look, or of [`DEFAULT_INK`]. All knobs of the tables `ink`
    /// and `brush` get the style's values. Returns false, and changes nothing, if there is no such style.
    pub fn set_ink_style(&mut self, name: &str) -> bool {
        let Some((.., ink, brush)) = INK_STYLES.iter().find(|style| style.0 == name) else { return false };
        self.picture.style = LookStyle::Ink;
        (self.ink, self.brush) = (ink.clone(), brush.clone());
        true
    }

    /// Returns the name of the built-in look that has the same values in the tables `ink` and `brush`, [`DEFAULT_INK`]
    /// if they are all defaults, or `None`.
    pub fn ink_style(&self) -> Option<&'static str> {
        let is_own = |(.., ink, brush): &&InkStyle| (ink, brush) == (&self.ink, &self.brush);
        INK_STYLES.iter().find(is_own).map(|style| style.0)
    }
}

#[cfg(test)]
mod tests {
    use super::{BUILT_IN_LOOKS, DEFAULT_INK};
    use crate::{Look, LookStyle};

    #[test]
    fn ink_styles_replace_each_other() {
        let mut look = Look::default();
        assert_eq!(look.ink_style(), Some(DEFAULT_INK));
        for style in BUILT_IN_LOOKS {
            assert!(look.set_ink_style(style.name));
            assert_eq!((look.picture.style, look.ink_style()), (LookStyle::Ink, Some(style.name)));
        }
        look.brush.wash = 0.123;
        assert_eq!(look.ink_style(), None);
        let before = look.clone();
        assert!(!look.set_ink_style("oil"));
        assert_eq!(look, before);
        assert!(look.set_ink_style(DEFAULT_INK));
        look.picture.style = LookStyle::Fur;
        assert_eq!(look, Look::default());
    }

    #[test]
    fn built_in_looks_are_valid_and_differ() {
        let looks = BUILT_IN_LOOKS.map(|style| {
            let mut look = Look::default();
            look.read(style.text).unwrap_or_else(|error| panic!("{}: {error}", style.name));
            assert_eq!(look.picture.style, LookStyle::Ink, "{}", style.name);
            look
        });
        for (i, look) in looks.iter().enumerate() {
            assert!(looks[..i].iter().all(|other| other != look), "{}", BUILT_IN_LOOKS[i].name);
        }
    }
}
