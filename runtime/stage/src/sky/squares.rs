//! Non-negative least squares with few unknowns.

/// Maximum number of sweeps over all unknowns.
const SWEEPS: usize = 400;

/// Minimises xᵀGx − 2 bᵀx by coordinate descent, with all x at least 0.
///
/// * `products`: G, symmetric with a positive diagonal, row by row
/// * `x`: initial value and result
pub(super) fn least_squares(products: &[f64], b: &[f64], x: &mut [f64]) {
    let count = b.len();
    for _ in 0..SWEEPS {
        let mut moved = 0.0_f64;
        for i in 0..count {
            let row = &products[i * count..(i + 1) * count];
            let slope = b[i] - row.iter().zip(x.iter()).map(|(g, x)| g * x).sum::<f64>();
            let next = (x[i] + slope / row[i]).max(0.0);
            moved = moved.max((next - x[i]).abs() * row[i].sqrt());
            x[i] = next;
        }
        let size = b.iter().zip(x.iter()).map(|(b, x)| b * x).sum::<f64>();
        if moved * moved <= 1e-18 * size.max(1e-300) {
            break;
        }
    }
}
