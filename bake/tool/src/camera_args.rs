//! From where a picture is seen: the arguments of `render`, `bench`, `reference` and `doctor`.

use pelage_stage::{Framing, Orbit, Viewpoint};

/// Options of whatever looks at a model.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct CameraArgs {
    /// Eye and target in metres, height of the view in degrees: ex,ey,ez/tx,ty,tz/fov
    ///
    /// Without it the camera frames from the front left what will be drawn: all copies or models, with their fur, along their paths, and of a clip its whole
    /// length, which is posed twenty times a second. It is the same camera for fur, ink and bare skin. `render` says which it was.
    #[arg(long, value_name = "EYE/TARGET/FOV", allow_hyphen_values = true, conflicts_with_all = ["orbit", "look_at"])]
    pub camera: Option<Viewpoint>,
    /// Frames from there, in degrees: azimuth 0 is in front, 90 at the model's left, elevation up to 90 above; a zoom over 1 goes nearer
    ///
    /// The zoom is how many times as large the nearest side stands in the picture.
    #[arg(long, value_name = "AZ,EL[,ZOOM]", allow_hyphen_values = true)]
    pub orbit: Option<Orbit>,
    /// Frames what belongs to a material or joint of that name, and what hangs on the joint; * and ? stand for any characters and for one
    #[arg(long, value_name = "MATERIAL|JOINT")]
    pub look_at: Option<String>,
}

impl CameraArgs {
    /// What a camera is that is not given.
    pub fn framing(&self) -> Framing {
        Framing { orbit: self.orbit, look_at: self.look_at.clone(), all_around: false }
    }
}
