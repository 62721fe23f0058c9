//! Tone mapping of fur and skin.

/// Conversion of light to colours that a screen can show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ToneMapping {
    /// None: the application maps tones itself, or light stays below 1.
    #[default]
    Off,
    /// Filmic shoulder: channels above 0.7 are compressed below 1 (formulas 1.4). The style ink is unchanged.
    Filmic,
}
