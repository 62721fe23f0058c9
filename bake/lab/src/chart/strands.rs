//! Topic `strands`: single strands compared with layers, at sizes from a close-up to a few pixels, beside the reference
//! picture.
//!
//! Each size is drawn with one sample per pixel and with four: by the runtime's choice, as layers, and as strands of
//! several numbers of pieces. Methods of the same size and number of samples are timed in turns, so that other load on
//! the machine affects all of them.

use super::{Cell, Panel};
use pelage_stage::{LookDetail, LookHair, LookStrandEdges, Viewpoint};
use pelage_tool::shell_judge::SettingMeasurements;

/// Picture to draw: size relative to the recipe's `[judge]` size, and zoom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// Name of the size in the table.
    pub word: &'static str,
    /// Factor and divisor applied to the recipe's width and height.
    ratio: (u32, u32),
    /// Divisor of the field of view.
    nearer: f32,
}

impl Size {
    /// All sizes: first the close-up, then from large to small, each half of the previous one.
    pub const ALL: [Self; 6] = [
        Self { word: "close", ratio: (1, 1), nearer: 3.0 },
        Self { word: "double", ratio: (2, 1), nearer: 1.0 },
        Self { word: "whole", ratio: (1, 1), nearer: 1.0 },
        Self { word: "half", ratio: (1, 2), nearer: 1.0 },
        Self { word: "quarter", ratio: (1, 4), nearer: 1.0 },
        Self { word: "eighth", ratio: (1, 8), nearer: 1.0 },
    ];

    /// Returns width and height of the picture in pixels, at least 1. The argument is the recipe's width and height.
    pub fn pixels(self, (width, height): (u32, u32)) -> (u32, u32) {
        let (times, over) = self.ratio;
        let of = |pixels: u32| (pixels * times / over).max(1);
        (of(width), of(height))
    }

    /// Returns the camera of the picture; `camera` shows the whole model.
    pub fn camera(self, camera: Viewpoint) -> Viewpoint {
        Viewpoint { fov_deg: camera.fov_deg / self.nearer, ..camera }
    }
}

/// Samples per pixel.
pub const SAMPLES: [u32; 2] = [1, 4];

/// Method of drawing hair.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawMethod {
    /// Name of the varied setting.
    pub series: String,
    /// Strands, layers, or the runtime's choice.
    pub hair: LookHair,
    /// Antialiasing of strand edges.
    pub edges: LookStrandEdges,
    /// Level of detail of the layers.
    pub detail: LookDetail,
    /// Maximum number of pieces per strand; `None` for the runtime's choice.
    pub pieces: Option<u32>,
}

impl DrawMethod {
    /// Returns all methods for strands of `pieces` pieces:
    ///
    /// * the runtime's choice
    /// * if `coat` is true, layers: as many as the size needs, and all
    /// * strands of all pieces, strands of half as many pieces, and so on
    /// * with blended edges: the runtime's choice, strands of all pieces, and strands of half as many pieces
    pub fn all(pieces: u32, coat: bool) -> Vec<Self> {
        let way = |series: &str, hair, detail| Self {
            series: series.to_owned(),
            hair,
            edges: LookStrandEdges::Samples,
            detail,
            pieces: None,
        };
        let mut all = vec![way("auto", LookHair::Auto, LookDetail::Auto)];
        if coat {
            all.push(way("layers, as the size asks for", LookHair::Shells, LookDetail::Auto));
            all.push(way("layers, all", LookHair::Shells, LookDetail::Full));
        }
        let strands = |pieces: u32| Self {
            pieces: Some(pieces),
            ..way(&format!("strands of {pieces} pieces"), LookHair::Strands, LookDetail::Auto)
        };
        let halved = std::iter::successors(Some(pieces), |p| p.is_multiple_of(2).then_some(p / 2));
        all.extend(halved.take_while(|p| *p > 1).take(if coat { 3 } else { 4 }).map(strands));
        let in_strands =
            all.iter().filter(|way| way.hair != LookHair::Shells && way.pieces.is_none_or(|p| 2 * p >= pieces));
        let blended = |way: &Self| Self {
            series: format!("{}, blended", way.series),
            edges: LookStrandEdges::Blended,
            ..way.clone()
        };
        let blended: Vec<_> = in_strands.map(blended).collect();
        [all, blended].concat()
    }

