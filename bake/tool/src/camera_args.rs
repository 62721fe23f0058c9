//! Camera options of `render`, `bench`, `reference` and `doctor`.

use pelage_stage::{Framing, Orbit, Viewpoint};

/// Camera options of all commands that view a model.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct CameraArgs {
    /// Eye and target in metres, vertical field of view in degrees: ex,ey,ez/tx,ty,tz/fov
    ///
    /// Without it the camera frames everything to be drawn, from the front left: all copies or models, with their fur,
    /// along their paths. Clips are framed over their whole length, posed twenty times per second. The camera is the
    /// same for fur, ink and bare models. `render` prints it.
    #[arg(long, value_name = "EYE/TARGET/FOV", allow_hyphen_values = true, conflicts_with_all = ["orbit", "look_at"],
        display_order = 5)]
    pub camera: Option<Viewpoint>,
    /// Frame from this direction, in degrees: azimuth 0 is in front, 90 at the model's left, elevation up to 90 above;
    /// zoom above 1 moves closer
    ///
    /// Zoom is the factor by which the nearest side is enlarged in the picture.
    #[arg(long, value_name = "AZ,EL[,ZOOM]", allow_hyphen_values = true, display_order = 4)]
    pub orbit: Option<Orbit>,
    /// Frame only the material or joint of this name, including the joint's descendants; * matches any characters, ? a
    /// single one
    #[arg(long, value_name = "MATERIAL|JOINT", help_heading = "Camera", hide_short_help = true)]
    pub look_at: Option<String>,
}

impl CameraArgs {
    /// Returns the framing options, which apply if no camera is given.
    pub fn framing(&self) -> Framing {
        Framing { orbit: self.orbit, look_at: self.look_at.clone(), all_around: false }
    }
}
