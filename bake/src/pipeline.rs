//! Steps of a bake in order, with their inputs and outputs. No mathematics is done here.
//!
//! The output of a step is stored under its name. A step runs if its output is missing and the package depends on it.
//! So a bake starts with the model alone, and slicing a package again starts with the package's contents
//! ([`crate::reslice`]). After [`Outputs::invalidate`], the named output and everything derived from it is made again.
//!
//! A step begins when its inputs are made, so that independent steps run on several threads at once.

mod input;
mod layout;
mod outputs;
mod run_step;
mod schedule;

pub use input::BakeInput;
pub use layout::{Layout, lay_out_model};
pub use outputs::{CachedStages, Groomed, Output, Outputs, PackageBytes, Shells, StrandVisibility};
pub use schedule::{OnStep, Step, StepEvent};

use crate::decision::Decision;
use crate::recipe::Recipe;
use crate::stages::surface::Measures;
use outputs::required;
use pelage_import::BakeError;
use pelage_import::mesh::Model;
use pelage_params::{Knob, Tables as _};

/// Stages after `import`, in the order of their first steps. They overlap.
pub const STAGES: [&str; 11] =
    ["surface", "simulate", "visibility", "slice", "groom", "fins", "ink", "contours", "textures", "scatter", "pack"];

use Output::*;

/// Recipe tables and keys that determine how the hair tile is laid out on the model. They affect everything derived
/// from the layout.
const LAYING: &[&str] = &[
    "model",
    "surface",
    "hair",
    "underfur",
    "groom",
    "color",
    "slice",
    "shading.model",
    "fibre.around",
    "fibre.eumelanin",
    "fibre.pheomelanin",
];

/// All tables of a recipe.
const ALL_TABLES: &[&str] = &{
    let mut names = [""; Recipe::TABLES.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = Recipe::TABLES[i].name;
        i += 1;
    }
    names
};

/// All steps, in order. Each line names the stage, output, inputs and recipe tables of a step.
pub const STEPS: &[Step] = &[
    Step { stage: "surface", makes: Layout, reads: &[Model], tables: LAYING, run: run_step::surface },
    Step { stage: "simulate", makes: Hair, reads: &[Layout], tables: &[], run: run_step::simulate },
    Step {
        stage: "visibility",
        makes: StrandVisibility,
        reads: &[Hair],
        tables: &["visibility"],
        run: run_step::visible,
    },
    Step {
        stage: "slice",
        makes: Shells,
        reads: &[Hair, StrandVisibility],
        tables: &["slice", "pack", "detail"],
        run: run_step::slice,
    },
    Step {
        stage: "slice",
        makes: Single,
        reads: &[Hair, StrandVisibility],
        tables: &["strands"],
        run: run_step::single,
    },
    Step { stage: "groom", makes: Groomed, reads: &[Model, Layout, Hair], tables: &[], run: run_step::groom },
    Step {
        stage: "groom",
        makes: Guided,
        reads: &[Model, Layout, Groomed],
        tables: &["strands"],
        run: run_step::guided,
    },
    Step { stage: "fins", makes: Fins, reads: &[Layout, Hair, Groomed], tables: &[], run: run_step::fins },
    Step {
        stage: "fins",
        makes: FinTextures,
        reads: &[Hair, Fins],
        tables: &["fins", "slice", "pack"],
        run: run_step::fin_textures,
    },
    Step { stage: "ink", makes: Ink, reads: &[Model, Layout, Groomed], tables: &["ink", "fins"], run: run_step::ink },
    Step {
        stage: "ink",
        makes: Painting,
        reads: &[Model, Layout, Groomed, Guided, Ink],
        tables: &["ink.enabled", "ink.seed"],
        run: run_step::painting,
    },
    Step {
        stage: "ink",
        makes: InkTextures,
        reads: &[Layout, Hair, Ink],
        tables: &["ink", "pack"],
        run: run_step::ink_textures,
    },
    Step {
        stage: "contours",
        makes: Contours,
        reads: &[Model, Layout, Groomed, Ink, Painting],
        tables: &["ink.enabled"],
        run: run_step::contours,
    },
    Step {
        stage: "textures",
        makes: Skin,
        reads: &[Model, Layout, Hair, Groomed],
        tables: &["pack", "detail", "shading.gloss", "shading.material"],
        run: run_step::skin,
    },
    Step {
        stage: "scatter",
        makes: Fibres,
        reads: &[Guided, Skin],
        tables: &["fibre", "shading.model"],
        run: run_step::scatter,
    },
    Step {
        stage: "pack",
        makes: Package,
        reads: &[Hair, Shells, Single, Guided, Fins, FinTextures, Fibres, Ink, Painting, InkTextures, Contours, Skin],
        // The package records the whole recipe, so this step depends on all tables.
        tables: ALL_TABLES,
        run: run_step::pack,
    },
];

