//! The way through bake: its steps in their order, what each reads and what it makes; no mathematics in here.
//!
//! What a step makes is kept under its name. A step runs where the package still to be made needs what it makes and that is not there yet. So a
//! bake starts with the model alone; slicing a package anew starts with what the package already holds ([`crate::reslice`]); and after
//! [`Outputs::forget`] everything from there on is made again, and nothing before it.

mod lay;

pub use lay::{Laid, lay};

use crate::BakeError;
use crate::decision::Decision;
use crate::mesh::{Image, Model};
use crate::recipe::{ColorParams, HairColors, InkParams, PackParams, Recipe, Style};
use crate::remade::Remade;
use crate::stages::detail;
use crate::stages::fins;
use crate::stages::groom::{
    self, Atlas, BesideBare, Coat, Colors, GroomTextures, Lengths, MapImages, Pattern, RootAtlas, Rooting, Vertices,
};
use crate::stages::hair::{Asides, TileHair};
use crate::stages::hair_groups;
use crate::stages::ink::{self, Canvas, InkFiles, Painting, SkinInk};
use crate::stages::pack::{self, Pieces, Skin, SkinFins, SkinPieces};
use crate::stages::strands;
use crate::stages::surface::{Measures, Surface};
use crate::stages::textures::{self, FinTextures, ShellTextures};
use crate::stages::visibility::{self, Visibility};
use crate::steps::Steps;
use pelage_formats::{HairGroup, RootsInfo, Shading, StrandsData};
use pelage_params::{Knob, Tables as _};
use std::sync::Arc;

/// The stages after `import`, in order; what a progress display counts.
pub const STAGES: [&str; 9] =
    ["surface", "simulate", "visibility", "slice", "groom", "fins", "ink", "textures", "pack"];

/// What a bake is told: the same for all its steps.
#[derive(Clone, Copy, Debug)]
pub struct Told<'a> {
    /// The model, or the package, as the user named it, for messages.
    pub file: &'a str,
    /// Its name in the package.
    pub name: &'a str,
    /// The recipe.
    pub recipe: &'a Recipe,
    /// The images that the recipe names.
    pub images: &'a MapImages,
    /// Where long stages count their steps.
    pub steps: &'a Steps,
}

impl<'a> Told<'a> {
    /// What nobody waits for. Arguments as the fields.
    pub fn new(file: &'a str, name: &'a str, recipe: &'a Recipe, images: &'a MapImages) -> Self {
        Self { file, name, recipe, images, steps: Steps::unseen() }
    }
}

