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
        /// Bent by a smooth random field.
        Messy = "messy",
        /// Gathered into pointed locks, low, dark and shiny.
        Wet = "wet",
        /// Combed flat.
        Lying = "lying",
    }
}