    /// Returns whether the method also applies to a package without strands.
    pub fn needs_no_strands(&self) -> bool {
        self.hair == LookHair::Shells
    }
}

/// Row of the chart: a size, a number of samples and a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrandsConfiguration {
    /// Index into [`Size::ALL`].
    pub size: usize,
    /// Samples per pixel.
    pub samples: u32,
    /// Index into the list of methods.
    pub way: usize,
}

impl StrandsConfiguration {
    /// Returns whether this is the default: the runtime's choice with the first of [`SAMPLES`].
    pub fn is_default(&self) -> bool {
        self.way == 0 && self.samples == SAMPLES[0]
    }
}

/// Lists every combination of size, number of samples and one of `ways` methods.
pub fn configurations(ways: usize) -> Vec<StrandsConfiguration> {
    let groups = (0..Size::ALL.len()).flat_map(|size| SAMPLES.map(|samples| (size, samples)));
    groups.flat_map(|(size, samples)| (0..ways).map(move |way| StrandsConfiguration { size, samples, way })).collect()
}

/// Columns of the chart.
///
/// * `size`: name of the size; `whole` is as in the recipe's `[judge]`, `close` has a third of its angle. `width`,
///   `height`: pixels.
/// * `samples`: per pixel; `true_samples`: rays per pixel of the reference image; `strand_px`: mean width of the
///   strands at the median distance of the mesh surface, pixels.
/// * `layers`: number of drawn layers; `strands`: fraction of the strands that is drawn; `pieces`: per strand.
///   `strand_triangles`: triangles of all drawn strands, visible or not; `triangles`: of the mesh.
/// * `flip`, `flip_covered`, `rmse`, `coverage_error`: errors against the reference image; `fragments`: if the
///   adapter counts them.
/// * `flicker`: mean change of grey, 0..=1, at points of the mesh surface and the hair on them, while only the camera
///   turns by a quarter of a degree. `true_flicker`: that of the reference images, whose hair also moves relative to
///   the surface.
/// * `frame_milliseconds`: a frame with unchanged light and pose. `anew_milliseconds`: the passes of a frame with a new
///   pose and new maps.
/// * `over_cheapest`: for the runtime's choice without blended edges, its frame time divided by that of the cheapest
///   equally accurate method of the same size and samples. Equally accurate means a FLIP at most [`AS_TRUE`] times as
///   large.
/// * `package_bytes`: size of a package with strands, or without if none are drawn; `gpu_bytes`: size of model, copy,
///   maps and lists on the GPU.
pub const COLUMNS: [&str; 24] = [
    "size",
    "width",
    "height",
    "samples",
    "true_samples",
    "strand_px",
    "layers",
    "strands",
    "pieces",
    "strand_triangles",
    "triangles",
    "flip",
    "flip_covered",
    "rmse",
    "coverage_error",
    "flicker",
    "true_flicker",
    "fragments",
    "frame_milliseconds",
    "anew_milliseconds",
    "over_cheapest",
    "package_bytes",
    "gpu_bytes",
    "timing",
];

/// Panels of the chart, one for each size.
pub fn panels() -> Vec<Panel> {
    let labels = [
        "mean FLIP, a third of the field of view",
        "mean FLIP at twice the size in [judge]",
        "mean FLIP at the size in [judge]",
        "mean FLIP at half the size in [judge]",
        "mean FLIP at a quarter of the size in [judge]",
        "mean FLIP at an eighth of the size in [judge]",
    ];
    let panel = |(size, error_label): (Size, _)| Panel {
        cost: "frame_milliseconds",
        cost_label: "frame, milliseconds",
        error: "flip",
        error_label,
        only: Some(("size", size.word)),
    };
    Size::ALL.into_iter().zip(labels).map(panel).collect()
}

