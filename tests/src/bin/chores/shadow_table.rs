//! Measures the cost of shadows as in Table 1 of Yang 2006, and prints the paper's figures beside it as ratios: `chores
//! shadow-table [MODEL [bake options] [+ MODEL [bake options]]…]`.
//!
//! Bakes and measures the built-in torus, knot and hare, and the given models, with `pelage bench` at its defaults.
//! Times are medians in milliseconds; ratios are medians of the ratios of each frame.

use anyhow::Context as _;
use pelage_tests::binary::workspace;
use pelage_tests::chores::ChoreFolder;
use serde_json::Value;
use std::path::Path;

/// Table 1 of the paper: model; triangles; milliseconds of the layer-wise maps, and of the depth and shadow-width maps;
/// frames per second without and with shadows.
const PAPER: [(&str, u32, f64, f64, f64, f64); 5] = [
    ("torus", 567, 80.0, 15.0, 65.3, 38.7),
    ("bunny", 5_000, 100.0, 20.0, 16.7, 10.5),
    ("knot", 2_880, 100.0, 15.0, 20.0, 12.0),
    ("clothes", 1_401, 90.0, 15.0, 33.4, 20.0),
    ("zebra", 6_010, 110.0, 15.0, 14.3, 9.2),
];

pub fn run(arguments: &[String]) -> anyhow::Result<()> {
    let asset = |kind: &str, name: String| workspace().join("assets").join(kind).join(name).display().to_string();
    let built_in = ["torus", "knot", "hare"].map(|name| {
        vec![asset("models", format!("{name}.glb")), "--recipe".into(), asset("recipes", format!("{name}.toml"))]
    });
    let given = arguments.split(|a| a == "+").filter(|m| !m.is_empty()).map(<[String]>::to_vec);
    let workshop = ChoreFolder::default();
    println!(
        "| model | triangles | layer-wise maps, ms | shadow width, ms | \
         frame without, ms | frame with, ms | with / without | maps / frame with | shells / yardstick |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for model in built_in.into_iter().chain(given) {
        let name = Path::new(&model[0]).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let row = measure(&workshop, &name, &model).with_context(|| model[0].clone())?;
        println!("{row}");
    }
    for (name, triangles, layers, width, without, with) in PAPER {
        let (without, with) = (1e3 / without, 1e3 / with);
        let (ratio, maps) = (with / without, (layers + width) / with);
        println!(
            "| {name} (paper) | {triangles} | {layers:.0} | {width:.0} | \
             {without:.1} | {with:.1} | {ratio:.2} | {maps:.2} | |"
        );
    }
    Ok(())
}

fn measure(workshop: &ChoreFolder, name: &str, model: &[String]) -> anyhow::Result<String> {
    let package = workshop.bake(name, model)?.package.display().to_string();
    let report: Value = serde_json::from_str(&workshop.run(&["bench", &package, "--json", "--quiet"])?.stdout)?;
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let passes = report["passes"].as_array().context("the report of bench lists no passes")?;
    let pass = |name: &str| passes.iter().find(|p| p["name"] == name).map_or(f64::NAN, |p| number(&p["median_ms"]));
    Ok(format!(
        "| {name} | {} | {:.1} | {:.1} | {:.1} | {:.1} | {:.2} | {:.2} | {:.2} |",
        report["triangles"],
        pass("layer_shadow"),
        pass("shadow_width"),
        number(&report["unshadowed_frame_ms"]["median"]),
        number(&report["frame_ms"]["median"]),
        number(&report["frame_over_unshadowed"]),
        number(&report["shadow_maps_over_frame"]),
        number(&report["shells_over_yardstick"]),
    ))
}