/// Declares what is kept of the steps: a field of [`Outputs`] and its name in [`Output`].
macro_rules! outputs {
    ($($(#[doc = $doc:literal])+ $name:ident $field:ident: $type:ty,)+) => {
        /// The name of something that a step makes.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Output {
            $($(#[doc = $doc])+ $name,)+
        }

        /// What the steps have made so far; `None` is not made yet.
        #[derive(Clone, Debug, Default)]
        pub struct Outputs<'a> {
            $($(#[doc = $doc])+ pub $field: Option<$type>,)+
            /// What steps keep over their being run again, where what decides about it may stay the same.
            pub kept: Kept,
        }

        impl Output {
            /// All of them, in the order in which they are made.
            pub const ALL: &'static [Self] = &[$(Self::$name),+];
        }

        impl Outputs<'_> {
            /// Whether it is there.
            pub fn has(&self, output: Output) -> bool {
                match output {
                    $(Output::$name => self.$field.is_some(),)+
                }
            }

            /// Drops it, and nothing that was made of it.
            pub fn clear(&mut self, output: Output) {
                match output {
                    $(Output::$name => self.$field = None,)+
                }
            }
        }
    };
}

outputs! {
    /// What `import` made: nothing here makes it.
    Model model: &'a Model,
    /// The model with the hair's tile laid on it.
    Laid laid: Laid<'a>,
    /// The strands of the tile.
    Hair hair: TileHair,
    /// How much light reaches the strands; none where the package is not to know.
    Visible visible: Option<Visible>,
    /// The strands in layers.
    Shells shells: Shells,
    /// The strands as the package has them; none where it is to have no strands.
    Single single: Option<StrandsData>,
    /// The laid model with what varies over it.
    Groomed groomed: Arc<Groomed>,
    /// Hair on guides, and what there was to say of it.
    Guided guided: (Vec<HairGroup>, Vec<String>),
    /// Where fins stand.
    Fins fins: SkinFins<'a>,
    /// What fins show; none where the package is to have no fins.
    FinTextures fin_textures: Option<FinTextures>,
    /// What vertices take of the ink style; none without the style.
    Ink ink: Option<SkinInk>,
    /// What the ink style is painted with; none without the style.
    InkTextures ink_textures: Option<InkFiles<'a>>,
    /// The skin, with its textures in the package's formats.
    Skin skin: Skin<'a>,
    /// The package.
    Package package: Packed,
}

/// What is dear to make, and often made of the same although hair changed.
#[derive(Clone, Debug, Default)]
pub struct Kept {
    /// Textures of the ink style without its fur.
    painting: Remade<(InkParams, PackParams), Painting>,
    /// Textures of the skin.
    skin: Remade<SkinImages, SkinFiles>,
    /// Lists of fewer triangles.
    lists: Remade<pack::Simplifies, pack::Lists>,
}

/// The images of a skin, and how they are encoded.
#[derive(Clone, Debug)]
struct SkinImages {
    groomed: Arc<Groomed>,
    pack: PackParams,
}

impl PartialEq for SkinImages {
    fn eq(&self, other: &Self) -> bool {
        let (this, that) = (&self.groomed, &other.groomed);
        self.pack == other.pack && this.colors.images == that.colors.images && this.grooms.images == that.grooms.images
    }
}

/// Those images as .ktx2 files.
#[derive(Clone, Debug)]
struct SkinFiles {
    base_colors: Vec<Vec<u8>>,
    grooms: Vec<Vec<u8>>,
}

impl SkinFiles {
    fn encode(SkinImages { groomed, pack }: &SkinImages) -> Result<Self, BakeError> {
        let all = |images: &[Image], encode: fn(&Image, &PackParams) -> Result<Vec<u8>, BakeError>| {
            images.iter().map(|image| encode(image, pack)).collect::<Result<Vec<_>, _>>()
        };
        Ok(Self {
            base_colors: all(&groomed.colors.images, textures::encode_base_color)?,
            grooms: all(&groomed.grooms.images, textures::encode_groom)?,
        })
    }
}

/// How much light reaches the strands.
#[derive(Clone, Debug)]
pub struct Visible {
    /// As they are dry.
    pub dry: Visibility,
    /// As they are wet, where dry and wet mix.
    pub wet: Option<Visibility>,
}

/// The shell textures.
#[derive(Clone, Debug)]
pub struct Shells {
    /// Of the strands.
    pub dry: ShellTextures,
    /// Of the same strands when wet, where dry and wet mix.
    pub wet: Option<ShellTextures>,
}

/// What the `groom` stage leaves behind.
#[derive(Clone, Debug)]
pub struct Groomed {
    /// The laid surface; where there is a pattern, cut along the borders of its charts.
    pub surface: Surface,
    /// What varies over its vertices.
    pub coat: Coat,
    /// Colours of its materials and vertices.
    pub colors: Colors,
    /// The groom textures.
    pub grooms: GroomTextures,
    /// Width of the pattern, metres, where there is one.
    pub pattern_size_m: Option<f32>,
    /// How hair finds the colour of its root, where that is another than the colour below it.
    pub roots: Option<RootsInfo>,
    /// How far from bare materials hair has its full length, metres; `None` where no hair is near one.
    pub bare_margin_m: Option<f32>,
    /// What the recipe left open and was chosen.
    pub decisions: Vec<Decision>,
    /// What there was to say.
    pub warnings: Vec<String>,
}

/// One step of a stage: it makes one thing.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// The stage that it is part of, one of [`STAGES`].
    pub stage: &'static str,
    /// What it makes.
    pub makes: Output,
    /// What must be there.
    pub reads: &'static [Output],
    /// Tables of the recipe that decide what it makes, beside those that decide what it reads.
    pub tables: &'static [&'static str],
    run: for<'a> fn(&Told<'a>, &mut Outputs<'a>) -> Result<(), BakeError>,
}

use Output::*;

/// What lays the tile of hair on the model, and decides with that about all that is made of it.
const LAYING: &[&str] = &["model", "surface", "hair", "underfur", "groom", "color", "slice"];

/// Every table of a recipe.
const ALL_TABLES: &[&str] = &{
    let mut names = [""; Recipe::TABLES.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = Recipe::TABLES[i].name;
        i += 1;
    }
    names
};

/// All steps, in their order. A line says what the step makes, and of what.
pub const STEPS: &[Step] = &[
    Step { stage: "surface", makes: Laid, reads: &[Model], tables: LAYING, run: surface },
    Step { stage: "simulate", makes: Hair, reads: &[Laid], tables: &[], run: simulate },
    Step { stage: "visibility", makes: Visible, reads: &[Hair], tables: &["visibility"], run: visible },
    Step { stage: "slice", makes: Shells, reads: &[Hair, Visible], tables: &["slice", "pack", "detail"], run: slice },
    Step { stage: "slice", makes: Single, reads: &[Hair, Visible], tables: &["strands"], run: single },
    Step { stage: "groom", makes: Groomed, reads: &[Model, Laid, Hair], tables: &[], run: groom },
    Step { stage: "groom", makes: Guided, reads: &[Model, Laid, Groomed], tables: &["strands"], run: guided },
    Step { stage: "fins", makes: Fins, reads: &[Laid, Hair, Groomed], tables: &[], run: fins },
    Step {
        stage: "fins",
        makes: FinTextures,
        reads: &[Hair, Fins],
        tables: &["fins", "slice", "pack"],
        run: fin_textures,
    },
    Step { stage: "ink", makes: Ink, reads: &[Model, Laid, Groomed], tables: &["ink", "fins"], run: ink },
    Step { stage: "ink", makes: InkTextures, reads: &[Laid, Hair, Ink], tables: &["ink", "pack"], run: ink_textures },
    Step {
        stage: "textures",
        makes: Skin,
        reads: &[Model, Laid, Hair, Groomed],
        tables: &["pack", "detail"],
        run: skin,
    },
    Step {
        stage: "pack",
        makes: Package,
        reads: &[Hair, Shells, Single, Guided, Fins, FinTextures, Ink, InkTextures, Skin],
        // The package says by which recipe it was baked.
        tables: ALL_TABLES,
        run: pack,
    },
];

/// A finished package.
#[derive(Clone, Debug)]
pub struct Packed {
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// What all stages had to say.
    pub warnings: Vec<String>,
}

/// A finished bake.
#[derive(Clone, Debug)]
pub struct Baked {
    /// The package.
    pub package: Vec<u8>,
    /// Quality of the parameterization.
    pub measures: Measures,
    /// What the recipe left open and was chosen.
    pub decisions: Vec<Decision>,
    /// What was repaired, left out or guessed.
    pub warnings: Vec<String>,
}

/// Bakes an imported model.
///
/// * `on_stage`: called with the name of each of [`STAGES`] as it begins
///
/// # Errors
///
/// [`BakeError::Params`] for a value outside its range, [`BakeError::Input`] where model and recipe do not go together,
/// [`BakeError::Internal`] for a fault of this code.
pub fn bake(told: &Told<'_>, model: &Model, on_stage: &mut dyn FnMut(&'static str)) -> Result<Baked, BakeError> {
    let mut outputs = Outputs { model: Some(model), ..Outputs::default() };
    run(told, &mut outputs, on_stage)?;
    baked(&outputs)
}

