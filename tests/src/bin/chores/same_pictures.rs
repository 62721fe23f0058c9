//! Compares two builds of `pelage` byte for byte, for changes that must not change any picture: `chores same-pictures
//! BEFORE AFTER [-o OUT] [--only WORD]`. Also prints a table of the cost of each pass in both builds: `… -- BEFORE
//! AFTER --bench [--rounds N] [-o OUT]`.
//!
//! BEFORE and AFTER are two binaries of `pelage-lab`, because many cases draw the published forms of formulas. Both
//! bake every model, and both draw the packages of BEFORE. OUT defaults to `target/same_pictures`. It keeps the
//! packages of BEFORE in `packages` and generated sources in `made`. For each difference it keeps both pictures in
//! `pictures` and the package of AFTER in `packages_after`. `--only` selects the cases whose name contains WORD.
//!
//! Some models come from the shared test data (`PELAGE_DATA`); without it their cases are skipped and listed. Exit
//! codes: 0, all the same; 7, something differs or could not be baked or drawn; 2, nothing differs, but cases were
//! skipped; 1, no comparison.
//!
//! Pictures are comparable only on the same adapter, so both binaries have to run on the same machine. Scenes cannot
//! mirror an instance at draw time, so no case tests this. The mirrored models here are mirrored by the bake.

use anyhow::{Context as _, bail, ensure};
use image::{Rgba, RgbaImage};
use pelage_glb::container;
use pelage_tests::binary::workspace;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

/// Packages: name, model, and options of `pelage bake`. Models that begin with `data/` are in the shared test data;
/// those that begin with `made/` are in OUT.
const PACKAGES: &[(&str, &str, &str)] = &[
    ("hare", "assets/models/hare.glb", "--recipe assets/recipes/hare.toml"),
    ("torus", "assets/models/torus.glb", "--recipe assets/recipes/torus.toml"),
    ("knot", "assets/models/knot.glb", "--recipe assets/recipes/knot.toml"),
    ("ox", "assets/models/ox.glb", "--recipe assets/recipes/ox.toml"),
    ("crane", "assets/models/crane.glb", "--recipe assets/recipes/crane.toml"),
    ("hills", "assets/models/hills.glb", "--recipe assets/recipes/hills.toml"),
    // Tests other texel formats, without fins and levels of detail.
    (
        "blocks",
        "assets/models/hare.glb",
        "--recipe assets/recipes/hare.toml --set pack.shell_format=bc7 --set pack.direction_format=bc5",
    ),
    ("directions", "assets/models/hare.glb", "--recipe assets/recipes/hare.toml --set pack.direction_format=rgba8"),
    (
        "simple",
        "assets/models/torus.glb",
        "--recipe assets/recipes/torus.toml --set fins.enabled=false --set detail.enabled=false",
    ),
    // Tests many layers of a different size, and lighting constants that select other pipelines.
    (
        "layers",
        "assets/models/torus.glb",
        "--recipe assets/recipes/torus.toml --set slice.layers=40 --set slice.tile_texels=128 \
         --set shading.diffuse_exponent=3 --set hair.style=curly",
    ),
    (
        "matt",
        "assets/models/knot.glb",
        "--recipe assets/recipes/knot.toml --set shading.specular=[0,0,0] --set hair.style=messy --set ink.fur=0",
    ),
    // Tests wetness in the groom: uniform, per vertex, and from an image.
    (
        "wet",
        "assets/models/hare.glb",
        "--recipe assets/recipes/hare.toml --set hair.style=wet --set hair.length_m=0.018 --set hair.density=1500",
    ),
    (
        "damp",
        "assets/models/hare.glb",
        "--recipe assets/recipes/hare.toml --set groom.wetness=vertex#r \
         --set groom.lean=vertex#g --set groom.bare=vertex#b",
    ),
    ("coat", "assets/models/torus.glb", "--recipe made/coat.toml"),
    ("lean", "assets/models/torus.glb", "--recipe assets/recipes/torus.toml --set groom.lean=0.6"),
    // Tests patterns, textures and holes.
    ("zebra", "assets/models/knot.glb", "--recipe assets/recipes/zebra.toml"),
    ("spots", "assets/models/torus.glb", "--recipe assets/recipes/spots.toml"),
    ("holes", "made/holes.glb", "--recipe assets/recipes/torus.toml"),
    ("twins", "made/twins.glb", "--recipe assets/recipes/knot.toml"),
    ("mirrored", "made/mirrored.glb", "--recipe assets/recipes/hare.toml"),
    ("fox", "data/skinned/Fox.glb", "--recipe assets/recipes/fox.toml"),
    (
        "horse",
        "data/skinned/quaternius_Horse.glb",
        "--recipe assets/recipes/zebra.toml --set surface.tile_size_m=0.3 --set hair.length_m=0.05 \
         --set color.pattern_size_m=1.2 --set model.bare=[\"Hooves\",\"Eye*\"]",
    ),
    ("cow", "data/skinned/quaternius_Cow.glb", ""),
    ("spot", "data/static/spot.obj", ""),
    ("duck", "data/static/Duck.glb", ""),
    ("bunny", "data/static/bunny.obj", ""),
];

