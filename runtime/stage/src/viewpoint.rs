//! Viewpoint of a picture at one time, and over time.

use crate::track::Track;
use glam::{Quat, Vec3};
use pelage_params::{Item, Raw};
use std::fmt;
use std::str::FromStr;

/// Viewpoint of a picture. As text: `ex,ey,ez/tx,ty,tz/fov_deg`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// Position in metres.
    pub eye: Vec3,
    /// Target in metres; different from `eye`.
    pub target: Vec3,
    /// Vertical field of view, degrees, 1..=170.
    pub fov_deg: f32,
}

impl Viewpoint {
    /// Returns the camera rotated about the vertical axis through its target.
    #[must_use]
    pub fn turned(self, angle_rad: f32) -> Self {
        Self { eye: self.target + Quat::from_rotation_y(angle_rad) * (self.eye - self.target), ..self }
    }
}

/// Parses finite numbers separated by commas.
pub(crate) fn numbers(text: &str) -> Option<Vec<f32>> {
    text.split(',').map(|n| n.trim().parse().ok().filter(|x: &f32| x.is_finite())).collect()
}

/// Largest coordinate of a viewpoint, metres. Far beyond it, squared distances are infinite in single precision.
const MAX_COORDINATE_M: f32 = 1e15;

/// Parses three finite numbers, `x,y,z`. The error describes the expected form.
fn parse_vec3(text: &str) -> Result<Vec3, String> {
    match numbers(text).as_deref() {
        Some([x, y, z]) if [x, y, z].iter().all(|x| x.abs() <= MAX_COORDINATE_M) => Ok(Vec3::new(*x, *y, *z)),
        Some([_, _, _]) => {
            Err(format!("found {text}, expected numbers from -{MAX_COORDINATE_M:e} to {MAX_COORDINATE_M:e}"))
        }
        _ => Err("expected three numbers x,y,z".into()),
    }
}

impl FromStr for Viewpoint {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts: Vec<_> = text.split('/').collect();
        let [eye, target, fov] = parts[..] else {
            return Err("expected ex,ey,ez/tx,ty,tz/fov_deg, such as 0,1,3/0,0.5,0/40".into());
        };
        let (eye, target) = (
            parse_vec3(eye).map_err(|e| format!("eye: {e}"))?,
            parse_vec3(target).map_err(|e| format!("target: {e}"))?,
        );
        let fov_deg: f32 = fov.trim().parse().map_err(|_| "field of view: expected degrees".to_owned())?;
        if !(1.0..=170.0).contains(&fov_deg) {
            return Err("field of view: expected 1 to 170 degrees".into());
        }
        if eye == target {
            return Err("eye and target are the same point, expected different points".into());
        }
        Ok(Self { eye, target, fov_deg })
    }
}

impl fmt::Display for Viewpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (e, t) = (self.eye, self.target);
        write!(f, "{},{},{}/{},{},{}/{}", e.x, e.y, e.z, t.x, t.y, t.z, self.fov_deg)
    }
}

impl Item for Viewpoint {
    const ALLOW_SINGLE: bool = true;

    fn expected_list() -> String {
        "a list of views such as \"0,1,3/0,0.5,0/40\": eye, target, vertical field of view in degrees".into()
    }

    fn entry_name(index: usize, raw: &Raw) -> String {
        match raw {
            Raw::String(word) => format!("entry {index}, {word:?}"),
            _ => format!("entry {index}"),
        }
    }

    fn read(raw: &Raw) -> Result<Self, Option<String>> {
        match raw {
            Raw::String(word) => word.parse().map_err(Some),
            _ => Err(None),
        }
    }

    fn in_range(&self) -> bool {
        self.to_string().parse::<Self>().is_ok()
    }

    fn to_toml(&self) -> String {
        format!("{:?}", self.to_string())
    }
}

/// Viewpoint over time.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraTrack {
    /// Position in metres.
    pub eye: Track<Vec3>,
    /// Target in metres.
    pub target: Track<Vec3>,
    /// Vertical field of view, degrees.
    pub fov_deg: Track<f32>,
}

impl CameraTrack {
    /// Creates a constant view.
    pub fn fixed(view: Viewpoint) -> Self {
        Self { eye: Track::fixed(view.eye), target: Track::fixed(view.target), fov_deg: Track::fixed(view.fov_deg) }
    }

    /// Returns the view at `time_s`.
    pub fn at(&self, time_s: f32) -> Viewpoint {
        // A cubic may overshoot its keys.
        let fov_deg = self.fov_deg.at(time_s).clamp(1.0, 170.0);
        Viewpoint { eye: self.eye.at(time_s), target: self.target.at(time_s), fov_deg }
    }
}