/// The finished bake.
pub(crate) fn baked(outputs: &Outputs<'_>) -> Result<Baked, BakeError> {
    let groomed = made(&outputs.groomed, Output::Groomed)?;
    let decisions = [&made(&outputs.laid, Output::Laid)?.decisions[..], &groomed.decisions].concat();
    let Packed { bytes, warnings } = made(&outputs.package, Package)?.clone();
    Ok(Baked { package: bytes, measures: groomed.surface.measures, decisions, warnings })
}

/// Runs every step that the package needs and that is not made yet. `on_stage` is called as a stage begins.
///
/// # Errors
///
/// As [`bake`]; [`BakeError::Internal`] where something is needed that no step makes and that is not there.
pub fn run<'a>(
    told: &Told<'a>,
    outputs: &mut Outputs<'a>,
    on_stage: &mut dyn FnMut(&'static str),
) -> Result<(), BakeError> {
    make(told, outputs, Package, on_stage)
}

/// As [`run`], for something else than the package.
///
/// # Errors
///
/// As [`run`].
pub fn make<'a>(
    told: &Told<'a>,
    outputs: &mut Outputs<'a>,
    wanted: Output,
    on_stage: &mut dyn FnMut(&'static str),
) -> Result<(), BakeError> {
    told.recipe.validate()?;
    let mut needed = vec![wanted];
    let mut steps = Vec::new();
    for step in STEPS.iter().rev() {
        if needed.contains(&step.makes) && !outputs.has(step.makes) {
            needed.extend(step.reads);
            steps.push(step);
        }
    }
    let mut stage = "";
    for step in steps.into_iter().rev() {
        if step.stage != stage {
            stage = step.stage;
            told.steps.begin(0);
            on_stage(stage);
        }
        step.run(told, outputs)?;
    }
    Ok(())
}