/// Scenes: name, names of the packages in it, and text of the scene file.
const SCENES: &[(&str, &[&str], &str)] = &[
    // Equals `assets/scenes/walk.toml`, except that it has `[view]` instead of `[look]`, which older builds cannot
    // read.
    (
        "walk",
        &["ox", "hare", "crane", "hills"],
        r#"
[view]
size = "834x424"
style = "ink"
ink_width = "0.05m"
ink_mist = "15,140"

[camera]
path = [
    { time_s = 0.0, eye = [0.3, 1.3, 9.0], target = [-0.2, 1.9, 0.0], fov_deg = 34 },
    { time_s = 2.0, eye = [0.9, 1.3, 9.0], target = [0.4, 1.9, 0.0], fov_deg = 34 },
    { time_s = 4.0, eye = [1.8, 1.4, 9.0], target = [1.3, 1.9, 0.0], fov_deg = 34 },
]

[light]
direction = [-1.0, 2.0, 1.5]

[sequence]
frames = 48
fps = 24

[[model]]
package = "hills.pelage"

[[model]]
name = "ox"
package = "ox.pelage"
clip = "Walk"
path = [
    { time_s = 0, position = [-1.7, 0, 0.1] },
    { time_s = 4, position = [1.05, 0, 0.1] },
]

[[model]]
name = "hare"
package = "hare.pelage"
clip = "Walk"
start_s = 0.3
path = [
    { time_s = 0, position = [0.45, 0, 1.2] },
    { time_s = 2, position = [1.65, 0, 1.2] },
    { time_s = 4, position = [2.83, 0, 1.4] },
]

[[model]]
name = "crane"
package = "crane.pelage"
clip = "Walk"
path = [
    { time_s = 0, position = [1.4, 0, 0.6] },
    { time_s = 4, position = [3.6, 0, 0.5] },
]
"#,
    ),
    (
        "meeting",
        &["hare", "ox", "torus"],
        r#"
[view]
background = "204,209,217"
fill_light = ["-1,0.4,0.3/0.4"]

[light]
position = [0.6, 1.6, 1.2]

[[model]]
package = "hare.pelage"
position = [-0.25, 0, 0]
heading_deg = 60
clip = "Walk"

[[model]]
package = "ox.pelage"
position = [0.4, 0, -0.6]
heading_deg = -70
scale = 0.4
clip = "Walk"
speed = 0.5

[[model]]
name = "small"
package = "hare.pelage"
position = [0.1, 0, 0.35]
heading_deg = -20
scale = 0.5
clip = "EarBreath"
start_s = 0.4

[[model]]
package = "torus.pelage"
position = [-0.5, 0.1, -0.3]
scale = 0.7
"#,
    ),
];

