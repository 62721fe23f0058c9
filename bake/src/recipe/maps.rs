//! Values that vary over the model: each is a constant, the model's vertex colours, or an image.
//!
//! In a recipe, a map is a constant (`0.5`, `[0, 0, 1]`, `"#8c7c6c"`), `"vertex"` for the vertex colours, or an image's
//! path relative to the recipe. A channel other than red, the default, is appended: `"vertex#a"`, `"maps/coat.png#g"`.

use pelage_params::{Field, Range, Raw, SrgbColor};

/// Word for the vertex colours in a recipe.
const VERTEX: &str = "vertex";

/// Channel of an image or of the vertex colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channel {
    /// `#r`, which is also the default.
    #[default]
    Red,
    /// `#g`.
    Green,
    /// `#b`.
    Blue,
    /// `#a`.
    Alpha,
}

impl Channel {
    const ALL: [(Self, char); 4] = [(Self::Red, 'r'), (Self::Green, 'g'), (Self::Blue, 'b'), (Self::Alpha, 'a')];

    /// Returns the index of the channel in a texel.
    pub fn index(self) -> usize {
        self as usize
    }

    fn suffix(self) -> String {
        Self::ALL
            .iter()
            .filter(|(c, _)| *c == self && self != Self::Red)
            .map(|(_, letter)| format!("#{letter}"))
            .collect()
    }

    fn from_letter(letter: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, l)| letter.chars().eq([*l])).map(|(c, _)| *c)
    }
}

/// Scalar that varies over the model. Images and vertex colours are read as 0..=1, without sRGB decoding.
#[derive(Clone, Debug, PartialEq)]
pub enum ScalarMap {
    /// Constant value.
    Constant(f32),
    /// Channel of the vertex colours (`COLOR_0`).
    Vertex(Channel),
    /// Channel of an image in the model's texture coordinates.
    Image {
        /// Path relative to the recipe's folder.
        path: String,
        /// Channel.
        channel: Channel,
    },
}

/// Direction that varies over the model. Its length, up to 1, is its weight relative to neighbouring directions.
#[derive(Clone, Debug, PartialEq)]
pub enum VectorMap {
    /// Constant direction: x, y, z of the model at rest.
    Constant([f32; 3]),
    /// Vertex colours: 2·rgb − 1 is x, y, z of the model at rest.
    Vertex,
    /// Image in the model's texture coordinates.
    Image {
        /// Path relative to the recipe's folder.
        path: String,
        /// Whether the suffix `#uv` is present. With it, 2·rg − 1 points right and up on the image; otherwise, 2·rgb −
        /// 1 is x, y, z of the model at rest.
        flow: bool,
    },
}

/// Colour that varies over the model.
#[derive(Clone, Debug, PartialEq)]
pub enum ColorMap {
    /// Constant colour.
    Constant(SrgbColor),
    /// Vertex colours.
    Vertex,
    /// sRGB image in the model's texture coordinates; the path is relative to the recipe's folder.
    Image(String),
}

/// Path of an image or strand file, relative to the recipe's folder, so that the folder can be moved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilePath(pub String);

/// Splits a path from the suffix after its last `#`.
fn split(text: &str) -> (&str, Option<&str>) {
    text.rsplit_once('#').map_or((text, None), |(path, suffix)| (path, Some(suffix)))
}

/// Returns the path if a recipe may name it; otherwise `None`.
fn file_path(text: &str) -> Option<String> {
    // Check for both kinds of slash and for drive letters, so that every operating system rejects the same recipes.
    let drive = text.as_bytes().get(1) == Some(&b':');
    let legal = !text.is_empty() && text != VERTEX && !text.starts_with(['/', '\\']) && !drive;
    (legal && !text.contains(['#', '\0'])).then(|| text.to_owned())
}

impl ScalarMap {
    /// Returns the path of the image, if the map is an image.
    pub fn image(&self) -> Option<&str> {
        if let Self::Image { path, .. } = self { Some(path) } else { None }
    }
}

