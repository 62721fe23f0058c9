//! Dense least squares by Householder QR.

/// Returns the coefficients with which the linear combination of `columns` is nearest to `values`. The columns must be
/// linearly independent.
pub(super) fn least_squares(mut columns: Vec<Vec<f64>>, mut values: Vec<f64>) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    for k in 0..columns.len() {
        let mut mirror = columns[k][k..].to_vec();
        mirror[0] += dot(&mirror, &mirror).sqrt().copysign(mirror[0]);
        let half = 0.5 * dot(&mirror, &mirror);
        for column in columns[k..].iter_mut().chain([&mut values]) {
            let share = dot(&mirror, &column[k..]) / half;
            column[k..].iter_mut().zip(&mirror).for_each(|(entry, along)| *entry -= share * along);
        }
    }
    for k in (0..columns.len()).rev() {
        values[k] /= columns[k][k];
        for i in 0..k {
            values[i] -= values[k] * columns[k][i];
        }
    }
    values.truncate(columns.len());
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn residual_is_orthogonal_to_the_columns() {
        let column = |k: i32| (0..40).map(|i| libm::pow(0.1 * f64::from(i), f64::from(k))).collect::<Vec<_>>();
        let columns: Vec<Vec<f64>> = (0..5).map(column).collect();
        let values: Vec<f64> = (0..40).map(|i| libm::sin(0.3 * f64::from(i))).collect();
        let found = least_squares(columns.clone(), values.clone());
        let fitted = |i: usize| columns.iter().zip(&found).map(|(column, x)| column[i] * x).sum::<f64>();
        for (k, column) in columns.iter().enumerate() {
            let along: f64 = (0..40).map(|i| (values[i] - fitted(i)) * column[i]).sum();
            assert!(along.abs() < 1e-10, "column {k}: {along}");
        }
        assert_eq!(least_squares(vec![vec![-2.0]], vec![3.0]), [-1.5]);
    }
}