/// Cases of each package or scene: name of the case, and options of `pelage render`.
const CASES: &[(&str, &[(&str, &str)])] = &[
    (
        "hare",
        &[
            ("fur", "--size 834x424"),
            ("bare", "--size 834x424 --style bare"),
            ("ink", "--size 834x424 --style ink"),
            ("fur_small", ""),
            ("fur_odd_size", "--size 199x333"),
            ("fur_4_samples", "--samples 4"),
            ("bare_4_samples", "--style bare --samples 4"),
            ("background", "--background 204,209,217"),
            ("near", "--camera 0.42,0.5,0.62/0,0.24,0.02/34"),
            ("among_hair", "--camera 0.05,0.3,0.1/0,0.3,0.15/60 --detail auto"),
            ("above", "--camera 0.01,1.6,0/0,0.2,0/24"),
            // Levels of detail.
            ("near_auto", "--size 834x424 --camera 0.42,0.5,0.62/0,0.24,0.02/34 --detail auto"),
            ("near_0", "--camera 0.42,0.5,0.62/0,0.24,0.02/34 --detail 0"),
            ("near_0.4", "--camera 0.42,0.5,0.62/0,0.24,0.02/34 --detail 0.4"),
            ("near_1", "--camera 0.42,0.5,0.62/0,0.24,0.02/34 --detail 1"),
            ("near_1.5", "--camera 0.42,0.5,0.62/0,0.24,0.02/34 --detail 1.5"),
            ("near_2", "--camera 0.42,0.5,0.62/0,0.24,0.02/34 --detail 2"),
            ("near_9", "--camera 0.42,0.5,0.62/0,0.24,0.02/34 --detail 9"),
            ("auto", "--detail auto"),
            ("auto_large", "--size 834x424 --detail auto"),
            ("auto_half_way", "--camera 0.9,0.7,1.4/0,0.24,0.02/27 --detail auto"),
            ("afar", "--camera 3,1.5,4/0,0.2,0/20"),
            ("afar_auto", "--camera 3.6,1.8,4.8/0,0.2,0/20 --detail auto"),
            ("afar_0", "--camera 3,1.5,4/0,0.2,0/20 --detail 0"),
            ("afar_0.75", "--camera 3,1.5,4/0,0.2,0/20 --detail 0.75"),
            ("afar_1", "--camera 3,1.5,4/0,0.2,0/20 --detail 1"),
            ("afar_1.25", "--camera 3,1.5,4/0,0.2,0/20 --detail 1.25"),
            ("afar_2", "--camera 3,1.5,4/0,0.2,0/20 --detail 2"),
            ("farther", "--camera 8,4,10/0,0.2,0/12"),
            ("farther_auto", "--camera 8,4,10/0,0.2,0/12 --detail auto"),
            ("afar_coat_vertex", "--camera 3,1.5,4/0,0.2,0/20 --detail 2 --lighting vertex"),
            ("afar_coat_filled", "--camera 3,1.5,4/0,0.2,0/20 --detail 2 --fill-light -1,0.5,0.2/0.6"),
            ("detail_printed", "--detail 0.5 --slant printed --view-slant printed"),
            ("detail_4_samples", "--detail 1.5 --samples 4"),
            // Crowds.
            ("crowd", "--crowd 5"),
            ("crowd_auto", "--crowd 30 --detail auto --camera 2.5,1.2,3/1,0.2,-1/40"),
            ("crowd_level", "--crowd 4 --detail 0.5 --clip Walk --time 0.2"),
            ("crowd_bare", "--crowd 4 --style bare"),
            ("crowd_ink", "--crowd 4 --style ink"),
            ("crowd_ink_auto", "--crowd 12 --style ink --detail auto --camera 2.5,1.2,3/1,0.2,-1/40"),
            // Layers.
            ("layers_1", "--layers 1"),
            ("layers_6", "--layers 6"),
            ("layers_all", "--layers 16"),
            ("layers_31", "--layers 31"),
            ("layers_6_maps_11", "--layers 6 --shadow-layers 11"),
            ("layers_9_vertex", "--layers 9 --lighting vertex"),
            ("layers_9_filled", "--layers 9 --fill-light 1,0.2,-1"),
            // Light.
            ("light_left", "--light -1,0.6,0.2"),
            ("light_behind", "--light 0.1,0.5,-1"),
            ("light_below", "--light 0.3,-1,0.4"),
            ("light_above", "--light 0,1,0"),
            ("lamp", "--point-light -0.3,0.7,0.5"),
            ("lamp_near", "--point-light 0.1,0.5,0.25 --shadow-map 256"),
            ("lamp_filled", "--point-light -0.3,0.7,0.5 --fill-light 1,0,0/0.5"),
            ("lamp_bare", "--style bare --point-light -0.3,0.7,0.5"),
            ("filled", "--fill-light 1,0.3,-0.5"),
            ("filled_thrice", "--fill-light 1,0,0/0.3 --fill-light -1,0.3,0/0.6 --fill-light 0,-1,0.2/0.2"),
            ("filled_bare", "--style bare --fill-light 1,0.3,-0.5/2"),
            ("vertex", "--lighting vertex"),
            ("vertex_filled", "--lighting vertex --fill-light -1,0.3,0/0.6"),
            (
                "vertex_alone",
                "--lighting vertex --self-shadow off --soft-shadow off \
                 --ambient-attenuation off --back-attenuation off",
            ),
            // Terms and forms of the shadows.
            ("self_off", "--self-shadow off"),
            ("soft_off", "--soft-shadow off"),
            ("shadows_off", "--self-shadow off --soft-shadow off"),
            ("ambient_off", "--ambient-attenuation off"),
            ("back_off", "--back-attenuation off"),
            ("terms_off", "--self-shadow off --soft-shadow off --ambient-attenuation off --back-attenuation off"),
            ("fins_off", "--fins off"),
            ("fins_off_terms_off", "--fins off --self-shadow off --soft-shadow off --back-attenuation off"),
            ("slant_printed", "--slant printed"),
            ("view_slant_printed", "--view-slant printed"),
            ("slants_printed", "--slant printed --view-slant printed"),
            ("penumbra_hard", "--penumbra 0"),
            ("penumbra_wide", "--penumbra 0.8 --light -1,0.6,0.2"),
            ("penumbra_inner", "--penumbra-form inner --light -1,0.6,0.2"),
            ("penumbra_inner_wide", "--penumbra-form inner --penumbra 0.8 --shadow-shrink 12"),
            ("shrink_2", "--shadow-shrink 2"),
            ("shrink_16", "--shadow-shrink 16 --penumbra 0.5"),
            ("map_64", "--shadow-map 64"),
            ("map_1024", "--shadow-map 1024"),
            ("map_odd", "--shadow-map 300 --shadow-shrink 7"),
            ("maps_2", "--shadow-layers 2"),
            ("maps_7", "--shadow-layers 7"),
            ("maps_40", "--shadow-layers 40 --shadow-map 128"),
            ("maps_7_printed", "--shadow-layers 7 --slant printed"),
            ("density_0", "--shadow-density 0"),
            ("density_3", "--shadow-density 3"),
            // Poses.
            ("walk", "--clip Walk --time 0.3"),
            ("walk_before_0", "--clip Walk --time -0.1"),
            ("ears", "--clip EarBreath --time 0.7 --detail 0.5"),
            ("walk_bare", "--style bare --clip Walk --time 0.55"),
            ("walk_lamp", "--clip Walk --time 0.55 --point-light -0.3,0.7,0.5"),
            ("pictures_walk", "--frames 3 --fps 6 --clip Walk"),
            ("pictures_light", "--frames 3 --turn-light"),
            ("pictures_walk_light", "--frames 3 --fps 6 --clip Walk --turn-light --detail auto"),
            ("pictures_ink", "--frames 3 --fps 6 --clip Walk --style ink"),
            // Ink.
            ("ink_small", "--style ink"),
            ("ink_pixels", "--style ink --ink-lines pixels"),
            ("ink_gongbi", "--look gongbi"),
            ("ink_wet", "--look wet --clip Walk --time 0.3"),
            ("ink_half_done", "--style ink --look brush.progress=0.5"),
            ("ink_odd_size", "--style ink --size 199x333"),
            ("ink_4_samples", "--style ink --samples 4"),
            ("ink_walk", "--style ink --clip Walk --time 0.3"),
            ("ink_near", "--style ink --camera 0.42,0.5,0.62/0,0.24,0.02/34"),
            ("ink_afar", "--style ink --camera 3,1.5,4/0,0.2,0/20"),
            ("ink_afar_auto", "--style ink --camera 3,1.5,4/0,0.2,0/20 --detail auto"),
            ("ink_detail", "--style ink --detail 1.5"),
            ("ink_light", "--style ink --light -1,0.6,0.2"),
            ("ink_transparent", "--style ink --background transparent"),
            ("ink_paper", "--style ink --background 240,220,180 --ink-color 120,30,10 --ink-paper-grain 0.4"),
            ("ink_smooth_paper", "--style ink --ink-paper-grain 0"),
            ("ink_threshold", "--style ink --ink-lines pixels --ink-threshold 0.9 --ink-weak 0.4"),
            ("ink_normals_alone", "--style ink --ink-lines pixels --ink-depth-step 0"),
            ("ink_depth", "--style ink --ink-lines pixels --ink-depth-step 0.1 --ink-weak 0"),
            ("ink_width_px", "--style ink --ink-lines pixels --ink-width 24px"),
            ("ink_width_m", "--style ink --ink-lines pixels --ink-width 0.01m"),
            ("ink_tone", "--style ink --ink-lines pixels --ink-tone 0.9 --ink-lightness 1"),
            ("ink_swell_0", "--style ink --ink-lines pixels --ink-swell 0 --ink-pressure 0"),
            ("ink_swell_4", "--style ink --ink-lines pixels --ink-swell 4"),
            ("ink_dry", "--style ink --ink-lines pixels --ink-dryness 1 --ink-roughness 8"),
            ("ink_even", "--style ink --ink-lines pixels --ink-dryness 0 --ink-roughness 0"),
            ("ink_mist", "--style ink --ink-mist 1,2.5"),
            ("ink_rule_all", "--style ink --ink-lines pixels --ink-rule all"),
            ("ink_sphere_reflection", "--style ink --ink-lines pixels --ink-sphere-map reflection"),
            ("ink_sphere_printed", "--style ink --ink-lines pixels --ink-sphere-map printed"),
            ("ink_template_off", "--style ink --ink-lines pixels --ink-template off"),
            ("ink_printed_lines", "--style ink --ink-lines pixels --ink-printed-lines on"),
            (
                "ink_printed",
                "--style ink --ink-lines pixels --ink-printed-lines on --ink-rule all --ink-sphere-map printed \
                 --ink-template off",
            ),
            ("ink_screen", "--style ink --ink-lines pixels --ink-anchoring screen"),
            (
                "ink_screen_walk",
                "--style ink --ink-lines pixels --ink-anchoring screen --clip Walk --time 0.3 --ink-show painting",
            ),
            ("ink_lines", "--style ink --ink-lines pixels --ink-show lines"),
            ("ink_features", "--style ink --ink-lines pixels --ink-show features"),
            ("ink_wash", "--style ink --ink-lines pixels --ink-show wash"),
            (
                "ink_lines_transparent",
                "--style ink --ink-lines pixels --ink-show lines --background transparent --samples 4",
            ),
        ],
    ),
    (
        "torus",
        &[
            ("fur", "--size 834x424"),
            ("bare", "--style bare"),
            ("ink", "--style ink"),
            ("filled", "--fill-light -1,0.2,0.4/0.5"),
            ("view_slant_printed", "--view-slant printed --samples 4"),
        ],
    ),
    (
        "knot",
        &[
            ("fur", "--size 834x424"),
            ("bare", "--style bare"),
            ("ink", "--style ink"),
            ("detail", "--detail 0.5 --penumbra-form inner"),
            ("lamp", "--point-light 0.2,0.9,0.5"),
        ],
    ),
    ("ox", &[("fur", ""), ("ink", "--style ink --clip Walk --time 0.5")]),
    (
        "crane",
        &[
            ("fur", ""),
            ("ink", "--style ink --ink-lines pixels --clip Walk --time 0.5"),
            ("ink_lines", "--style ink --ink-show lines"),
        ],
    ),
    (
        "hills",
        &[
            ("bare", "--style bare"),
            ("ink", "--style ink --ink-lines pixels --ink-width 0.05m --ink-mist 15,140 --camera 0,1.5,9/0,2,0/34"),
        ],
    ),
    (
        "blocks",
        &[
            ("fur", ""),
            ("ink", "--style ink"),
            ("detail", "--detail 0.5 --clip Walk --time 0.3"),
            ("layers_6", "--layers 6"),
        ],
    ),
    (
        "directions",
        &[("fur", ""), ("vertex", "--lighting vertex"), ("filled", "--fill-light 1,0.3,-0.5"), ("ink", "--style ink")],
    ),
    ("simple", &[("fur", ""), ("auto", "--detail auto"), ("ink", "--style ink")]),
    ("layers", &[("fur", ""), ("layers_9", "--layers 9"), ("detail", "--detail 1.5"), ("ink", "--style ink")]),
    (
        "matt",
        &[("fur", ""), ("vertex", "--lighting vertex"), ("filled", "--fill-light 1,0.3,-0.5"), ("ink", "--style ink")],
    ),
    (
        "wet",
        &[
            ("fur", ""),
            ("bare", "--style bare"),
            ("ink", "--style ink"),
            ("walk_auto", "--clip Walk --time 0.3 --detail auto"),
            ("vertex", "--lighting vertex"),
            ("filled", "--fill-light 1,0.3,-0.5"),
        ],
    ),
    (
        "damp",
        &[
            ("fur", "--samples 4"),
            ("bare", "--style bare"),
            ("ink", "--style ink"),
            ("layers_6", "--layers 6 --shadow-layers 9"),
            ("detail", "--detail 1.5"),
            ("coat", "--detail 2"),
            ("lamp_filled", "--point-light -0.3,0.7,0.5 --fill-light 1,0,0/0.5"),
            ("vertex", "--lighting vertex"),
            ("slants_printed", "--slant printed --view-slant printed"),
        ],
    ),
    (
        "coat",
        &[
            ("fur", "--size 834x424"),
            ("bare", "--style bare"),
            ("ink", "--style ink"),
            ("ink_4_samples", "--style ink --samples 4"),
            ("layers_6", "--layers 6"),
            ("detail", "--detail 0.5"),
            ("coat", "--detail 2"),
            ("lamp", "--point-light 0.3,0.7,0.5"),
            ("vertex_filled", "--lighting vertex --fill-light 1,0,0/0.5"),
            ("shadows_off", "--self-shadow off --soft-shadow off"),
        ],
    ),
    ("lean", &[("fur", ""), ("detail", "--detail 0.5"), ("coat", "--detail 2"), ("layers_24", "--layers 24")]),
    ("zebra", &[("fur", ""), ("bare", "--style bare"), ("ink", "--style ink"), ("detail", "--detail 1.5")]),
    ("spots", &[("fur", ""), ("fins_off", "--fins off"), ("vertex", "--lighting vertex")]),
    (
        "holes",
        &[
            ("fur", "--size 834x424"),
            ("bare", "--style bare"),
            ("bare_4_samples", "--style bare --samples 4"),
            ("ink", "--style ink"),
            ("ink_lines", "--style ink --ink-show lines"),
            ("lamp", "--point-light 0.3,0.7,0.5"),
            ("detail", "--detail 1.5"),
            ("layers_6", "--layers 6"),
            ("filled", "--fill-light -1,0.2,0.4/0.5"),
        ],
    ),
    ("twins", &[("fur", ""), ("bare", "--style bare"), ("ink", "--style ink")]),
    (
        "mirrored",
        &[
            ("fur", ""),
            ("walk", "--clip Walk --time 0.3"),
            ("bare", "--style bare --clip Walk --time 0.3"),
            ("ink", "--style ink --clip Walk --time 0.3"),
        ],
    ),
    (
        "walk",
        &[
            ("start", ""),
            ("large", "--size 834x424 --time 1"),
            ("later", "--time 3.3 --samples 4"),
            ("screen", "--time 1 --ink-anchoring screen"),
            ("fur", "--style fur --time 1"),
            ("auto", "--style fur --time 1 --detail auto"),
            ("pictures", "--frames 2 --fps 2"),
        ],
    ),
    (
        "meeting",
        &[
            ("fur", "--size 834x424 --time 0.3"),
            ("auto", "--time 0.3 --detail auto"),
            ("sun", "--light -1,1,0.5 --samples 4"),
            ("bare", "--style bare"),
            ("ink", "--style ink --time 0.6"),
            ("layers_9", "--layers 9"),
            ("pictures", "--frames 3 --fps 4"),
        ],
    ),
    (
        "fox",
        &[
            ("fur", "--size 834x424 --clip Walk --time 0.3"),
            ("bare", "--style bare"),
            ("ink", "--style ink"),
            ("run", "--clip Run --time 0.5 --samples 4"),
            ("run_ink", "--clip Run --time 0.5 --style ink"),
            ("auto", "--detail auto"),
            ("detail", "--detail 0.5 --lighting vertex"),
            ("filled", "--fill-light 1,0.3,-0.5"),
            ("crowd", "--crowd 4 --clip Survey --time 1"),
        ],
    ),
    (
        "horse",
        &[
            ("fur", "--clip AnimalArmature|Gallop --time 0.2"),
            ("bare", "--style bare"),
            ("ink", "--style ink --clip AnimalArmature|Walk --time 0.4"),
            ("detail", "--detail 1.5"),
            ("coat", "--detail 2"),
        ],
    ),
    ("cow", &[("fur", ""), ("ink", "--style ink")]),
    ("spot", &[("fur", ""), ("ink", "--style ink"), ("bare", "--style bare")]),
    ("duck", &[("fur", "--detail auto"), ("bare", "--style bare"), ("ink", "--style ink")]),
    ("bunny", &[("fur", ""), ("ink", "--style ink")]),
];

