//! Styles of hair.

use pelage_params::words;

words! {
    /// The forces that shape a strand.
    Style {
        /// Stiff and smooth.
        #[default]
        Straight = "straight",
        /// Helices.
        Curly = "curly",
        /// Pushed about by a smooth random field.
        Messy = "messy",
        /// Gathered into pointed locks, low, dark and shiny.
        Wet = "wet",
        /// Combed down flat.
        Lying = "lying",
    }
}
