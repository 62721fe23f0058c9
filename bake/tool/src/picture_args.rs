//! `pelage bake --for-size` and `--for-distance`: chooses layers and tile for given pictures.

use super::exit::Failure;
use super::view::PictureView;
use pelage_bake::pipeline::{self, BakeInput};
use pelage_bake::recipe::SliceParams;
use pelage_bake::stages::groom;
use pelage_bake::stages::metric::{self, TileRecipe};
use pelage_import::BakeError;
use pelage_import::mesh::{Model, RestPose};
use pelage_stage::{NamedPackage, Size, Viewpoint};
use pelage_truth::doctor::{self, OnScreen};

/// Options that describe the pictures for which a bake chooses layers and tile.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct PictureArgs {
    /// Choose layers and tile for pictures of this size that the model fills: as many layers and texels as the fur has
    /// pixels at its nearest point
    #[arg(long, value_name = "WxH", conflicts_with_all = ["max_error", "max_frame_ms", "max_bytes"])]
    pub for_size: Option<Size>,
    /// Choose layers and tile for pictures that the model approaches to this distance, metres, and no closer. The
    /// picture height is that of --for-size, or 424 pixels; the lens is the default camera's
    #[arg(long, value_name = "M", value_parser = positive, allow_hyphen_values = true,
        conflicts_with_all = ["max_error", "max_frame_ms", "max_bytes"])]
    pub for_distance: Option<f64>,
}

/// Parses a finite number above 0.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0).ok_or("expected a number above 0".into())
}

impl PictureArgs {
    /// Returns true if no option was given.
    pub fn is_empty(&self) -> bool {
        self.for_size.is_none() && self.for_distance.is_none()
    }

    /// Returns the options as on the command line; empty without options.
    pub fn words(&self) -> String {
        let size = self.for_size.map(|Size { width, height, .. }| format!("--for-size {width}x{height}"));
        let distance = self.for_distance.map(|distance_m| format!("--for-distance {distance_m}"));
        size.into_iter().chain(distance).collect::<Vec<_>>().join(" ")
    }

    /// Returns a recipe whose layers and tile suit the pictures. Bakes with the coarsest tile to determine them.
    ///
    /// Fails like [`pipeline::bake`].
    pub fn fit(&self, told: BakeInput<'_>, model: &Model) -> Result<TileRecipe, Failure> {
        let bounds = groom::bounds(&RestPose::of(&model.mesh, model.animation.as_ref()));
        let mut coarse = metric::to_tile_units(told.recipe, &bounds)?.recipe;
        (coarse.slice.layers, coarse.slice.tile_texels) = (4, 16);
        (coarse.ink.enabled, coarse.fins.enabled, coarse.visibility.enabled, coarse.detail.enabled) =
            (false, false, false, false);
        let baked = pipeline::bake(&BakeInput { recipe: &coarse, ..told }, model, &mut |_| ())?;
        let file = NamedPackage::new(told.file, baked.package);
        let package = file.open()?;
        let shown =
            self.for_size.map_or_else(PictureView::default, |size| PictureView::sized((size.width, size.height)));
        let fur = &package.manifest().fur;
        let Viewpoint { eye, target, fov_deg } = shown.viewpoint(&shown.outline(&file, &package)?, fur.height_m);
        let fov_y_rad = fov_deg.to_radians();
        let view = doctor::PrognosisView { eye, target, fov_y_rad, size: shown.size(), instances: 1, shadow_map: 0 };
        let fault = |source| BakeError::Package { file: file.name.clone(), source };
        let found = doctor::diagnose(&package, &view, &fault)?.on_screen;
        let near = self.for_distance.map_or(found, |distance_m| found.at_distance(distance_m));
        let tile_px = near.texel_px * f64::from(coarse.slice.tile_texels);
        let px_per_m = tile_px / f64::from(fur.tile_size_m);
        let mut sized = told.recipe.clone();
        if let Some(width_m) = metric::hair_width_m(&sized).filter(|_| sized.surface.tile_size_m.is_none()) {
            sized.slice.tile_texels = texels_of_period(width_m * px_per_m);
        }
        let done = metric::to_tile_units(&sized, &bounds)?;
        let tile_px = match done.recipe.surface.tile_size_m {
            Some(tile_size_m) if metric::is_metric(&sized) => f64::from(tile_size_m) * px_per_m,
            _ => tile_px,
        };
        let recipe = doctor::fitted(&done.recipe, &OnScreen { texel_px: tile_px, ..near }, 1);
        Ok(TileRecipe { recipe, ..done })
    }

    /// Returns a description of the pictures and of the chosen values.
    pub fn description(&self, slice: &SliceParams) -> String {
        let Size { width, height, .. } = self.for_size.unwrap_or(PictureView::default().look.picture.size);
        let from = self.for_distance.map_or_else(String::new, |distance_m| format!(" from {distance_m} m"));
        let SliceParams { layers, tile_texels, .. } = slice;
        format!("for {width}x{height}{from}: slice.layers={layers}, slice.tile_texels={tile_texels}")
    }
}

/// Tile width on screen below which its repetition may be visible, pixels.
const PERIOD_PX: f64 = 96.0;

/// Returns the width in texels of the smallest tile whose repetition is not visible. A hair is one texel wide, which is
/// `hair_px` pixels on screen.
///
/// * `hair_px`: width of a hair, pixels
fn texels_of_period(hair_px: f64) -> u32 {
    ((PERIOD_PX / hair_px.max(1e-6)).ceil().clamp(64.0, 512.0) as u32).next_power_of_two()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tile_texels_follow_from_the_period_in_pixels() {
        assert_eq!(texels_of_period(0.5), 256, "96 px at two texels a pixel");
        assert_eq!(texels_of_period(4.0), 64, "the minimum, for wide hairs");
        assert_eq!((texels_of_period(0.01), texels_of_period(0.0)), (512, 512), "the maximum, for very thin hairs");
    }
}