impl Step {
    /// Makes what it makes.
    ///
    /// # Errors
    ///
    /// As [`run`].
    pub fn run<'a>(&self, told: &Told<'a>, outputs: &mut Outputs<'a>) -> Result<(), BakeError> {
        (self.run)(told, outputs)
    }
}

impl Outputs<'_> {
    /// Drops something and all that was made of it, so that [`run`] makes them again.
    pub fn forget(&mut self, output: Output) {
        let mut gone = vec![output];
        for step in STEPS {
            if step.reads.iter().any(|read| gone.contains(read)) {
                gone.push(step.makes);
            }
        }
        gone.into_iter().for_each(|output| self.clear(output));
    }

    /// Drops what the change from one recipe to another changes, so that [`run`] makes that again and keeps the rest.
    pub fn follow(&mut self, before: &Recipe, after: &Recipe) {
        let text = |recipe: &Recipe, knob: &'static Knob| knob.value(recipe);
        let changed = |table: &&str| {
            let knobs = Recipe::TABLES.iter().filter(|info| info.name == *table).flat_map(|info| info.knobs);
            knobs.into_iter().any(|knob| text(before, knob) != text(after, knob))
        };
        for step in STEPS {
            if step.tables.iter().any(changed) {
                self.forget(step.makes);
            }
        }
    }
}

fn missing(what: Output) -> BakeError {
    BakeError::Internal(format!("{what:?} is not there, expected a step before to make it"))
}

fn made<T>(output: &Option<T>, what: Output) -> Result<&T, BakeError> {
    output.as_ref().ok_or_else(|| missing(what))
}

fn surface<'a>(told: &Told<'a>, outputs: &mut Outputs<'a>) -> Result<(), BakeError> {
    let model = made(&outputs.model, Model)?;
    outputs.laid = Some(lay(told.file, model, told.recipe, told.images)?);
    Ok(())
}

fn simulate(told: &Told<'_>, outputs: &mut Outputs<'_>) -> Result<(), BakeError> {
    let laid = made(&outputs.laid, Laid)?;
    let HairColors { root, tip, .. } = laid.hair_colors;
    let color = ColorParams { root: Some(root), tip: Some(tip), ..told.recipe.color.clone() };
    let recipe = Recipe { color, ..laid.filled.clone() };
    outputs.hair = Some(TileHair::grow(&recipe, laid.lengths, laid.maps.water())?);
    Ok(())
}

