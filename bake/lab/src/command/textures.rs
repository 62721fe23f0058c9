//! `pelage chart textures`: formats, encoders and mips of a tile of hair.

use super::driver::{Plan, PlannedRow, Topic, get_or_make, processor};
use super::subject::Subject;
use crate::chart::Cell;
use crate::chart::textures::{COLUMNS, PANELS, SlicedTile, TexturesConfiguration, configurations, measure};
use pelage_bake::stages::groom::{self, Lengths};
use pelage_bake::stages::simulate::{VolumeParams, simulate_recipe};
use pelage_import::mesh::RestPose;
use pelage_tool::exit::Failure;
use std::time::Instant;

/// Topic `textures`.
pub struct TexturesTopic<'a> {
    subject: &'a Subject,
    configurations: Vec<TexturesConfiguration>,
    truth: Option<SlicedTile>,
}

impl<'a> TexturesTopic<'a> {
    /// Lists the configurations.
    pub fn new(subject: &'a Subject) -> Result<Self, Failure> {
        Ok(Self { subject, configurations: configurations(&subject.recipe)?, truth: None })
    }
}

impl Topic for TexturesTopic<'_> {
    fn plan(&self) -> Plan {
        let row = |configuration: &TexturesConfiguration| PlannedRow {
            series: configuration.series.into(),
            label: configuration.label.clone(),
            default: *configuration == self.configurations[0],
            command: None,
        };
        let (name, slice) = (&self.subject.name, &self.subject.recipe.slice);
        let size = format!("{0}² × {1}", slice.tile_texels, slice.layers);
        Plan {
            topic: "textures",
            title: format!("Hair of {name}, {size} texels: texture formats against 8 bits per channel"),
            adapter: processor(),
            columns: COLUMNS.to_vec(),
            panels: PANELS.to_vec(),
            rows: self.configurations.iter().map(row).collect(),
        }
    }

    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure> {
        let truth = get_or_make(&mut self.truth, || {
            doing("slicing");
            let (model, recipe) = (&self.subject.model, &self.subject.recipe);
            let bounds = groom::bounds(&RestPose::of(&model.mesh, model.animation.as_ref()));
            let lengths = Lengths::resolve(recipe, &bounds);
            let volume = VolumeParams { height: lengths.length_m / lengths.tile_size_m };
            Ok(SlicedTile::new(recipe, simulate_recipe(recipe, &volume)?)?)
        })?;
        doing("encoding");
        let start = Instant::now();
        Ok(measure(&self.configurations[index], truth, &|| start.elapsed().as_secs_f64())?)
    }
}