/// Results of a method.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StrandsMeasures {
    /// Errors and costs.
    pub measured: SettingMeasurements,
    /// Milliseconds of the passes of a frame with a new pose and new maps.
    pub anew_ms: f64,
    /// Mean change of grey, 0..=1, while the camera turns by a quarter of a degree. `None` if no mesh surface is
    /// visible.
    pub flicker: Option<f64>,
    /// Fraction of the strands that is drawn, 0..=1.
    pub strands: f32,
    /// Pieces per strand.
    pub pieces: u32,
    /// Whether edges are blended, which is never the default.
    pub blended: bool,
}

/// Values shared by all methods of a size.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StrandsSizeFacts {
    /// Width and height of the picture, pixels.
    pub pixels: (u32, u32),
    /// Rays per pixel of the reference image.
    pub true_samples: u32,
    /// Mean change of grey in the reference image, 0..=1, while the camera turns by a quarter of a degree. `None` if
    /// no mesh surface is visible.
    pub true_flicker: Option<f64>,
    /// Mean width of the strands, pixels.
    pub strand_px: f64,
    /// Number of strands of the model.
    pub strands: usize,
}

/// Largest ratio of FLIP at which two methods count as equally accurate. Smaller differences are within the noise of
/// the reference image.
pub const AS_TRUE: f64 = 1.02;

/// Returns the cost of the first method divided by that of the cheapest equally accurate one. Methods with blended
/// edges are ignored.
pub fn over_cheapest(ways: &[StrandsMeasures]) -> Option<f64> {
    let own = ways.first()?.measured;
    let as_true = ways.iter().filter(|way| !way.blended && way.measured.flip <= AS_TRUE * own.flip);
    let cheapest = as_true.map(|way| way.measured.frame_ms).fold(f64::INFINITY, f64::min);
    Some(own.frame_ms / cheapest).filter(|ratio| ratio.is_finite())
}