fn visible(told: &Told<'_>, outputs: &mut Outputs<'_>) -> Result<(), BakeError> {
    let (hair, params) = (made(&outputs.hair, Hair)?, &told.recipe.visibility);
    let find = || {
        let dry = visibility::visibility(&hair.strands, params, None)?;
        // Where they mix they sink behind one horizon.
        let wet = |strands| visibility::visibility(strands, params, Some(dry.horizon));
        let wet = hair.wet.as_ref().map(wet).transpose()?;
        Ok::<_, BakeError>(self::Visible { dry, wet })
    };
    outputs.visible = Some(params.enabled.then(find).transpose()?);
    Ok(())
}

fn slice(told: &Told<'_>, outputs: &mut Outputs<'_>) -> Result<(), BakeError> {
    let (hair, recipe) = (made(&outputs.hair, Hair)?, told.recipe);
    let with_coat = detail::has_coat(recipe);
    let volumes = 1 + u64::from(hair.wet.is_some());
    told.steps.begin(volumes * u64::from(recipe.slice.layers + u32::from(with_coat)));
    let visible = made(&outputs.visible, Visible)?.as_ref();
    let slice = |strands, visible| {
        let on_layer = &mut || told.steps.step();
        textures::shell_textures(strands, visible, &recipe.slice, &recipe.pack, with_coat, on_layer)
    };
    let dry = slice(&hair.strands, visible.map(|v| &v.dry))?;
    let wet = hair.wet.as_ref().map(|strands| slice(strands, visible.and_then(|v| v.wet.as_ref()))).transpose()?;
    let shells = self::Shells { dry, wet };
    outputs.shells = Some(shells);
    Ok(())
}

fn single(told: &Told<'_>, outputs: &mut Outputs<'_>) -> Result<(), BakeError> {
    let (hair, params) = (made(&outputs.hair, Hair)?, &told.recipe.strands);
    let visible = made(&outputs.visible, Visible)?.as_ref();
    let visible = [visible.map(|v| &v.dry), visible.and_then(|v| v.wet.as_ref())];
    outputs.single = Some(params.enabled.then(|| strands::strands(hair, visible, params.points)));
    Ok(())
}

fn groom(told: &Told<'_>, outputs: &mut Outputs<'_>) -> Result<(), BakeError> {
    let (model, laid, recipe) = (made(&outputs.model, Model)?, made(&outputs.laid, Laid)?, told.recipe);
    let self::Laid { bounds, furred, maps, .. } = laid;
    let mut surface = laid.surface.clone();
    let pattern = Pattern::new(&recipe.color, told.images, bounds)?;
    let asides = Asides::of(&made(&outputs.hair, Hair)?.strands);
    let rooting = Rooting {
        furred,
        pattern: pattern.as_ref(),
        asides: &asides.mean,
        reach: asides.reach(),
        most_side: recipe.color.pattern_texels,
    };
    let colored =
        |surface: &Surface| groom::colors(model, &Vertices::from(surface), maps, furred, recipe.color.base_color);
    let uncut = colored(&surface)?;
    let roots = recipe.color.at_root.then(|| RootAtlas::new(&mut surface, &uncut, &rooting)).flatten();
    let plain = pattern.as_ref().filter(|_| roots.is_none());
    let atlas = plain.map(|_| Atlas::new(&mut surface, recipe.color.pattern_texels)).transpose()?;
    let mut coat = maps.coat(&Vertices::from(&surface))?;
    let (skin, longest_m) = ((&surface.mesh, &surface.rest), laid.lengths.length_m);
    let chosen_m = || groom::chosen_margin_m(skin, furred, &coat.length, longest_m, bounds.radius);
    let bare_margin_m = recipe.groom.bare_margin_m.or_else(chosen_m);
    if let Some(margin_m) = bare_margin_m.filter(|margin_m| *margin_m > 0.0) {
        BesideBare::new(skin.0, skin.1, furred, margin_m).shorten(&mut coat.length);
    }
    let open = recipe.groom.bare_margin_m.is_none();
    let decisions = bare_margin_m.filter(|_| open).map(groom::margin_decision).into_iter().collect();
    let mut colors = colored(&surface)?;
    let mut grooms = maps.textures()?;
    if let Some(roots) = &roots {
        roots.paint(&rooting, &mut surface, &mut colors, &mut grooms);
    }
    if let (Some(pattern), Some(atlas)) = (plain, &atlas) {
        pattern.paint(atlas, furred, &mut surface, &mut colors, &mut grooms);
    }
    colors.lighten(furred, laid.hair_colors.gain);
    let warnings = atlas.as_ref().and_then(Atlas::warning).into_iter().collect();
    let pattern_size_m = pattern.as_ref().map(Pattern::width_m);
    let roots = roots.map(|roots| roots.info(asides.at));
    outputs.groomed = Some(Arc::new(self::Groomed {
        surface,
        coat,
        colors,
        grooms,
        pattern_size_m,
        roots,
        bare_margin_m,
        decisions,
        warnings,
    }));
    Ok(())
}

