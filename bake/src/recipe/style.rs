//! Styles of hair.

use pelage_params::words;

words! {
    /// Shape of a strand.
    Style {
        /// Stiff and smooth.
        #[default]
        Straight = "straight",
        /// Helices.
        Curly = "curly",
        /// Bent by a smooth random field, in waves.
        Messy = "messy",
        /// Gathered into pointed locks that are flat, dark and shiny.
        Wet = "wet",
        /// Combed flat.
        Lying = "lying",
    }
}
