//! Tests of `pelage chart` with the real binary.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_needs::data;
use pelage_tests::binary::{Run, Sandbox};
use pelage_tests::gpu::gpu;
use pelage_tests::schema;
use serde_json::Value;
use std::process::Stdio;
use std::time::Duration;

#[track_caller]
fn json_of(run: &Run) -> Value {
    schema::parse_success(run, "chart")
}

/// Parses a CSV text into rows of fields.
fn csv(text: &str) -> Vec<Vec<String>> {
    let (mut rows, mut row, mut field, mut quoted) = (Vec::new(), Vec::new(), String::new(), false);
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '"' if quoted && chars.peek() == Some(&'"') => field.push(chars.next().unwrap()),
            '"' => quoted = !quoted,
            ',' if !quoted => row.push(std::mem::take(&mut field)),
            '\n' if !quoted => {
                row.push(std::mem::take(&mut field).trim_end_matches('\r').to_owned());
                rows.push(std::mem::take(&mut row));
            }
            _ => field.push(c),
        }
    }
    assert!(!quoted && field.is_empty() && row.is_empty(), "the table ends within a line");
    rows
}

/// Writes a coarse torus with texture coordinates as an OBJ file.
fn torus(sandbox: &Sandbox) {
    let (long, short) = (24, 10);
    let mut text = String::new();
    for i in 0..=long {
        for j in 0..=short {
            let (u, v) = (i as f32 / long as f32, j as f32 / short as f32);
            let (a, b) = ((u * std::f32::consts::TAU).sin_cos(), (v * std::f32::consts::TAU).sin_cos());
            let r = 1.0 + 0.4 * b.1;
            text += &format!("v {} {} {}\nvt {u} {v}\n", r * a.1, 0.4 * b.0, r * a.0);
        }
    }
    for i in 0..long {
        for j in 0..short {
            let at = |i: usize, j: usize| i * (short + 1) + j + 1;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            text += &format!("f {d}/{d} {c}/{c} {b}/{b} {a}/{a}\n");
        }
    }
    sandbox.write("my torus.obj", text);
}

/// Splits a command into words like a shell; supports single quotes only.
fn words(command: &str) -> Vec<String> {
    let (mut out, mut word, mut quoted) = (Vec::new(), String::new(), false);
    for c in command.chars() {
        match c {
            '\'' => quoted = !quoted,
            ' ' if !quoted => out.push(std::mem::take(&mut word)),
            _ => word.push(c),
        }
    }
    out.push(word);
    out
}

#[test]
fn surface_chart_is_reproducible() {
    let sandbox = Sandbox::new().with_lab();
    torus(&sandbox);
    let set = "surface.comb_smoothing=0.25";
    let run = sandbox.run(&["chart", "surface", "my torus.obj", "-o", "out", "--set", set, "--json"]);
    let object = json_of(&run);
    assert_eq!(sandbox.files(), ["my torus.obj", "out/", "out/surface.csv", "out/surface.svg"]);
    let rows = object["rows"].as_array().unwrap();
    assert!(rows.len() > 20);

    // Checks that the CSV table has the same contents.
    let table = csv(&std::fs::read_to_string(sandbox.path().join("out/surface.csv")).unwrap());
    assert_eq!(table.len(), rows.len() + 1);
    assert!(table.iter().all(|line| line.len() == table[0].len()));
    let column = |name: &str| table[0].iter().position(|c| c == name).unwrap_or_else(|| panic!("no column {name}"));
    for name in
        ["series", "adapter", "default", "on_front", "on_front_seconds", "command", "surface.patch_size", "seconds"]
    {
        column(name);
    }
    let figures = |name: &str| -> Vec<f64> {
        let c = column(name);
        table[1..].iter().map(|line| line[c].parse().unwrap()).collect()
    };
    let (seams, angles) = (figures("seam_length_ratio"), figures("angle_distortion"));
    assert!(figures("flipped_triangles").iter().all(|n| *n == 0.0));
    assert!(figures("seconds").iter().all(|s| *s > 0.0));
    // Computes the Pareto front again: rows on it are not dominated, all other rows are.
    let beaten = |i: usize| {
        (0..rows.len())
            .any(|j| seams[j] <= seams[i] && angles[j] <= angles[i] && (seams[j] < seams[i] || angles[j] < angles[i]))
    };
    for (i, row) in rows.iter().enumerate() {
        assert_eq!(row["on_front"].as_bool().unwrap(), !beaten(i), "{row}");
    }
    assert_eq!(rows.iter().filter(|r| r["default"] == true).count(), 1);
    // The chart shows that more seams give less distortion, so the rows must differ in seam length.
    let (most, least) = (seams.iter().copied().fold(0.0, f64::max), seams.iter().copied().fold(f64::MAX, f64::min));
    assert!(most > 1.5 * least, "seams from {least} to {most}");

    let svg = std::fs::read_to_string(sandbox.path().join("out/surface.svg")).unwrap();
    assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
    for text in ["torus", "seam length", "surface stage, seconds", "angle distortion", "patch size", "default", "front"]
    {
        assert!(svg.contains(text), "no {text:?} in the picture");
    }

    // Checks that the command of a row reproduces its values.
    let row = rows.iter().find(|r| r["surface.patch_turn_deg"] == 10.0).unwrap();
    let command = row["command"].as_str().unwrap();
    assert!(command.starts_with("pelage bake 'my torus.obj'") && command.contains(set), "{command}");
    let baked = sandbox.run(&words(command)[1..]);
    let baked: Value = serde_json::from_str(&baked.stdout).unwrap_or_else(|e| panic!("{e}: {baked:?}"));
    for name in ["angle_distortion", "seam_length_ratio", "patches", "stretch_l2"] {
        assert_eq!(row[name].as_f64(), baked[name].as_f64(), "{name}");
    }
}

