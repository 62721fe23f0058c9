//! Knobs of a recipe. Choosing a coat changes the values of other knobs.

use pelage_bake::recipe::Recipe;
use pelage_params::{Knob, TableInfo, Tables as _};
use pelage_viewer::Knobs;

/// Recipe whose keys are shown as knobs.
#[derive(Clone, Debug)]
pub struct RecipeKnobs(pub Recipe);

impl Knobs for RecipeKnobs {
    fn tables(&self) -> &'static [TableInfo] {
        Recipe::TABLES
    }

    fn value(&self, knob: &Knob) -> Option<String> {
        knob.value(&self.0)
    }

    fn default_value(&self, knob: &Knob) -> Option<String> {
        // A recipe with a coat gets the values of that coat for its unset keys.
        let of_coat = Recipe::of_coat(self.0.hair.coat).unwrap_or_default();
        let plain = Recipe::default();
        knob.value(if knob.name == "hair.coat" { &plain } else { &of_coat })
    }

    fn set(&mut self, assignment: &str) -> Result<(), String> {
        self.0.set(assignment).map_err(|error| error.to_string())
    }

    fn boxed(&self) -> Box<dyn Knobs> {
        Box::new(self.clone())
    }
}