/// Cases of `--bench`: package, and options of `pelage bench`.
const MEASURED: &[(&str, &str)] = &[("hare", ""), ("bunny", ""), ("hare", "--style ink")];

const DIFFERENT: u8 = 7;
const INCOMPLETE: u8 = 2;

pub fn run(arguments: &[String]) -> anyhow::Result<ExitCode> {
    let mut binaries = Vec::new();
    let mut out = workspace().join("target/same_pictures");
    let (mut only, mut bench, mut rounds) = (String::new(), false, 5);
    let mut arguments = arguments.iter().cloned();
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().with_context(|| format!("{argument} needs a value"));
        match argument.as_str() {
            "-o" => out = value()?.into(),
            "--only" => only = value()?,
            "--bench" => bench = true,
            "--rounds" => {
                rounds = value()?.parse().ok().filter(|n| *n > 0).context("--rounds: expected a number of rounds")?;
            }
            other if other.starts_with('-') => bail!("unknown argument {other:?}; expected {ARGUMENTS}"),
            _ => binaries.push(argument),
        }
    }
    let [before, after] = binaries.as_slice() else { bail!("expected {ARGUMENTS}") };
    // OUT is made absolute, because the binaries run in the workspace folder.
    let out = std::path::absolute(out)?;
    for folder in ["packages", "packages_after", "pictures", "made"] {
        std::fs::create_dir_all(out.join(folder)).with_context(|| format!("cannot make {}", out.display()))?;
    }
    let data = pelage_needs::data_folder();
    let data = data.is_dir().then(|| std::path::absolute(&data)).transpose()?;
    if data.is_none() {
        eprintln!("note: without the test data, the cases of its models are skipped");
    }
    let pair =
        Pair { before: Binary::new("before", before, &out)?, after: Binary::new("after", after, &out)?, data, out };
    if std::fs::read(&pair.before.path)? == std::fs::read(&pair.after.path)? {
        eprintln!("note: BEFORE and AFTER are identical files");
    }
    make_sources(&pair.out.join("made"))?;
    if bench { pair.bench(rounds) } else { pair.compare(&only) }
}