/// Returns the cells of a row, in the order of [`COLUMNS`]. `ways` are the results of all methods of the row's size and
/// samples; `timing` is the source of the milliseconds.
pub fn cells(
    configuration: &StrandsConfiguration,
    seen: &StrandsSizeFacts,
    ways: &[StrandsMeasures],
    timing: &str,
) -> Vec<Cell> {
    let number = |x: Option<f64>| x.map_or(Cell::Empty, Cell::Number);
    let StrandsConfiguration { size, samples, way } = *configuration;
    let found = ways.get(way).copied().unwrap_or_default();
    let m = &found.measured;
    let drawn = f64::from(found.strands) * seen.strands as f64;
    vec![
        Cell::Text(Size::ALL[size].word.into()),
        Cell::Number(seen.pixels.0.into()),
        Cell::Number(seen.pixels.1.into()),
        Cell::Number(samples.into()),
        Cell::Number(seen.true_samples.into()),
        Cell::Number(seen.strand_px),
        Cell::Number(m.layers.into()),
        Cell::Number(found.strands.into()),
        Cell::Number(found.pieces.into()),
        Cell::Number((2.0 * drawn * f64::from(found.pieces)).round()),
        Cell::Number(m.triangles.into()),
        Cell::Number(m.flip),
        Cell::Number(m.flip_covered),
        Cell::Number(m.rmse),
        Cell::Number(m.coverage_error),
        number(found.flicker),
        number(seen.true_flicker),
        number(m.fragments.map(|n| n as f64)),
        Cell::Number(m.frame_ms),
        Cell::Number(found.anew_ms),
        number(over_cheapest(ways).filter(|_| way == 0)),
        Cell::Number(m.package_bytes as f64),
        Cell::Number(m.gpu_bytes as f64),
        Cell::Text(timing.into()),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_is_drawn_at_every_size() {
        let series = |pieces, coat| DrawMethod::all(pieces, coat).into_iter().map(|way| way.series).collect::<Vec<_>>();
        let strands = ["strands of 8 pieces", "strands of 4 pieces", "strands of 2 pieces"];
        let layers = ["auto", "layers, as the size asks for", "layers, all"];
        let blended = ["auto, blended", "strands of 8 pieces, blended", "strands of 4 pieces, blended"];
        assert_eq!(series(8, true), [layers, strands, blended].concat());
        let blended = ["auto, blended", "strands of 16 pieces, blended", "strands of 8 pieces, blended"];
        assert_eq!(series(16, false), [&["auto", "strands of 16 pieces"][..], &strands, &blended].concat());
        let all = ["auto", "strands of 6 pieces", "strands of 3 pieces"];
        assert_eq!(series(6, false), [all, all.map(|series| [series, ", blended"].concat().leak() as &str)].concat());
        let all = configurations(6);
        assert_eq!(all.len(), 6 * 2 * 6);
        for size in 0..Size::ALL.len() {
            let of: Vec<_> = all.iter().filter(|c| c.size == size).collect();
            assert_eq!(of.iter().filter(|c| c.is_default()).count(), 1);
            assert!((0..of.len()).all(|i| !of[i + 1..].contains(&of[i])));
        }
        let pixels = Size::ALL.map(|size| size.pixels((834, 424)));
        assert_eq!(pixels, [(834, 424), (1668, 848), (834, 424), (417, 212), (208, 106), (104, 53)]);
        assert_eq!(panels().len(), Size::ALL.len());
        let near = Size::ALL[0].camera(Viewpoint { eye: glam::Vec3::X, target: glam::Vec3::ZERO, fov_deg: 30.0 });
        assert_eq!((near.eye, near.fov_deg), (glam::Vec3::X, 10.0));
    }

    #[test]
    fn chosen_row_is_compared_with_the_cheapest_equally_accurate_row() {
        let way = |frame_ms, flip| StrandsMeasures {
            measured: SettingMeasurements { frame_ms, flip, ..SettingMeasurements::default() },
            ..StrandsMeasures::default()
        };
        // Compared with the first method, the cheapest one is less accurate, and the next one is nearly as accurate.
        // The last one is more accurate and more expensive.
        let blended = StrandsMeasures { blended: true, ..way(2.0, 0.0050) };
        let ways = [way(6.0, 0.0100), way(1.0, 0.0200), way(4.0, 0.0101), way(9.0, 0.0050), blended];
        assert_eq!(over_cheapest(&ways), Some(1.5));
        assert_eq!(over_cheapest(&ways[..2]), Some(1.0));
        assert_eq!(over_cheapest(&[]), None);
        let seen = StrandsSizeFacts { pixels: (8, 4), strands: 100, ..StrandsSizeFacts::default() };
        for way in 0..ways.len() {
            let cells = cells(&StrandsConfiguration { size: 2, samples: 4, way }, &seen, &ways, "timestamp-query");
            assert_eq!(cells.len(), COLUMNS.len());
            let cell = |name| &cells[COLUMNS.iter().position(|column| *column == name).expect("a column")];
            assert_eq!((cell("size"), cell("samples")), (&Cell::Text("whole".into()), &Cell::Number(4.0)));
            assert_eq!(cell("over_cheapest").number(), (way == 0).then_some(1.5));
            assert_eq!(cell("flip").number(), Some(ways[way].measured.flip));
        }
        let four = [StrandsMeasures { strands: 0.5, pieces: 4, ..way(1.0, 1.0) }];
        let cells = cells(&StrandsConfiguration { size: 0, samples: 1, way: 0 }, &seen, &four, "");
        let triangles = COLUMNS.iter().position(|column| *column == "strand_triangles").expect("a column");
        assert_eq!(cells[triangles], Cell::Number(400.0));
    }
}