impl VectorMap {
    /// Returns the path of the image, if the map is an image.
    pub fn image(&self) -> Option<&str> {
        if let Self::Image { path, .. } = self { Some(path) } else { None }
    }
}

impl ColorMap {
    /// Returns the path of the image, if the map is an image.
    pub fn image(&self) -> Option<&str> {
        if let Self::Image(path) = self { Some(path) } else { None }
    }
}

impl Field for ScalarMap {
    type Range = Range<f32>;

    fn expected(range: &Self::Range) -> String {
        format!(
            "{}, \"vertex\" or the relative path of an image (the last two may end in #r, #g, #b or \
             #a)",
            f32::expected(range)
        )
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        let Raw::String(text) = raw else { return f32::from_raw(raw).map(Self::Constant) };
        let (source, suffix) = split(text);
        let channel = suffix.map_or(Some(Channel::default()), Channel::from_letter)?;
        if source == VERTEX {
            return Some(Self::Vertex(channel));
        }
        file_path(source).map(|path| Self::Image { path, channel })
    }

    fn in_range(&self, range: &Self::Range) -> bool {
        match self {
            Self::Constant(value) => value.in_range(range),
            Self::Vertex(_) | Self::Image { .. } => true,
        }
    }

    fn to_toml(&self) -> Option<String> {
        match self {
            Self::Constant(value) => value.to_toml(),
            Self::Vertex(channel) => quoted(&format!("{VERTEX}{}", channel.suffix())),
            Self::Image { path, channel } => quoted(&format!("{path}{}", channel.suffix())),
        }
    }
}

impl Field for VectorMap {
    type Range = ();

    fn expected((): &()) -> String {
        "[x, y, z], \"vertex\" or the relative path of an image, which may end in #uv".into()
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        let Raw::String(text) = raw else { return <[f32; 3]>::from_raw(raw).map(Self::Constant) };
        match split(text) {
            (VERTEX, None) => Some(Self::Vertex),
            (path, None) => file_path(path).map(|path| Self::Image { path, flow: false }),
            (path, Some("uv")) => file_path(path).map(|path| Self::Image { path, flow: true }),
            _ => None,
        }
    }

    fn in_range(&self, (): &()) -> bool {
        match self {
            Self::Constant(v) => v.iter().all(|x| x.is_finite()) && v.iter().any(|x| *x != 0.0),
            Self::Vertex | Self::Image { .. } => true,
        }
    }

    fn to_toml(&self) -> Option<String> {
        match self {
            Self::Constant(v) => v.to_toml(),
            Self::Vertex => quoted(VERTEX),
            Self::Image { path, flow } => quoted(&format!("{path}{}", if *flow { "#uv" } else { "" })),
        }
    }
}

impl Field for ColorMap {
    type Range = ();

    fn expected((): &()) -> String {
        "\"#rrggbb\", [r, g, b] with numbers 0..=1, \"vertex\" or the relative path of an image".into()
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        match raw {
            Raw::String(text) if text == VERTEX => Some(Self::Vertex),
            Raw::String(text) if !text.starts_with('#') => file_path(text).map(Self::Image),
            _ => SrgbColor::from_raw(raw).map(Self::Constant),
        }
    }

    fn in_range(&self, (): &()) -> bool {
        match self {
            Self::Constant(color) => color.in_range(&()),
            Self::Vertex | Self::Image(_) => true,
        }
    }

    fn to_toml(&self) -> Option<String> {
        match self {
            Self::Constant(color) => color.to_toml(),
            Self::Vertex => quoted(VERTEX),
            Self::Image(path) => quoted(path),
        }
    }
}

impl Field for FilePath {
    type Range = ();

    fn expected((): &()) -> String {
        "the relative path of a file".into()
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        match raw {
            Raw::String(text) => file_path(text).map(Self),
            _ => None,
        }
    }

    fn to_toml(&self) -> Option<String> {
        quoted(&self.0)
    }
}

fn quoted(text: &str) -> Option<String> {
    Some(toml::Value::from(text).to_string())
}