const ARGUMENTS: &str = "BEFORE AFTER [-o OUT] [--only WORD], or BEFORE AFTER --bench [--rounds N] [-o OUT]";

/// Binary to compare, and its side of the comparison: before or after.
struct Binary {
    side: &'static str,
    path: PathBuf,
    out: PathBuf,
}

impl Binary {
    fn new(side: &'static str, path: &str, out: &Path) -> anyhow::Result<Self> {
        let path = std::fs::canonicalize(path).with_context(|| format!("{side}: no binary at {path}"))?;
        Ok(Self { side, path, out: out.into() })
    }

    /// Runs the binary to completion and returns its JSON output.
    fn run(&self, arguments: &[String]) -> anyhow::Result<Value> {
        let mut command = Command::new(&self.path);
        command.args(arguments).args(["--json", "--quiet"]).current_dir(workspace()).stdin(Stdio::null());
        // If the variable is unset, Mesa's device selection prints lines to stderr; see `Sandbox::command`.
        command.env("XDG_RUNTIME_DIR", &self.out);
        let output = command.output().with_context(|| format!("cannot run {}", self.path.display()))?;
        let stderr = String::from_utf8_lossy(&output.stderr);
        ensure!(output.status.success(), "{}: {}: {}", self.side, output.status, stderr.trim());
        serde_json::from_slice(&output.stdout).with_context(|| format!("{}: no JSON on stdout", self.side))
    }

