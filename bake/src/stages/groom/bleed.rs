//! Colours of clear texels.

use pelage_import::mesh::Image;

/// Texels in rows, RGBA.
type Texels = Vec<[u8; 4]>;

/// Gives texels of alpha 0 the colours of the visible texels around them, smoothly across large gaps. Files store any
/// colour there, often black or white, which filters would mix into the visible colours.
///
/// An image without visible texels keeps its colours.
pub(super) fn bleed(image: &mut Image) {
    let texels = image.rgba.as_chunks_mut::<4>().0;
    if !texels.iter().any(|texel| texel[3] == 0) {
        return;
    }
    let mut levels: Vec<(usize, Texels)> = Vec::new();
    let (mut width, mut height) = (image.width as usize, image.height as usize);
    while width.max(height) > 1 {
        let finer = levels.last().map_or(&*texels, |(_, level)| level);
        let coarse = halved(finer, width);
        (width, height) = (width.div_ceil(2), height.div_ceil(2));
        levels.push((width, coarse));
    }
    let Some((mut width, mut coarse)) = levels.pop().filter(|(_, top)| top[0][3] > 0) else { return };
    while let Some((finer_width, mut finer)) = levels.pop() {
        fill(&mut finer, finer_width, &coarse, width);
        (width, coarse) = (finer_width, finer);
    }
    fill(texels, image.width as usize, &coarse, width);
}

/// Returns the image at half size, rounded up. Colours are means weighted by alpha. Alpha is the sum of the four
/// weights, so that a texel counts fully as soon as it covers one visible texel.
fn halved(texels: &[[u8; 4]], width: usize) -> Texels {
    let rows = texels.chunks(2 * width).flat_map(|pair| {
        let rows = pair.chunks(width);
        (0..width).step_by(2).map(move |x| {
            let mut sums = [0u32; 4];
            for texel in rows.clone().flat_map(|row| row.iter().skip(x).take(2)) {
                let alpha = u32::from(texel[3]);
                (0..3).for_each(|i| sums[i] += alpha * u32::from(texel[i]));
                sums[3] += alpha;
            }
            let [r, g, b, weight] = sums;
            let mean = |sum: u32| ((sum + weight / 2) / weight.max(1)) as u8;
            [mean(r), mean(g), mean(b), weight.min(255) as u8]
        })
    });
    rows.collect()
}

/// Interpolates the colours of clear texels bilinearly from the next coarser level.
fn fill(texels: &mut [[u8; 4]], width: usize, coarse: &[[u8; 4]], coarse_width: usize) {
    let last = [coarse_width - 1, coarse.len() / coarse_width - 1];
    // The nearest coarse texel, and the second nearest along the axis.
    let pair = |i: usize, last: usize| {
        [i / 2, if i.is_multiple_of(2) { (i / 2).saturating_sub(1) } else { (i / 2 + 1).min(last) }]
    };
    for (y, row) in texels.chunks_mut(width).enumerate() {
        for (x, texel) in row.iter_mut().enumerate().filter(|(_, texel)| texel[3] == 0) {
            let ([x, x2], [y, y2]) = (pair(x, last[0]), pair(y, last[1]));
            let at = [(x, y, 9), (x2, y, 3), (x, y2, 3), (x2, y2, 1)];
            for i in 0..3 {
                let sum: u32 = at.iter().map(|(x, y, share)| share * u32::from(coarse[y * coarse_width + x][i])).sum();
                texel[i] = ((sum + 8) / 16) as u8;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ORANGE: [u8; 4] = [230, 140, 60, 255];

    #[test]
    fn clear_texels_take_the_colour_of_visible_ones() {
        for (width, height) in [(1u32, 9u32), (7, 5), (16, 16), (33, 2)] {
            for clear in [[0, 0, 0, 0], [255, 255, 255, 0]] {
                let mut rgba = vec![clear; (width * height) as usize];
                rgba[(width * height / 2) as usize] = ORANGE;
                let mut image = Image { width, height, rgba: rgba.concat() };
                bleed(&mut image);
                assert!(image.rgba.chunks(4).all(|t| t[..3] == ORANGE[..3]), "{width} x {height}: {:?}", image.rgba);
                let alphas: u32 = image.rgba.chunks(4).map(|t| u32::from(t[3])).sum();
                assert_eq!(alphas, 255, "alpha is kept");
            }
        }
    }

    #[test]
    fn images_without_clear_or_without_visible_texels_keep_their_colours() {
        for alpha in [0, 1, 255] {
            let rgba: Vec<u8> = (0..12u8).flat_map(|i| [i, 90, 200, alpha]).collect();
            let mut image = Image { width: 4, height: 3, rgba: rgba.clone() };
            bleed(&mut image);
            assert_eq!(image.rgba, rgba);
        }
    }

    #[test]
    fn gaps_are_filled_from_their_own_side() {
        let row = [[255, 0, 0, 255], [0; 4], [0; 4], [0; 4], [0; 4], [0, 0, 255, 255]];
        let mut image = Image { width: 6, height: 1, rgba: row.concat() };
        bleed(&mut image);
        let reds: Vec<u8> = image.rgba.chunks(4).map(|t| t[0]).collect();
        assert!(reds.is_sorted_by(|a, b| a >= b) && reds[1] > 150 && reds[4] < 100, "{reds:?}");
    }
}
