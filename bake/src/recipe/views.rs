//! Views of a model in a recipe: `judge.views`, and `--camera`, which reads the same words.

use glam::Vec3;
use pelage_params::{Item, Raw};
use std::fmt;
use std::str::FromStr;

/// From where a model is looked at. As a word: `ex,ey,ez/tx,ty,tz/fov_deg`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraView {
    /// Metres.
    pub eye: Vec3,
    /// Metres; apart from `eye`.
    pub target: Vec3,
    /// Height of the view, degrees, 1..=170.
    pub fov_deg: f32,
}

/// Three finite numbers, `x,y,z`.
///
/// # Errors
///
/// What was expected, in words.
pub fn parse_vec3(text: &str) -> Result<Vec3, String> {
    let numbers: Option<Vec<f32>> =
        text.split(',').map(|n| n.trim().parse().ok().filter(|x: &f32| x.is_finite())).collect();
    match numbers.as_deref() {
        Some([x, y, z]) => Ok(Vec3::new(*x, *y, *z)),
        _ => Err("expected three numbers x,y,z".into()),
    }
}

impl FromStr for CameraView {
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
            return Err("eye and target are the same point, expected them apart".into());
        }
        Ok(Self { eye, target, fov_deg })
    }
}

impl fmt::Display for CameraView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (e, t) = (self.eye, self.target);
        write!(f, "{},{},{}/{},{},{}/{}", e.x, e.y, e.z, t.x, t.y, t.z, self.fov_deg)
    }
}

impl Item for CameraView {
    const ALONE: bool = true;

    fn expected_list() -> String {
        "a list of views such as \"0,1,3/0,0.5,0/40\": eye, target, height of the view in degrees".into()
    }

    fn place(index: usize, raw: &Raw) -> String {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests fail by panicking")]

    use super::*;
    use crate::recipe::Recipe;

    #[test]
    fn views_survive_a_recipe() {
        let text = "[judge]\nviews = [\"0,1,-3/0.5,0.25,1e-3/40\", \"1,2,3/0,0,0/30.5\"]\n";
        let recipe = Recipe::parse("a.toml", text).expect("a recipe");
        assert_eq!(recipe.judge.views.len(), 2);
        assert_eq!(recipe.judge.views[0].target, Vec3::new(0.5, 0.25, 1e-3));
        assert_eq!(Recipe::parse("a.toml", &recipe.to_toml()).expect("its own words"), recipe);
        let mut one = Recipe::default();
        one.set("judge.views=0,1,3/0,0,0/40").expect("a word without quotes");
        assert_eq!(one.judge.views.len(), 1);
    }

    #[test]
    fn what_is_wrong_with_a_view_is_said() {
        for (word, message) in [("0,1,3/0,0,0", "fov_deg"), ("0,1/0,0,0/40", "eye"), ("0,0,0/0,0,0/40", "same point")] {
            let text = format!("[judge]\nviews = [\"0,1,3/0,0,0/40\", \"{word}\"]\n");
            let error = Recipe::parse("a.toml", &text).unwrap_err().to_string();
            assert!(error.contains("line 2, judge.views") && error.contains("entry 1"), "{error}");
            assert!(error.contains(message), "{error}");
        }
    }
}