    /// Draws a case and returns its pictures in order.
    fn draw(&self, case: &Case) -> anyhow::Result<Vec<(PathBuf, RgbaImage)>> {
        let mut arguments = vec!["render".into(), self.out.join("packages").join(case.file()).display().to_string()];
        let number = if case.options.contains("--frames") { ".%02d" } else { "" };
        let picture = self.out.join("pictures").join(format!("{}.{}{number}.png", case.name(), self.side));
        arguments.extend(["-o".into(), picture.display().to_string()]);
        if !number.is_empty() {
            arguments.push("--restart".into());
        }
        if !case.options.contains("--size") {
            arguments.extend(["--size".into(), "417x212".into()]);
        }
        arguments.extend(case.options.split_whitespace().map(String::from));
        let report = self.run(&arguments)?;
        let outputs = report["outputs"].as_array().context("the report of render lists no pictures")?;
        let read = |path: &Value| {
            let path = PathBuf::from(path.as_str().context("a picture without a name")?);
            let picture = image::open(&path).with_context(|| format!("cannot read {}", path.display()))?;
            let picture = picture.as_rgba8().cloned().context("expected a picture of RGBA, 8 bits each")?;
            Ok((path, picture))
        };
        outputs.iter().map(read).collect()
    }
}

/// Picture or sequence to compare.
struct Case {
    subject: &'static str,
    case: &'static str,
    options: &'static str,
}

impl Case {
    /// Returns all cases.
    fn all() -> impl Iterator<Item = Self> {
        CASES.iter().flat_map(|(subject, cases)| cases.iter().map(|(case, options)| Self { subject, case, options }))
    }

    fn name(&self) -> String {
        format!("{}_{}", self.subject, self.case)
    }

    /// Returns the names of the packages in this case.
    fn packages(&self) -> Vec<&'static str> {
        self.scene().map_or(vec![self.subject], |(packages, _)| packages.to_vec())
    }

    /// Returns the packages and the text of the scene; `None` if the case is a package.
    fn scene(&self) -> Option<(&'static [&'static str], &'static str)> {
        SCENES.iter().find(|scene| scene.0 == self.subject).map(|scene| (scene.1, scene.2))
    }

    /// Returns the name of the file in `packages` that is drawn.
    fn file(&self) -> String {
        format!("{}.{}", self.subject, if self.scene().is_some() { "toml" } else { "pelage" })
    }
}

/// Returns whether the package's model is in the shared test data.
fn needs_data(package: &str) -> bool {
    PACKAGES.iter().any(|(name, model, _)| *name == package && model.starts_with("data/"))
}

/// Both binaries, and the folder OUT.
struct Pair {
    before: Binary,
    after: Binary,
    data: Option<PathBuf>,
    out: PathBuf,
}

impl Pair {
    /// Bakes a package with one of the binaries into a folder of OUT. Texels are uncompressed unless the options in
    /// `PACKAGES` say otherwise. Uncompressed texels need no encoder, and their pictures are equal whether or not a
    /// binary decodes textures at load.
    fn bake(&self, binary: &Binary, folder: &str, name: &str) -> anyhow::Result<PathBuf> {
        let (_, model, options) =
            PACKAGES.iter().find(|p| p.0 == name).with_context(|| format!("no package {name}"))?;
        let package = self.out.join(folder).join(format!("{name}.pelage"));
        let place = |word: &str| match (word.split_once('/'), &self.data) {
            (Some(("made", file)), _) => self.out.join("made").join(file).display().to_string(),
            (Some(("data", file)), Some(data)) => data.join("meshes").join(file).display().to_string(),
            _ => word.to_owned(),
        };
        let mut arguments = vec!["bake".into(), place(model), "-o".into(), package.display().to_string()];
        let plain = ["--set", "pack.shell_format=rgba8", "--set", "pack.direction_format=rg8"];
        arguments.extend(plain.into_iter().chain(options.split_whitespace()).map(place));
        binary.run(&arguments).with_context(|| format!("package {name}"))?;
        Ok(package)
    }

    /// Compares all cases that `only` selects, and prints the differences to stdout.
    fn compare(&self, only: &str) -> anyhow::Result<ExitCode> {
        let start = Instant::now();
        let wanted: Vec<Case> = Case::all().filter(|case| case.name().contains(only)).collect();
        ensure!(!wanted.is_empty(), "no case with {only:?} in its name");
        let has_data = |case: &Case| self.data.is_some() || !case.packages().into_iter().any(needs_data);
        let (cases, left_out): (Vec<_>, Vec<_>) = wanted.into_iter().partition(has_data);

        let needed = |package: &str| cases.iter().any(|case| case.packages().contains(&package));
        let packages: Vec<_> = PACKAGES.iter().map(|package| package.0).filter(|name| needed(name)).collect();
        let mut different = Vec::new();
        for name in &packages {
            let before = self.bake(&self.before, "packages", name)?;
            let after = self.bake(&self.after, "packages_after", name);
            let found = after.and_then(|after| first_difference(&before, &after));
            different.extend(report(format!("package {name}"), found));
        }
        let different_packages = different.len();
        for (name, _, text) in SCENES {
            std::fs::write(self.out.join("packages").join(format!("{name}.toml")), text)?;
        }
        for case in &cases {
            let found = self.difference(case).map(|found| (found.channels > 0).then(|| found.to_string()));
            different.extend(report(case.name(), found));
        }
        println!(
            "\n{} of {} cases and {} of {} packages are the same; {:.0} s",
            cases.len() - (different.len() - different_packages),
            cases.len(),
            packages.len() - different_packages,
            packages.len(),
            start.elapsed().as_secs_f64()
        );
        if !different.is_empty() {
            println!("DIFFERENT: {}; see {}", different.join(", "), self.out.display());
        }
        let left_out: Vec<_> = left_out.iter().map(Case::name).collect();
        if !left_out.is_empty() {
            println!("LEFT OUT, without the shared test data: {}", left_out.join(", "));
        }
        Ok(ExitCode::from(match (different.is_empty(), left_out.is_empty()) {
            (false, _) => DIFFERENT,
            (true, false) => INCOMPLETE,
            (true, true) => 0,
        }))
    }