/// Result of a bake.
#[derive(Clone, Debug)]
pub struct Baked {
    /// The package.
    pub package: Vec<u8>,
    /// Quality of the parameterization.
    pub measures: Measures,
    /// Values that the recipe left open and the bake chose.
    pub decisions: Vec<Decision>,
    /// Warnings: repairs, omissions and guesses.
    pub warnings: Vec<String>,
}

/// Bakes an imported model.
///
/// * `on_step`: called when a step begins or ends
///
/// Fails with [`BakeError::Params`] for a value outside its range, [`BakeError::Input`] if model and recipe do not fit
/// together, [`BakeError::Internal`] for a bug in this crate.
pub fn bake(input: &BakeInput<'_>, model: &Model, on_step: &mut OnStep<'_>) -> Result<Baked, BakeError> {
    let mut outputs = Outputs::of_model(model);
    run(input, &mut outputs, on_step)?;
    baked(&outputs)
}

pub(crate) fn baked(outputs: &Outputs<'_>) -> Result<Baked, BakeError> {
    let groomed = required(&outputs.groomed, Output::Groomed)?;
    let decisions = [&required(&outputs.laid, Output::Layout)?.decisions[..], &groomed.decisions].concat();
    let PackageBytes { bytes, warnings } = required(&outputs.package, Package)?.clone();
    Ok(Baked { package: bytes, measures: groomed.surface.measures, decisions, warnings })
}

/// Runs every step that the package depends on and whose output is missing. `on_step` is called when a step begins or
/// ends.
///
/// Fails with the errors of [`bake`]; [`BakeError::Internal`] if a required input is missing and no step makes it.
pub fn run<'a>(input: &BakeInput<'a>, outputs: &mut Outputs<'a>, on_step: &mut OnStep<'_>) -> Result<(), BakeError> {
    make(input, outputs, Package, on_step)
}

/// Runs the steps that the output `wanted` depends on, like [`run`] for the package.
///
/// Fails with the errors of [`run`].
pub fn make<'a>(
    input: &BakeInput<'a>,
    outputs: &mut Outputs<'a>,
    wanted: Output,
    on_step: &mut OnStep<'_>,
) -> Result<(), BakeError> {
    input.recipe.validate()?;
    let mut needed = vec![wanted];
    let mut steps = Vec::new();
    for step in STEPS.iter().rev() {
        if needed.contains(&step.makes) && !outputs.has(step.makes) {
            needed.extend(step.reads);
            steps.push(step);
        }
    }
    steps.reverse();
    schedule::run(input, outputs, &steps, on_step)
}

impl Outputs<'_> {
    /// Drops an output and everything derived from it, so that [`run`] makes them again.
    pub fn invalidate(&mut self, output: Output) {
        let mut gone = vec![output];
        for step in STEPS {
            if step.reads.iter().any(|read| gone.contains(read)) {
                gone.push(step.makes);
            }
        }
        gone.into_iter().for_each(|output| self.clear(output));
    }

    /// Drops the outputs affected by the difference between two recipes, so that [`run`] makes only those again.
    pub fn invalidate_changes(&mut self, before: &Recipe, after: &Recipe) {
        let text = |recipe: &Recipe, knob: &'static Knob| knob.value(recipe);
        let changed = |name: &&str| {
            let of_table = |knob: &Knob| knob.name.strip_prefix(*name).is_some_and(|key| key.starts_with('.'));
            let knobs = Recipe::TABLES.iter().flat_map(|info| info.knobs);
            let named = knobs.into_iter().filter(|knob| knob.name == *name || of_table(knob));
            named.into_iter().any(|knob| text(before, knob) != text(after, knob))
        };
        for step in STEPS {
            if step.tables.iter().any(changed) {
                self.invalidate(step.makes);
            }
        }
    }
}
