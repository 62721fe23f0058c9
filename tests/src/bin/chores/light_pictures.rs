//! Redraws the figures of Yang 2006 about light in fur with this project's own models: `chores light-pictures FOLDER`.
//!
//! * `light_single_hairs.png`: sparse hair that casts separate shadows on the mesh surface, without and with
//!   self-shadow (Fig. 6)
//! * `light_self_shadow.png`: without and with self-shadow (Fig. 7)
//! * `light_soft_shadow.png`: no shadow, a hard one, a soft one (Fig. 8)
//! * `light_terms.png`: eq. (1) per vertex and per pixel, then each term of eq. (3) added in turn (Fig. 10)
//! * `light_behind.png`: lit from behind, without and with Attenu_Back (§3.3)

use anyhow::{Context as _, bail};
use pelage_tests::binary::workspace;
use pelage_tests::chores::{Baked, ChoreFolder, sheet};
use std::path::{Path, PathBuf};

const OFF: [&str; 8] =
    ["--self-shadow", "off", "--soft-shadow", "off", "--ambient-attenuation", "off", "--back-attenuation", "off"];

pub fn run(arguments: &[String]) -> anyhow::Result<()> {
    let [folder] = arguments else { bail!("expected a FOLDER for the pictures") };
    let gallery = Gallery { workshop: ChoreFolder::default(), folder: folder.into() };
    let asset = |kind: &str, name: &str| workspace().join("assets").join(kind).join(name).display().to_string();
    let model = |name: &str| {
        [asset("models", &format!("{name}.glb")), "--recipe".into(), asset("recipes", &format!("{name}.toml"))]
    };

    let mut sparse = model("torus").to_vec();
    for set in [
        "hair.density=30",
        "hair.root_radius=0.009",
        "hair.tip_radius=0.003",
        "hair.lean=0.35",
        "hair.length_m=0.022",
        "slice.tile_texels=256",
        "slice.layers=64",
        "color.root=\"#d8b896\"",
        "color.tip=\"#6a4020\"",
        "color.variation=0",
        "shading.specular=[0,0,0]",
    ] {
        sparse.extend(["--set".into(), set.into()]);
    }
    let sparse = gallery.workshop.bake("sparse", &sparse)?;
    let near = "--camera 0.1,0.42,0.42/0.02,0,0.02/34 --light -0.9,0.9,0.2 --shadow-map 2048";
    gallery.row("light_single_hairs", &sparse, "400x300", near, &["--self-shadow off", ""])?;

    let hare = gallery.workshop.bake("hare", &model("hare"))?;
    let portrait = "--camera 0.42,0.5,0.62/0,0.24,0.02/34";
    gallery.row("light_self_shadow", &hare, "360x400", portrait, &["--self-shadow off", ""])?;
    let back = "--camera -0.62,0.72,-0.35/0,0.22,0/26 --light -0.1,0.75,0.9";
    let shadows = ["--soft-shadow off", "--penumbra 0", "--penumbra 0.3 --shadow-shrink 12"];
    gallery.row("light_soft_shadow", &hare, "300x300", back, &shadows)?;
    let behind = "--camera -0.62,0.72,-0.35/0,0.22,0/26 --light 0.7,0.35,0.6 --soft-shadow off";
    gallery.row("light_behind", &hare, "300x300", behind, &["--back-attenuation off", ""])?;

    let knot = gallery.workshop.bake("knot", &model("knot"))?;
    let terms = |on: &[usize]| -> String {
        let mut words = OFF.map(String::from);
        on.iter().for_each(|term| words[2 * term + 1] = "on".into());
        words.join(" ")
    };
    // The steps add the terms of eq. (3) in turn: γ, t, Attenu_Back, Attenu_Shadow.
    let steps = [
        format!("{} --lighting vertex", terms(&[])),
        terms(&[]),
        terms(&[2]),
        terms(&[2, 0]),
        terms(&[2, 0, 3]),
        terms(&[2, 0, 3, 1]),
    ];
    let steps: Vec<&str> = steps.iter().map(String::as_str).collect();
    gallery.rows("light_terms", &knot, "300x300", "--light 0.2,1,0.35", &steps, 3)
}

struct Gallery {
    workshop: ChoreFolder,
    folder: PathBuf,
}

impl Gallery {
    /// Draws one picture per step, side by side.
    fn row(&self, name: &str, baked: &Baked, size: &str, common: &str, steps: &[&str]) -> anyhow::Result<()> {
        self.rows(name, baked, size, common, steps, steps.len())
    }

    fn rows(
        &self,
        name: &str,
        baked: &Baked,
        size: &str,
        common: &str,
        steps: &[&str],
        columns: usize,
    ) -> anyhow::Result<()> {
        let draw = |step: &&str| {
            let options: Vec<&str> = common.split_whitespace().chain(step.split_whitespace()).collect();
            self.workshop.draw(baked, size, &options)
        };
        let pictures = steps.iter().map(draw).collect::<Result<Vec<_>, _>>()?;
        let path: &Path = &self.folder.join(format!("{name}.png"));
        sheet(&pictures, columns)?.save(path).with_context(|| format!("cannot write {}", path.display()))?;
        println!("{}: {}", path.display(), steps.join(" | "));
        Ok(())
    }
}
