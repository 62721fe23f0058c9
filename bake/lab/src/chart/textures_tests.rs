#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use super::*;
use crate::stability::grow;

fn measured() -> Vec<(TexturesConfiguration, Vec<Cell>)> {
    let mut base = Recipe::default();
    ["hair.density=200", "slice.layers=8", "slice.tile_texels=32"].iter().for_each(|set| base.set(set).unwrap());
    let truth = SlicedTile::new(&base, grow(&base.hair, 0.3).unwrap()).unwrap();
    let all = configurations(&base).unwrap();
    // Each call of this clock returns a second more than the previous one.
    let clock = std::cell::Cell::new(0.0);
    let now = || clock.replace(clock.get() + 1.0);
    all.into_iter().map(|c| (c.clone(), measure(&c, &truth, &now).unwrap())).collect()
}

/// Checks that errors are physically plausible and that formats rank as expected. A decoder that read its own input
/// instead of the file would fail the first check.
#[test]
fn format_errors_are_within_their_expected_ranges() {
    let rows = measured();
    let cell = |row: &[Cell], name: &str| row[COLUMNS.iter().position(|c| *c == name).unwrap()].number();
    let find = |series: &str, label: &str| {
        let found = rows.iter().find(|(c, _)| c.series == series && c.label == label);
        found.unwrap_or_else(|| panic!("no {series} {label}")).1.as_slice()
    };
    assert!(rows.iter().all(|(_, cells)| cells.len() == COLUMNS.len()));
    // Uncompressed texels lose nothing. Blocks have a loss, which falls with effort, and need a quarter of the bytes.
    let plain = find("colour and opacity", "rgba8");
    assert_eq!((cell(plain, "color_rmse"), cell(plain, "color_psnr_db")), (Some(0.0), None));
    let [fast, slow] = ["bc7, fast", "bc7, slow"].map(|label| find("colour and opacity", label));
    let rmse = |row| cell(row, "color_rmse").unwrap();
    assert!(rmse(slow) > 0.0 && rmse(slow) <= rmse(fast) && rmse(fast) < 20.0, "{} {}", rmse(slow), rmse(fast));
    let bytes = |row| cell(row, "shell_bytes").unwrap();
    assert!((3.0..=4.0).contains(&(bytes(plain) / bytes(fast))), "{} {}", bytes(plain), bytes(fast));
    assert_eq!(cell(fast, "shell_encode_seconds"), Some(1.0));
    // Averaging each layer separately makes coverage drift with the mip level; the filter of the bake does not.
    let drift = |row| cell(row, "coverage_drift").unwrap();
    assert!(drift(plain) < 0.02 && drift(fast) < 0.03, "{} {}", drift(plain), drift(fast));
    assert!(drift(find("mips of each layer by itself", "rgba8")) > 2.0 * drift(plain));
    assert_eq!(cell(plain, "coverage_drift_level_0"), Some(0.0));
    // Directions with three components are the truth. Two components have some loss, and blocks of two components have
    // more.
    let degrees = |label| cell(find("hair direction", label), "direction_error_deg").unwrap();
    assert!(degrees("rgba8") == 0.0 && degrees("rg8") > degrees("rgba8"), "{} {}", degrees("rgba8"), degrees("rg8"));
    assert!(degrees("bc5") > degrees("rg8") && degrees("bc5") < 10.0, "{}", degrees("bc5"));
    // If only one texture is varied, the other is not measured.
    assert_eq!(cell(plain, "direction_error_deg"), None);
    assert_eq!(cell(find("hair direction", "rg8"), "color_rmse"), None);
}