/// Height of the fur, metres.
fn height_m(hair: &TileHair, lengths: Lengths) -> f32 {
    hair.strands.height * lengths.tile_size_m
}

fn guided(told: &Told<'_>, outputs: &mut Outputs<'_>) -> Result<(), BakeError> {
    let (model, laid, groomed) =
        (made(&outputs.model, Model)?, made(&outputs.laid, Laid)?, made(&outputs.groomed, Groomed)?);
    let ground = hair_groups::Ground {
        file: told.file,
        mesh: &groomed.surface.mesh,
        rest: &groomed.surface.rest,
        radius_m: laid.bounds.radius,
        materials: &model.materials,
        nodes: &model.nodes,
        files: told.images,
    };
    let mut warnings = Vec::new();
    let groups = hair_groups::groups(&told.recipe.strands, &ground, &mut warnings)?;
    outputs.guided = Some((groups, warnings));
    Ok(())
}

fn fins(_: &Told<'_>, outputs: &mut Outputs<'_>) -> Result<(), BakeError> {
    let (laid, hair) = (made(&outputs.laid, Laid)?, made(&outputs.hair, Hair)?);
    let groomed = made(&outputs.groomed, Groomed)?;
    let (height_m, tile_size_m) = (height_m(hair, laid.lengths), laid.lengths.tile_size_m);
    let fins = fins::fins(&groomed.surface, &laid.furred, &groomed.coat, height_m, tile_size_m);
    outputs.fins = Some(pack::skin_fins(&groomed.surface, &fins));
    Ok(())
}

fn fin_textures(told: &Told<'_>, outputs: &mut Outputs<'_>) -> Result<(), BakeError> {
    let (hair, fins, recipe) = (made(&outputs.hair, Hair)?, made(&outputs.fins, Fins)?, told.recipe);
    let depth = recipe.fins.depth.or(fins.depth).filter(|_| recipe.fins.enabled && fins.section.is_some());
    let make = |depth| textures::fin_textures(&hair.strands, depth, &recipe.slice, &recipe.pack);
    outputs.fin_textures = Some(depth.map(make).transpose()?);
    Ok(())
}

fn ink(told: &Told<'_>, outputs: &mut Outputs<'_>) -> Result<(), BakeError> {
    let (model, laid) = (made(&outputs.model, Model)?, made(&outputs.laid, Laid)?);
    let self::Groomed { surface, .. } = &**made(&outputs.groomed, Groomed)?;
    let (mesh, rest, radius) = (&surface.mesh, &surface.rest, laid.bounds.radius);
    let canvas = Canvas { mesh, rest, radius, materials: &model.materials, images: told.images };
    let params = &told.recipe.ink;
    let fur = ink::fur_strength(told.recipe, model, &laid.furred);
    outputs.ink = Some(params.enabled.then(|| ink::on_skin(params, fur, &canvas)).transpose()?);
    Ok(())
}