    /// Draws a case with both binaries, and returns the summed difference of its pictures. Identical pictures are
    /// deleted.
    fn difference(&self, case: &Case) -> anyhow::Result<ByteDifference> {
        let (before, after) = (self.before.draw(case)?, self.after.draw(case)?);
        ensure!(before.len() == after.len(), "{} pictures before, {} after", before.len(), after.len());
        let mut sum = ByteDifference::default();
        for ((before_path, before), (after_path, after)) in before.iter().zip(&after) {
            ensure!(
                before.pixels().any(|p| p != before.get_pixel(0, 0)),
                "the picture of BEFORE is empty: all its pixels are equal"
            );
            let found = ByteDifference::between(before, after)?;
            if found.channels == 0 {
                std::fs::remove_file(before_path)?;
                std::fs::remove_file(after_path)?;
            }
            sum = sum.combine(found);
        }
        Ok(sum)
    }

    /// Times both binaries alternately and prints the cost of each pass to stdout.
    fn bench(&self, rounds: usize) -> anyhow::Result<ExitCode> {
        println!("| package | pass | before, ms | after, ms | after / before |\n|---|---|---|---|---|");
        let mut left_out = Vec::new();
        for (name, options) in MEASURED {
            if self.data.is_none() && needs_data(name) {
                left_out.push(*name);
                continue;
            }
            let package = self.bake(&self.before, "packages", name)?.display().to_string();
            let words = ["bench", &package, "--frames", "20"].into_iter().chain(options.split_whitespace());
            let arguments: Vec<String> = words.map(String::from).collect();
            let mut reports = Vec::new();
            for _ in 0..rounds {
                reports.push([pass_times(&self.before.run(&arguments)?)?, pass_times(&self.after.run(&arguments)?)?]);
            }
            let subject = [*name, options].join(" ");
            for (pass, _) in &reports[0][0] {
                // A pass has no row if only one of the binaries has it, or if it has no time.
                let of = |costs: &PassTimes| costs.iter().find(|cost| cost.0 == *pass).map(|cost| cost.1);
                let pairs = reports.iter().map(|[before, after]| Some((of(before)?, of(after)?)));
                let Some(pairs) = pairs.collect::<Option<Vec<_>>>() else { continue };
                println!(
                    "| {} | {pass} | {:.2} | {:.2} | {:.3} |",
                    subject.trim(),
                    median(pairs.iter().map(|p| p.0)),
                    median(pairs.iter().map(|p| p.1)),
                    median(pairs.iter().map(|p| p.1 / p.0)),
                );
            }
        }
        println!(
            "\nMedians of {rounds} rounds. In each round, both binaries ran, one after the other. \
             Ratios are medians of the rounds' ratios."
        );
        if left_out.is_empty() {
            return Ok(ExitCode::SUCCESS);
        }
        println!("LEFT OUT, without the shared test data: {}", left_out.join(", "));
        Ok(ExitCode::from(INCOMPLETE))
    }
}

/// Difference of two pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct ByteDifference {
    /// Number of channels that differ, of up to four per pixel.
    channels: usize,
    /// Number of compared channels.
    of: usize,
    /// Greatest difference of any channel, 0..=255.
    greatest: u8,
}

impl ByteDifference {
    fn between(before: &RgbaImage, after: &RgbaImage) -> anyhow::Result<Self> {
        let (a, b) = (before.dimensions(), after.dimensions());
        ensure!(a == b, "{}x{} pixels before, {}x{} after", a.0, a.1, b.0, b.1);
        let apart = before.as_raw().iter().zip(after.as_raw()).map(|(x, y)| x.abs_diff(*y));
        Ok(Self {
            channels: apart.clone().filter(|d| *d > 0).count(),
            of: before.as_raw().len(),
            greatest: apart.max().unwrap_or(0),
        })
    }

    /// Adds the counts of two differences.
    fn combine(self, other: Self) -> Self {
        Self {
            channels: self.channels + other.channels,
            of: self.of + other.of,
            greatest: self.greatest.max(other.greatest),
        }
    }
}

impl std::fmt::Display for ByteDifference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let share = 100.0 * self.channels as f64 / self.of as f64;
        write!(f, "DIFFERS: {} channels, {share:.3} % of all, by at most {}", self.channels, self.greatest)
    }
}

/// Prints the result of one comparison. Returns its name, or `None` if nothing differs.
fn report(name: String, found: anyhow::Result<Option<String>>) -> Option<String> {
    let words = match found {
        Ok(None) => {
            println!("{name:<32} same");
            return None;
        }
        Ok(Some(words)) => words,
        Err(error) => format!("FAILED: {}", format!("{error:#}").lines().next().unwrap_or_default()),
    };
    println!("{name:<32} {words}");
    Some(name)
}

/// Describes the first difference of two files. If they are equal, removes `after` and returns `None`.
fn first_difference(before: &Path, after: &Path) -> anyhow::Result<Option<String>> {
    let (a, b) = (std::fs::read(before)?, std::fs::read(after)?);
    if a == b {
        std::fs::remove_file(after)?;
        return Ok(None);
    }
    let first = a.iter().zip(&b).position(|(x, y)| x != y).unwrap_or(a.len().min(b.len()));
    Ok(Some(format!("DIFFERS: {} bytes before, {} after, from byte {first} on", a.len(), b.len())))
}

/// Names of passes and other steps in the report of `pelage bench`, with their times in milliseconds.
type PassTimes = Vec<(String, f64)>;

fn pass_times(report: &Value) -> anyhow::Result<PassTimes> {
    let passes = report["passes"].as_array().context("the report of bench lists no passes")?;
    let named = passes.iter().filter_map(|p| Some((p["name"].as_str()?.to_owned(), p["median_ms"].as_f64()?)));
    let whole = [
        ("whole frame", &report["frame_ms"]["median"]),
        ("frame without shadows", &report["unshadowed_frame_ms"]["median"]),
        ("loading: upload", &report["upload_ms"]),
        ("loading: pipelines", &report["pipelines_ms"]),
    ];
    // A pass that the style does not use has a time of 0.
    let whole = whole.iter().filter_map(|(name, ms)| Some(((*name).to_owned(), ms.as_f64()?)));
    Ok(named.chain(whole).filter(|cost| cost.1 > 0.0).collect())
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { (values[middle - 1] + values[middle]) / 2.0 }
}