#[test]
fn killed_chart_resumes() {
    let sandbox = Sandbox::new().with_lab();
    torus(&sandbox);
    let args = ["chart", "surface", "my torus.obj", "-o", "out", "--json"];
    let path = sandbox.path().join("out/surface.rows.jsonl");
    let lines = || -> Vec<Value> {
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        text.split_inclusive('\n').filter_map(|line| serde_json::from_str(line).ok()).collect()
    };
    let mut child = sandbox.command(&args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    while lines().len() < 3 {
        assert_eq!(child.try_wait().unwrap(), None, "it ended before it could be killed");
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let kept = lines();
    assert!(!sandbox.files().contains(&"out/surface.csv".to_owned()), "an incomplete table was written");

    // Checks that a run for a few rows keeps the other files of the folder.
    charted(&sandbox, "surface", "2", &["my torus.obj"]);
    assert_eq!(lines().len(), kept.len());

    let run = sandbox.run(&args);
    let object = json_of(&run);
    assert!(run.stderr.contains(&format!("{} of", kept.len())), "{}", run.stderr);
    for line in &kept {
        // Measured times never repeat exactly, so an equal time shows that the row was not measured again.
        let row = &object["rows"][line["row"].as_u64().unwrap() as usize - 1];
        let cells = line["cells"].as_array().unwrap();
        assert_eq!(row["seconds"], cells[cells.len() - 1], "{row}");
    }
    assert!(!path.exists(), "the journal must be removed when the table is complete");

    // With a different recipe or with `--restart`, the rows of earlier runs must be ignored. Here those rows have an
    // impossible time, so that they can be recognised.
    let old = |line: &Value| {
        let mut line = line.clone();
        *line["cells"].as_array_mut().unwrap().last_mut().unwrap() = (-1.0).into();
        format!("{line}\n")
    };
    for more in [&["--set", "surface.comb_smoothing=0.25"][..], &["--restart"]] {
        std::fs::write(&path, kept.iter().map(old).collect::<String>()).unwrap();
        let rows = charted(&sandbox, "surface", "1", &[&["my torus.obj"], more].concat());
        assert!(rows[0]["seconds"].as_f64() > Some(0.0), "{more:?}: {}", rows[0]);
    }
}

#[test]
fn textures_chart_is_reproducible() {
    let sandbox = Sandbox::new().with_lab();
    let small = ["slice.tile_texels=32", "slice.layers=6", "hair.density=100"];
    let sets: Vec<&str> = small.iter().flat_map(|set| ["--set", set]).collect();
    let object = json_of(&sandbox.run(&[&["chart", "textures", "-o", "out", "--json"], &sets[..]].concat()));
    let rows = object["rows"].as_array().unwrap();
    assert_eq!(rows.iter().filter(|r| r["default"] == true).count(), 1);
    assert!(rows.iter().any(|r| r["pack.shell_format"] == "bc7" && r["pack.bc_quality"] == "slow"), "{rows:?}");
    assert!(rows.iter().any(|r| r["pack.direction_format"] == "bc5" && r["direction_error_deg"].is_number()));
    let svg = std::fs::read_to_string(sandbox.path().join("out/textures.svg")).unwrap();
    for text in
        ["32² × 6", "shell texture, bytes", "RMSE of colour", "change of coverage", "degrees", "rg8", "measured on"]
    {
        assert!(svg.contains(text), "no {text:?} in the picture");
    }
    let row = rows.iter().find(|r| r["mip_filter"] == "mean of each layer" && r["pack.shell_format"] == "bc7").unwrap();
    assert_reproduced(&sandbox, row, &["color_rmse", "opacity_rmse", "coverage_drift", "shell_bytes"]);
}

/// Runs `pelage chart` for the rows `rows`, and returns them.
fn charted(sandbox: &Sandbox, topic: &str, rows: &str, more: &[&str]) -> Vec<Value> {
    let args = [&["chart", topic, "-o", "out", "--rows", rows, "--json"], more].concat();
    let object = json_of(&sandbox.run(&args));
    assert_eq!(object["topic"], topic);
    let files = [format!("out/{topic}.csv"), format!("out/{topic}.svg")];
    assert!(files.iter().all(|f| sandbox.files().contains(f)), "{:?}", sandbox.files());
    let rows = object["rows"].as_array().unwrap().clone();
    let table = csv(&std::fs::read_to_string(sandbox.path().join(&files[0])).unwrap());
    assert_eq!(table.len(), rows.len() + 1);
    assert!(table.iter().all(|line| line.len() == table[0].len()));
    rows
}

/// Asserts that a row's command reproduces its errors exactly: they contain nothing random, and do not depend on other
/// rows.
fn assert_reproduced(sandbox: &Sandbox, row: &Value, errors: &[&str]) {
    let run = sandbox.run(&words(row["command"].as_str().unwrap())[1..]);
    let again = json_of(&run)["rows"][0].clone();
    for name in errors {
        assert!(row[name].is_number() && row[name] == again[name], "{name}: {} and {}", row[name], again[name]);
    }
}

#[test]
fn detail_chart_is_reproducible() {
    if gpu("detail_chart_is_reproducible").is_none() {
        return;
    }
    let sandbox = Sandbox::new().with_lab();
    let small = [
        "judge.width=208",
        "judge.height=106",
        "judge.samples=8",
        "hair.density=300",
        "slice.tile_texels=32",
        "shading.model=kajiya-kay",
    ];
    let sets: Vec<&str> = small.iter().flat_map(|set| ["--set", set]).collect();
    // Four rows each of the largest and the smallest size: the runtime's choice, full detail, the first step to fewer
    // layers, and a large tile. The last row is the smallest size with the unsimplified mesh.
    let rows = charted(&sandbox, "detail", "1,2,3,13,43,44,45,55,56", &sets);
    let number = |row: usize, name: &str| rows[row][name].as_f64().unwrap_or_else(|| panic!("{name}: {}", rows[row]));
    let labels = ["auto", "full", "0.25", "256²", "auto", "full", "0.25", "256²", "unsimplified"];
    for (i, row) in rows.iter().enumerate() {
        assert_eq!((row["label"].as_str(), row["default"] == true), (Some(labels[i]), labels[i] == "auto"), "{row}");
        let [width, height] = if i < 4 { [416.0, 212.0] } else { [52.0, 26.0] };
        assert_eq!(["width", "height", "samples"].map(|name| number(i, name)), [width, height, 8.0]);
        assert!(number(i, "frame_milliseconds") > 0.0 && (0.0..1.0).contains(&number(i, "flip")), "{row}");
        assert_eq!(number(i, "slice.tile_texels"), if labels[i] == "256²" { 256.0 } else { 32.0 });
    }
    // The height of the fur scales with the picture. All other values are the same in all rows of a size.
    assert!((number(0, "fur_px") / number(4, "fur_px") - 8.0).abs() < 0.3, "{} and {}", rows[0], rows[4]);
    assert_eq!([3, 8].map(|i| number(i, "fur_px")), [0, 4].map(|i| number(i, "fur_px")));
    // Full detail is the same at all sizes, while the runtime chooses less in smaller pictures.
    let drawn = |row: usize| ["layers", "triangles"].map(|name| number(row, name));
    assert!(drawn(1) == drawn(5) && drawn(3) == drawn(1) && drawn(1)[0] == 15.0, "{} and {}", rows[1], rows[5]);
    assert!(drawn(2)[0] < drawn(1)[0] && drawn(2)[1] == drawn(1)[1], "{}", rows[2]);
    let (auto, full) = (drawn(4), drawn(5));
    assert!(auto[0] < full[0] && auto[1] < full[1] && auto[0] <= drawn(0)[0], "{} and {}", rows[4], rows[5]);
    assert_eq!(drawn(8), [auto[0], full[1]], "without simplified lists all triangles are drawn");
    let fragments = |row: usize| rows[row]["fragments"].as_f64();
    if let (Some(auto), Some(full), Some(unsimplified)) = (fragments(4), fragments(5), fragments(8)) {
        assert!(auto < unsimplified && unsimplified < full, "{auto}, {unsimplified} and {full} fragments");
    }
    // Each size has its own Pareto front, which always contains the most accurate row of that size.
    for size in [0..4, 4..9] {
        let truest = size.min_by(|a, b| number(*a, "flip").total_cmp(&number(*b, "flip"))).unwrap();
        assert_eq!(rows[truest]["on_front"], true, "{}", rows[truest]);
    }
    let svg = std::fs::read_to_string(sandbox.path().join("out/detail.svg")).unwrap();
    for text in ["hare", "52x26", "at a quarter of the size", "auto: as much", "auto, all triangles", "ringed"] {
        assert!(svg.contains(text), "no {text:?} in the picture");
    }
    assert_reproduced(&sandbox, &rows[4], &["flip", "rmse", "coverage_error", "layers", "triangles", "fur_px"]);
}

/// Checks the chart of growth: pixels of layers, layers and copies. Amounts and fragments must grow as the
/// settings do; times only have to be there.
#[test]
fn cost_chart_is_reproducible() {
    if gpu("cost_chart_is_reproducible").is_none() {
        return;
    }
    let sandbox = Sandbox::new().with_lab();
    let small = ["judge.width=208", "judge.height=106", "hair.density=300", "shading.model=kajiya-kay"];
    let sets: Vec<&str> = small.iter().flat_map(|set| ["--set", set]).collect();
    let rows = charted(&sandbox, "cost", "2,3,9,12,21,22", &sets);
    let number = |row: usize, name: &str| rows[row][name].as_f64().unwrap_or_else(|| panic!("{name}: {}", rows[row]));
    assert_eq!([0, 1].map(|row| number(row, "width")), [104.0, 208.0]);
    let covered = number(1, "covered_pixels") / number(0, "covered_pixels");
    assert!((3.5..4.5).contains(&covered) && number(0, "amount") == number(0, "covered_pixels"), "{covered}");
    assert_eq!([2, 3].map(|row| number(row, "amount")), [2.0, 15.0], "layers");
    assert_eq!([4, 5].map(|row| number(row, "amount")), [1.0, 4.0], "copies");
    for (row, line) in rows.iter().enumerate() {
        assert!(number(row, "frame_milliseconds") > 0.0 && number(row, "over_first") > 0.0, "{line}");
        assert_eq!(line["exponent"].is_number(), ![2, 4].contains(&row), "the first of a series has none: {line}");
    }
    if let (Some(few), Some(many)) = (rows[2]["fragments"].as_f64(), rows[3]["fragments"].as_f64()) {
        assert!(many > 3.0 * few, "{few} and {many} fragments");
    }
    assert_reproduced(&sandbox, &rows[5], &["amount", "covered_pixels", "fragments"]);
}

#[test]
fn strands_chart_is_reproducible() {
    if gpu("strands_chart_is_reproducible").is_none() {
        return;
    }
    let sandbox = Sandbox::new().with_lab();
    // Eight samples of scattered light are noise.
    let noiseless = "shading.model=kajiya-kay";
    let small = ["judge.width=208", "judge.height=106", "judge.samples=8", "hair.density=300", noiseless];
    let sets: Vec<&str> = small.iter().flat_map(|set| ["--set", set]).collect();
    // Four rows at close range with four samples, then four at half the size with one sample. Each four are the
    // runtime's choice, layers, strands of 8 segments, and strands of 2 segments.
    let rows = charted(&sandbox, "strands", "10,11,13,15,55,56,58,60", &sets);
    let number = |row: usize, name: &str| rows[row][name].as_f64().unwrap_or_else(|| panic!("{name}: {}", rows[row]));
    for (i, row) in rows.iter().enumerate() {
        let (size, [width, height, samples]) =
            if i < 4 { ("close", [208.0, 106.0, 4.0]) } else { ("half", [104.0, 53.0, 1.0]) };
        assert_eq!((row["size"].as_str(), row["default"] == true), (Some(size), i == 4), "{row}");
        assert_eq!(["width", "height", "samples"].map(|name| number(i, name)), [width, height, samples]);
        let (frame, anew) = (number(i, "frame_milliseconds"), number(i, "anew_milliseconds"));
        assert!(frame > 0.0 && anew > 0.0 && (0.0..1.0).contains(&number(i, "flip")), "{row}");
        assert_eq!(row["over_cheapest"].as_f64().is_some_and(|ratio| ratio >= 1.0), i % 4 == 0, "{row}");
    }
    // The ratio of the strand widths shows that the distance of the second four rows is six times as large.
    let widths = number(0, "strand_px") / number(4, "strand_px");
    assert!((widths / 6.0 - 1.0).abs() < 0.05, "{widths}");
    // Strands are drawn if requested, with the given number of segments. Layers have none, and their package is
    // smaller.
    assert_eq!([1, 2, 3, 5, 6, 7].map(|i| number(i, "pieces")), [0.0, 8.0, 2.0, 0.0, 8.0, 2.0]);
    // At a distance, the far layer has replaced some of the strands.
    assert_eq!([1, 2, 3, 5].map(|i| number(i, "strands")), [0.0, 1.0, 1.0, 0.0]);
    assert!((0.1..=1.0).contains(&number(6, "strands")), "{}", rows[6]);
    assert!(number(1, "package_bytes") < number(2, "package_bytes"));
    assert_eq!(number(2, "strand_triangles"), 4.0 * number(3, "strand_triangles"));
    // At a distance, the runtime chooses layers.
    assert_eq!(number(4, "strands"), 0.0, "{}", rows[4]);
    assert!(number(2, "flip") < 0.95 * number(1, "flip"), "{} and {}", rows[1], rows[2]);
    let svg = std::fs::read_to_string(sandbox.path().join("out/strands.svg")).unwrap();
    for text in ["hare", "a third of the field of view", "an eighth of the size", "auto", "strands of 2 pieces"] {
        assert!(svg.contains(text), "no {text:?} in the picture");
    }
    assert_reproduced(&sandbox, &rows[4], &["flip", "rmse", "coverage_error", "strand_px", "layers"]);
}

#[test]
fn opacity_shadow_chart_is_reproducible() {
    if gpu("opacity_shadow_chart_is_reproducible").is_none() {
        return;
    }
    let sandbox = Sandbox::new().with_lab();
    // Eight samples of scattered light are noise.
    let noiseless = "shading.model=kajiya-kay";
    let small = ["judge.width=417", "judge.height=212", "judge.samples=8", "hair.density=500", noiseless];
    let sets: Vec<&str> = small.iter().flat_map(|set| ["--set", set]).collect();
    // Rows: the runtime's default. Maps of 512²: 4 and 16 slabs (depth ranges behind the first hair), 16 planes across
    // the whole body, and the published form. Last, light along the axis.
    let rows = charted(&sandbox, "opacity-shadow", "1,3,9,12,15,17", &sets);
    let number = |row: usize, name: &str| rows[row][name].as_f64().unwrap_or_else(|| panic!("{name}: {}", rows[row]));
    let forms: Vec<_> = rows.iter().map(|row| row["form"].as_str().unwrap_or_default()).collect();
    assert_eq!(forms, ["deep", "deep", "deep", "whole", "printed", "deep"]);
    assert_eq!([0, 1, 2, 3, 4, 5].map(|i| number(i, "slabs")), [4.0, 4.0, 16.0, 16.0, 16.0, 4.0]);
    // A texel stores the distance of the first hair (only with slabs), a value per slab or plane, and one for hair on
    // guides.
    assert_eq!([1, 2, 3].map(|i| number(i, "bytes")), [6.0, 18.0, 17.0].map(|n| 4.0 * 512.0 * 512.0 * n));
    for (i, row) in rows.iter().enumerate() {
        assert!(number(i, "milliseconds") > 0.0 && number(i, "places") > 500.0, "{row}");
        assert_eq!(row["default"] == true, i == 0);
    }
    // Planes across the whole body represent the light on the fur less accurately than slabs that begin at the first
    // hair. The error of the picture (FLIP) confirms this.
    for name in ["rmse", "flip", "largest_step", "largest_error"] {
        assert!(number(3, name) > 1.1 * number(2, name), "{name}: {} and {}", rows[3], rows[2]);
    }
    // In the published form, hair behind the last plane is lit again.
    assert!(number(4, "largest_step") > 0.99 && number(4, "largest_error") > 0.8, "{}", rows[4]);
    assert!(
        number(5, "mean_error") < number(0, "mean_error"),
        "light on the axis must be darker: {} and {}",
        rows[5],
        rows[0]
    );
    assert_reproduced(&sandbox, &rows[3], &["rmse", "mean_error", "flip", "largest_step", "places"]);
}

#[test]
fn self_shadow_chart_is_written() {
    if gpu("self_shadow_chart_is_written").is_none() {
        return;
    }
    let sandbox = Sandbox::new().with_lab();
    let small =
        ["hair.coat=natural", "slice.tile_texels=32", "slice.layers=8", "hair.density=100", "hair.root_radius=0.02"];
    let sets: Vec<&str> = small.iter().flat_map(|set| ["--set", set]).collect();
    // Rows: the default, uncompressed texels, maps of a quarter of the size, the runtime's maps, and the published
    // form.
    let rows = charted(&sandbox, "self-shadow", "1,2,11,13,18", &sets);
    let number = |row: usize, name: &str| rows[row][name].as_f64().unwrap_or_else(|| panic!("{name}: {}", rows[row]));
    let word = |row: usize, name: &str| rows[row][name].as_str().unwrap_or_default().to_owned();
    let forms = ["baked", "baked", "corrected", "corrected", "printed"];
    assert_eq!([0, 1, 2, 3, 4].map(|i| word(i, "form")), forms);
    assert_eq!([0, 1, 2].map(|i| word(i, "pack.shell_format")), ["bc7", "rgba8", ""]);
    assert_eq!([2, 3, 4].map(|i| number(i, "map_size")), [128.0, 512.0, 512.0]);
    assert_eq!([0, 1, 2, 3, 4].map(|i| rows[i]["default"] == true), [true, false, false, false, false]);
    for (i, row) in rows.iter().enumerate() {
        let baked = i < 2;
        assert_eq!(number(i, "milliseconds") == 0.0, baked, "{row}");
        assert!(if baked { row["map_layers"].is_null() } else { number(i, "map_layers") == 8.0 }, "{row}");
        assert_eq!(row["visibility_seconds"].is_null(), !baked, "{row}");
        assert!(number(i, "bytes") > 1000.0 && number(i, "hair_rmse") > 0.0, "{row}");
    }
    // Baked visibility is closer to the light on the hair than maps are; block compression loses little of it.
    for i in [2, 3, 4] {
        assert!(number(0, "hair_rmse") < 0.9 * number(i, "hair_rmse"), "{} {}", rows[0], rows[i]);
    }
    assert!((number(0, "hair_rmse") - number(1, "hair_rmse")).abs() < 0.01, "{} {}", rows[0], rows[1]);
    assert!((1e-3..0.05).contains(&number(0, "bc7_over_rgba8_rmse")) && rows[1]["bc7_over_rgba8_rmse"].is_null());
    assert_eq!(number(3, "bytes"), 2.0 * 512.0 * 512.0 * 8.0);
    // The default maps must stay within the bounds. Coarse maps and the published form exceed them; the error of the
    // published form grows as the light becomes more slanted.
    for (angle, bound) in [(0, 0.04), (30, 0.06), (45, 0.08), (60, 0.10), (75, 0.22)] {
        let name = format!("rmse_{angle}");
        assert!(number(3, &name) <= bound, "{angle} degrees: {}", number(3, &name));
    }
    assert!(number(2, "rmse") > 1.3 * number(3, "rmse"), "{} {}", rows[2], rows[3]);
    assert!(number(4, "rmse_75") > 0.2 && number(4, "rmse_75") > 2.5 * number(3, "rmse_75"), "{}", rows[4]);
    assert_reproduced(&sandbox, &rows[0], &["rmse", "hair_rmse", "bc7_over_rgba8_rmse", "bytes"]);
    assert_reproduced(&sandbox, &rows[2], &["rmse", "strands_rmse", "off_by_0.1", "rmse_75", "hair_rmse_0"]);
    let svg = std::fs::read_to_string(sandbox.path().join("out/self-shadow.svg")).unwrap();
    assert!(
        ["hare", "8 layers", "map size", "baked, texels", "RMSE of t", "milliseconds", "bytes"]
            .iter()
            .all(|text| svg.contains(text))
    );
}

#[test]
fn lighting_chart_is_reproducible() {
    if gpu("lighting_chart_is_reproducible").is_none() {
        return;
    }
    let sandbox = Sandbox::new().with_lab();
    let small = ["slice.tile_texels=32", "slice.layers=6", "hair.density=200", "pack.direction_format=rg8"];
    let sets: Vec<&str> = small.iter().flat_map(|set| ["--set", set]).collect();
    // Rows: the recipe's own settings, the same settings evaluated at vertices, and a tile of 16 texels.
    let rows = charted(&sandbox, "lighting", "1,5,7", &sets);
    let number = |row: usize, name: &str| rows[row][name].as_f64().unwrap_or_else(|| panic!("{name}: {}", rows[row]));
    assert_eq!([0, 1, 2].map(|i| rows[i]["lighting"].as_str().unwrap()), ["pixel", "vertex", "pixel"]);
    assert_eq!([0, 1, 2].map(|i| rows[i]["pack.direction_format"].as_str().unwrap()), ["rg8"; 3]);
    assert_eq!([0, 1, 2].map(|i| number(i, "slice.tile_texels")), [32.0, 32.0, 16.0]);
    assert_eq!([0, 1, 2].map(|i| rows[i]["default"] == true), [true, false, false]);
    for (i, row) in rows.iter().enumerate() {
        assert!(number(i, "shells_milliseconds") > 0.0 && number(i, "direction_bytes") > 1000.0, "{row}");
    }
    // The values express Fig. 1 of the paper in numbers.
    for error in ["rmse", "direction_error_deg"] {
        assert!(number(1, error) > 1.2 * number(0, error), "{error}: {} and {}", rows[1], rows[0]);
        assert!(number(2, error) > number(0, error), "{error}: {} and {}", rows[2], rows[0]);
    }
    assert_reproduced(&sandbox, &rows[1], &["rmse", "mean_error", "direction_error_deg", "direction_bytes"]);
}

#[test]
fn soft_shadow_chart_is_reproducible() {
    if gpu("soft_shadow_chart_is_reproducible").is_none() {
        return;
    }
    let sandbox = Sandbox::new().with_lab();
    let rows = charted(&sandbox, "soft-shadow", "1,2,16", &["--set", "slice.layers=4"]);
    let number = |row: usize, name: &str| rows[row][name].as_f64().unwrap_or_else(|| panic!("{name}: {}", rows[row]));
    assert_eq!([0, 1, 2].map(|i| rows[i]["method"].as_str().unwrap()), ["centred", "centred", "printed"]);
    for (i, row) in rows.iter().enumerate() {
        assert!(number(i, "milliseconds") > 0.0 && number(i, "penumbra_ratio") > 0.0, "{row}");
        assert!(number(i, "rmse_in_shadow") > number(i, "rmse"), "most of the hare is lit: {row}");
    }
    // The default must satisfy these bounds.
    assert!(number(0, "rmse") <= 0.08 && number(0, "leak_in_umbra") <= 0.02, "{}", rows[0]);
    assert!(number(1, "rmse") > 1.2 * number(0, "rmse"), "coarse maps: {} and {}", rows[1], rows[0]);
    assert!(number(2, "rmse") > 2.0 * number(0, "rmse"), "published form: {} and {}", rows[2], rows[0]);
    assert_reproduced(&sandbox, &rows[0], &["rmse", "rmse_in_shadow", "leak_in_umbra", "penumbra_ratio"]);
}

#[test]
fn verlet_chart_is_written() {
    let sandbox = Sandbox::new().with_lab();
    // Rows for guides of 7 points: the runtime's default, more steps, a single sweep, the published form, and the mesh
    // surface sampled once per frame.
    let rows = charted(&sandbox, "verlet", "1,3,9,24,27", &[]);
    let number = |row: usize, name: &str| rows[row][name].as_f64().unwrap_or_else(|| panic!("{name}: {}", rows[row]));
    let steps = [120.0, 240.0, 120.0, 60.0];
    for (i, row) in rows.iter().enumerate() {
        assert_eq!((number(i, "points"), row["default"] == true), (7.0, i == 0), "{row}");
        assert_eq!(row["steps_per_s"].as_f64(), steps.get(i).copied(), "{row}");
        assert_eq!(row["nanoseconds"].as_f64().is_some_and(|ns| ns > 0.0), i < 4, "{row}");
        assert!(number(i, "true_change_percent") < 1e-3, "{row}");
    }
    // More steps are more accurate. The error grows with too few steps, or with a single sweep, which leaves out the
    // tensions. With a single sweep, the guides also stretch.
    let off = |row: usize| number(row, "rms_percent");
    assert!(off(4) < 0.1 && off(1) < 0.6 * off(0) && off(0) < 2.0, "{} {} {}", rows[0], rows[1], rows[4]);
    assert!(off(2) > 1.5 * off(0) && off(3) > 4.0 * off(0), "{} {}", rows[2], rows[3]);
    assert!(number(0, "stretch_percent") < 0.01 && number(2, "stretch_percent") > 5.0, "{} {}", rows[0], rows[2]);
    assert_reproduced(&sandbox, &rows[0], &["rms_percent", "largest_percent", "rms_turn", "rms_gallop", "rms_gust"]);
    let svg = std::fs::read_to_string(sandbox.path().join("out/verlet.svg")).unwrap();
    for text in ["gallop", "7 points: ns", "RMS distance from the truth", "ours, steps/s", "one thread"] {
        assert!(svg.contains(text), "no {text:?} in the picture");
    }
}

/// Checks the environment chart. Its rows for the painted sky are the default with a broad light, coarser tables, few
/// samples, and constant light. Its rows for single lights are the integral and the published form.
#[test]
fn environment_chart_is_written() {
    let sandbox = Sandbox::new().with_lab();
    let rows = charted(&sandbox, "environment", "3,5,16,19,45,47", &[]);
    let error = |i: usize| rows[i]["error_percent"].as_f64().unwrap();
    assert!(rows[0]["default"] == true && rows[0]["sky"] == "clear sky", "{}", rows[0]);
    // Coarse tables, few samples and constant light must have larger errors than the default, and the published form a
    // larger error than the integral.
    assert!(error(0) < error(1) && error(0) < error(2) && 2.0 * error(0) < error(3), "{rows:?}");
    assert!(rows[4]["sky"] == "one light of 20 degrees" && error(4) < 1.0 && error(5) > 2.0 * error(4), "{rows:?}");
    assert!(rows[0]["mean_percent"].as_f64().unwrap().abs() < 15.0, "{}", rows[0]);
}

/// Checks the chart of lights fitted to skies: more lights give a smaller error.
#[test]
fn environment_fit_chart_is_written() {
    let Some(data) = data("environment_fit_chart_is_written") else { return };
    let sandbox = Sandbox::new().with_lab();
    std::fs::copy(data.join("hdr/venice_sunset_256x128.hdr"), sandbox.path().join("my sky.hdr")).unwrap();
    let rows = charted(&sandbox, "environment-fit", "1,3,7", &["--sky", "my sky.hdr"]);
    let of = |i: usize, column: &str| rows[i][column].as_f64().unwrap();
    for column in ["error_percent", "irradiance_percent"] {
        assert!(of(0, column) > of(1, column) && of(1, column) > of(2, column), "{column}: {rows:?}");
    }
    assert!(
        of(2, "irradiance_percent") < 5.0 && of(2, "energy_percent") < 0.01 && rows[2]["default"] == true,
        "{rows:?}"
    );
    assert!(rows[2]["command"].as_str().unwrap().contains("--sky 'my sky.hdr' --rows 7"), "{}", rows[2]);
    sandbox.write("lights.toml", b"even = [1.0, 1.0, 1.0]\n");
    for (arguments, code, expected) in [
        (
            &["chart", "environment-fit", "--sky", "lights.toml", "-o", "out"][..],
            3,
            "holds fitted lights, expected a panorama",
        ),
        (&["chart", "environment-fit", "--sky", "none.hdr", "-o", "out"], 2, "none.hdr"),
        (&["chart", "verlet", "--sky", "my sky.hdr", "-o", "out"], 1, "chart verlet takes no --sky"),
    ] {
        let run = sandbox.run(arguments);
        assert!(run.code == Some(code) && run.stderr.contains(expected), "{arguments:?}: {}", run.stderr);
    }
}

#[test]
fn stability_table_is_written() {
    if gpu("stability_table_is_written").is_none() {
        return;
    }
    let sandbox = Sandbox::new().with_lab();
    let object = json_of(&sandbox.run(&["chart", "stability", "--json", "-o", "out", "--rows", "1,9,25"]));
    let rows = object["rows"].as_array().unwrap();
    // Checks two rows computed on the CPU and one drawn on the GPU. Each also has its own test.
    for method in ["surface", "Kajiya-Kay", "light of strands"] {
        assert!(rows.iter().any(|row| row["series"] == method), "no row {method}");
    }
    for row in rows {
        assert_eq!(row["holds"], true, "{row}");
        let (safe, bound) = (row["safe"].as_f64().unwrap(), row["bound"].as_f64().unwrap());
        assert!(safe <= bound && row["naive"].as_f64().is_none_or(|naive| naive > bound), "{row}");
    }
    let table = csv(&std::fs::read_to_string(sandbox.path().join("out/stability.csv")).unwrap());
    assert_eq!(table.len(), rows.len() + 1);
    assert_eq!(sandbox.files(), ["out/", "out/stability.csv"]);
}

#[test]
fn invalid_chart_requests_are_refused() {
    let sandbox = Sandbox::new().with_lab();
    torus(&sandbox);
    sandbox.write("a.pelage", b"PELAGE\0\0");
    let before = sandbox.files();
    for (args, code, words) in [
        (&["chart"][..], 1, &["TOPIC"][..]),
        (&["chart", "weather", "-o", "out"], 1, &["weather", "surface", "stability"]),
        (&["chart", "surface"], 1, &["-o DIR"]),
        (&["chart", "stability", "my torus.obj"], 1, &["neither model nor recipe"]),
        (&["chart", "stability", "--rows", "100"], 1, &["the table has 25 rows"]),
        (&["chart", "stability", "--restart"], 1, &["neither model nor recipe"]),
        (&["chart", "verlet", "my torus.obj", "-o", "out"], 1, &["neither model nor recipe"]),
        (&["chart", "verlet", "--set", "hair.density=3", "-o", "out"], 1, &["neither model nor recipe"]),
        (&["chart", "self-shadow"], 1, &["chart self-shadow needs -o DIR"]),
        (&["chart", "soft-shadow", "-o", "out", "--rows", "1,99"], 1, &["--rows 99", "rows"]),
        (&["chart", "surface", "-o", "out", "--rows", "0"], 1, &["--rows"]),
        (&["chart", "surface", "no.glb", "-o", "out"], 2, &["no.glb: cannot read"]),
        (&["chart", "surface", "a.pelage", "-o", "out"], 3, &["a.pelage", "a pelage package"]),
        (&["chart", "surface", "my torus.obj", "-o", "a.pelage"], 2, &["a.pelage: cannot create"]),
        (&["chart", "surface", "-o", "out", "--recipe", "r.toml"], 1, &["--recipe needs a MODEL"]),
        (&["chart", "surface", "-o", "out", "--set", "surface.patch_sise=2"], 3, &["surface.patch_size"]),
    ] {
        let run = sandbox.run(args);
        assert_eq!(run.code, Some(code), "{args:?}: {run:?}");
        assert!(words.iter().all(|w| run.stderr.contains(w)), "{args:?}: {}", run.stderr);
        assert_eq!(sandbox.files(), before, "{args:?} left something behind");
    }
}