fn ink_textures(told: &Told<'_>, outputs: &mut Outputs<'_>) -> Result<(), BakeError> {
    let (laid, hair, recipe) = (made(&outputs.laid, Laid)?, made(&outputs.hair, Hair)?, told.recipe);
    let painting = &mut outputs.kept.painting;
    let paint = |skin: &SkinInk| {
        let strokes = laid.furred.contains(&true) && skin.shading.fur > 0.0;
        let strands = strokes.then_some(&hair.strands);
        ink::textures_again(&recipe.ink, &recipe.pack, told.images, strands, told.steps, painting)
    };
    outputs.ink_textures = Some(made(&outputs.ink, Ink)?.as_ref().map(paint).transpose()?);
    Ok(())
}

fn skin(told: &Told<'_>, outputs: &mut Outputs<'_>) -> Result<(), BakeError> {
    let (model, laid) = (made(&outputs.model, Model)?, made(&outputs.laid, Laid)?);
    let (hair, groomed, recipe) = (made(&outputs.hair, Hair)?, made(&outputs.groomed, Groomed)?, told.recipe);
    let images = SkinImages { groomed: groomed.clone(), pack: recipe.pack.clone() };
    let files = outputs.kept.skin.make(images, SkinFiles::encode)?;
    let pieces = SkinPieces {
        name: told.name,
        model,
        inputs: &told.images.inputs,
        surface: &groomed.surface,
        furred: &laid.furred,
        coat: &groomed.coat,
        colors: &groomed.colors,
        bounds: laid.bounds,
        bare: &laid.bare,
        bare_margin_m: groomed.bare_margin_m,
        lengths: laid.lengths,
        filled: &laid.filled,
        hair_colors: laid.hair_colors,
        height_m: height_m(hair, laid.lengths),
        strands: laid.filled.strands_in_tile(),
        pattern_size_m: groomed.pattern_size_m,
        roots: groomed.roots.as_ref(),
        base_colors: &files.base_colors,
        groom_textures: &files.grooms,
        groom_of_material: &groomed.grooms.of_material,
        simplified: recipe.detail.has_lists(),
        warnings: &[&laid.warnings[..], &groomed.warnings].concat(),
    };
    outputs.skin = Some(pack::skin(&pieces, &mut outputs.kept.lists));
    Ok(())
}

fn pack(told: &Told<'_>, outputs: &mut Outputs<'_>) -> Result<(), BakeError> {
    let shells = made(&outputs.shells, Shells)?;
    let ink = made(&outputs.ink, Ink)?.as_ref().zip(made(&outputs.ink_textures, InkTextures)?.as_ref());
    let (skin, hair) = (made(&outputs.skin, Skin)?, made(&outputs.hair, Hair)?);
    let shading = Shading::from(&told.recipe.shading);
    // Where no coat grows, its strands are of no use.
    let furred = skin.manifest.materials.iter().any(|material| material.furred);
    let packed = pack::pack(&Pieces {
        recipe: told.recipe,
        shading: if hair.style == Style::Wet { shading.wet() } else { shading },
        skin,
        shells: &shells.dry,
        wet_shells: shells.wet.as_ref(),
        strands: made(&outputs.single, Single)?.as_ref().filter(|_| furred),
        hair: made(&outputs.guided, Guided)?,
        fins: made(&outputs.fins, Fins)?,
        fin_textures: made(&outputs.fin_textures, FinTextures)?.as_ref(),
        ink,
    });
    let (bytes, warnings) = packed.map_err(|error| match error {
        BakeError::Params { what, reason } => BakeError::Input {
            file: told.file.to_owned(),
            place: "whole model".to_owned(),
            reason: format!("its size decides {what}: {reason}; say it in the recipe, or see model.unit_m"),
        },
        other => other,
    })?;
    outputs.package = Some(Packed { bytes, warnings });
    Ok(())
}