/// Generates models and a recipe for features that no committed file has: holes in a texture, mirrored nodes, a groom
/// painted on an image.
fn make_sources(folder: &Path) -> anyhow::Result<()> {
    let disc = |x: u32, y: u32| (x % 32).abs_diff(16).pow(2) + (y % 32).abs_diff(16).pow(2) < 100;
    let holes = |x, y| Rgba([(x * 4) as u8, 160, (y * 4) as u8, if disc(x, y) { 0 } else { 255 }]);
    RgbaImage::from_fn(64, 64, holes).save(folder.join("holes.png"))?;
    edit("torus", &folder.join("holes.glb"), |model| {
        model["images"] = json!([{ "uri": "holes.png" }]);
        model["textures"] = json!([{ "source": 0 }]);
        let material = &mut model["materials"][0];
        material["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
        material["alphaMode"] = json!("MASK");
        material["doubleSided"] = json!(true);
    })?;
    edit("knot", &folder.join("twins.glb"), |model| {
        model["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0, "scale": [-1, 1, 1], "translation": [0.6, 0, 0] }]);
        model["scenes"][0]["nodes"] = json!([0, 1]);
    })?;
    edit("hare", &folder.join("mirrored.glb"), |model| {
        let Some(nodes) = model["nodes"].as_array_mut() else { return };
        nodes.push(json!({ "scale": [-1, 1, 1], "children": [1] }));
        let mirror = nodes.len() - 1;
        model["scenes"][0]["nodes"] = json!([0, mirror]);
    })?;

    // Channels: red is bareness, green is wetness, blue is lean of the hair.
    let coat = |x, y| Rgba([if disc(x, y) { 255 } else { 0 }, (x * 2) as u8, (y * 2) as u8, 255]);
    RgbaImage::from_fn(128, 128, coat).save(folder.join("coat.png"))?;
    let recipe = "[surface]\ntile_size_m = 0.04883\n\n[hair]\nlength_m = 0.03\n\n\
        [groom]\nbare = \"coat.png#r\"\nwetness = \"coat.png#g\"\nlean = \"coat.png#b\"\n";
    Ok(std::fs::write(folder.join("coat.toml"), recipe)?)
}

/// Writes a copy of a model of `assets` with a modified JSON chunk.
fn edit(name: &str, to: &Path, change: impl FnOnce(&mut Value)) -> anyhow::Result<()> {
    let from = workspace().join("assets/models").join(format!("{name}.glb"));
    let glb = std::fs::read(&from).with_context(|| format!("cannot read {}", from.display()))?;
    // The header has magic, version and length; then come length and type of the JSON chunk.
    let length = glb.get(12..16).and_then(|bytes| bytes.try_into().ok()).map_or(0, u32::from_le_bytes) as usize;
    let (json, rest) = glb.get(20..).and_then(|rest| rest.split_at_checked(length)).context("no binary glTF")?;
    let mut model: Value = serde_json::from_slice(json)?;
    change(&mut model);
    // The length and type of the binary chunk are skipped.
    let binary = rest.get(8..).context("no binary chunk")?;
    std::fs::write(to, container(&model, binary)?).with_context(|| format!("cannot write {}", to.display()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn single_channel_difference_is_detected() {
        let before = RgbaImage::from_fn(7, 5, |x, y| Rgba([x as u8, y as u8, 9, 255]));
        let same = ByteDifference::between(&before, &before).unwrap();
        assert_eq!(same, ByteDifference { channels: 0, of: 140, greatest: 0 });
        let mut after = before.clone();
        after.get_pixel_mut(3, 2)[2] += 1;
        assert_eq!(
            ByteDifference::between(&before, &after).unwrap(),
            ByteDifference { channels: 1, of: 140, greatest: 1 }
        );
        assert_eq!(ByteDifference::between(&after, &before).unwrap().channels, 1);
        // Checks that a difference of colour counts even if the texel is transparent.
        let clear = RgbaImage::new(7, 5);
        let mut coloured = clear.clone();
        coloured.get_pixel_mut(6, 4)[0] = 200;
        let found = ByteDifference::between(&clear, &coloured).unwrap();
        assert_eq!(found, ByteDifference { channels: 1, of: 140, greatest: 200 });
        assert_eq!(found.combine(same), ByteDifference { channels: 1, of: 280, greatest: 200 });
        assert!(ByteDifference::between(&clear, &RgbaImage::new(5, 7)).is_err());
    }

    #[test]
    fn single_byte_difference_is_detected() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
        for (before, after, words) in [
            (&b"same"[..], &b"same"[..], None),
            (b"same", b"some", Some("DIFFERS: 4 bytes before, 4 after, from byte 1 on")),
            (b"same", b"sameness", Some("DIFFERS: 4 bytes before, 8 after, from byte 4 on")),
        ] {
            std::fs::write(&a, before).unwrap();
            std::fs::write(&b, after).unwrap();
            assert_eq!(first_difference(&a, &b).unwrap().as_deref(), words);
            assert_eq!(b.exists(), words.is_some());
        }
    }

    #[test]
    fn case_list_is_complete() {
        let names: Vec<_> = Case::all().map(|case| case.name()).collect();
        assert!(names.len() >= 44);
        assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len(), "two cases have the same name");
        let pictures: BTreeSet<_> = Case::all().map(|case| (case.subject, case.options)).collect();
        assert_eq!(pictures.len(), names.len(), "two cases draw the same picture");
        let used: BTreeSet<_> = Case::all().flat_map(|case| case.packages()).collect();
        let baked: BTreeSet<_> = PACKAGES.iter().map(|package| package.0).collect();
        assert_eq!(used, baked, "packages of the cases and baked packages must be the same");
    }

    #[test]
    fn medians_are_correct() {
        assert_eq!(median([3.0, 1.0, 2.0].into_iter()), 2.0);
        assert_eq!(median([4.0, 1.0, 2.0, 3.0].into_iter()), 2.5);
    }
}
