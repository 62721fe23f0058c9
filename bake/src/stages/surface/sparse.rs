//! Sparse symmetric systems with two right-hand sides: up-looking LDLᵀ factorisation (Davis 2005, "Algorithm 849") in a
//! nested-dissection order (George 1973).

use glam::DVec2;

/// Maximum number of unknowns in a set that is not dissected further.
const LEAF: usize = 24;

/// Symmetric matrix. Each row lists its entries in both triangles of the matrix, by increasing column.
pub(super) struct Symmetric {
    rows: Vec<Vec<(u32, f64)>>,
}

impl Symmetric {
    /// Makes an `n` × `n` matrix from entries (row, column, value) in both triangles. Entries with equal indices are
    /// added.
    pub(super) fn new(n: usize, entries: impl Iterator<Item = (usize, usize, f64)>) -> Self {
        let mut rows: Vec<Vec<(u32, f64)>> = vec![Vec::new(); n];
        entries.for_each(|(row, column, value)| rows[row].push((column as u32, value)));
        for row in &mut rows {
            row.sort_by_key(|(column, _)| *column);
            row.dedup_by(|next, sum| {
                next.0 == sum.0 && {
                    sum.1 += next.1;
                    true
                }
            });
        }
        Self { rows }
    }

    /// Returns the product with `x`.
    pub(super) fn times(&self, x: &[DVec2]) -> Vec<DVec2> {
        self.rows.iter().map(|row| row.iter().map(|(j, value)| x[*j as usize] * *value).sum()).collect()
    }

    /// Returns the unknowns in an elimination order with little fill-in: first two halves, then the separator between
    /// them. The separator is one level of a breadth-first search.
    fn order(&self) -> Vec<u32> {
        let n = self.rows.len();
        let mut order = vec![0; n];
        // Current set of each unknown, and its level in the breadth-first search through that set.
        let (mut part, mut level) = (vec![0usize; n], vec![0u32; n]);
        let (mut parts, mut todo) = (1, vec![((0..n as u32).collect::<Vec<_>>(), n)]);
        while let Some((set, end)) = todo.pop() {
            let Some(mut from) = set.first().copied() else { continue };
            let mut found = Vec::new();
            for _ in 0..if set.len() > LEAF { 2 } else { 0 } {
                let inside = part[from as usize];
                parts += 1;
                (found, part[from as usize], level[from as usize]) = (vec![from], parts, 0);
                let mut at = 0;
                while let Some(i) = found.get(at).copied() {
                    at += 1;
                    for (j, _) in &self.rows[i as usize] {
                        if part[*j as usize] == inside {
                            (part[*j as usize], level[*j as usize]) = (parts, level[i as usize] + 1);
                            found.push(*j);
                        }
                    }
                }
                from = found[found.len() - 1];
            }
            let own = part[from as usize];
            // The separator leaves at least one level beyond it.
            let middle =
                found.get(found.len() / 2).map_or(0, |i| level[*i as usize].min(level[from as usize].max(1) - 1));
            let is_beyond = |i: u32| part[i as usize] == own && level[i as usize] > middle;
            let (mut near, mut far, mut between) = (Vec::new(), Vec::new(), Vec::new());
            for i in &found {
                let separates = || self.rows[*i as usize].iter().any(|(j, _)| is_beyond(*j));
                match level[*i as usize].cmp(&middle) {
                    std::cmp::Ordering::Greater => far.push(*i),
                    std::cmp::Ordering::Equal if separates() => between.push(*i),
                    _ => near.push(*i),
                }
            }
            // Components that the search did not reach need no separator.
            let apart: Vec<u32> =
                set.iter().copied().filter(|i| found.len() < set.len() && part[*i as usize] != own).collect();
            if far.is_empty() && apart.is_empty() {
                order[end - set.len()..end].copy_from_slice(&set);
                continue;
            }
            let mut end = end - between.len();
            order[end..end + between.len()].copy_from_slice(&between);
            for half in [far, near, apart] {
                parts += 1;
                half.iter().for_each(|i| part[*i as usize] = parts);
                let size = half.len();
                todo.push((half, end));
                end -= size;
            }
        }
        order
    }

    /// Factorises the matrix; `None` if it is not positive definite.
    pub(super) fn factor(&self) -> Option<Factor> {
        const NONE: usize = usize::MAX;
        let (n, order) = (self.rows.len(), self.order());
        let mut place = vec![0; n];
        order.iter().enumerate().for_each(|(k, i)| place[*i as usize] = k);
        let mut columns: Vec<Vec<(u32, f64)>> = vec![Vec::new(); n];
        let mut diagonal = vec![0.0; n];
        // Elimination tree, last row that reached each unknown, and values of the current row.
        let (mut parent, mut met, mut row) = (vec![NONE; n], vec![NONE; n], vec![0.0; n]);
        let (mut pattern, mut path) = (Vec::new(), Vec::new());
        for k in 0..n {
            met[k] = k;
            for (j, value) in &self.rows[order[k] as usize] {
                let mut i = place[*j as usize];
                if i > k {
                    continue;
                }
                row[i] += value;
                while met[i] != k {
                    (met[i], parent[i]) = (k, parent[i].min(k));
                    path.push(i);
                    i = parent[i];
                }
                pattern.extend(path.drain(..).rev());
            }
            let mut pivot = std::mem::take(&mut row[k]);
            // In reverse, every unknown precedes its ancestors in the tree.
            for i in pattern.drain(..).rev() {
                let value = std::mem::take(&mut row[i]);
                columns[i].iter().for_each(|(j, lower)| row[*j as usize] -= lower * value);
                let lower = value / diagonal[i];
                pivot -= lower * value;
                columns[i].push((k as u32, lower));
            }
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            diagonal[k] = pivot;
        }
        Some(Factor { order, columns, diagonal })
    }
}

/// Factors L and D of a matrix, with reordered unknowns.
pub(super) struct Factor {
    order: Vec<u32>,
    /// Entries of each column of L below the unit diagonal.
    columns: Vec<Vec<(u32, f64)>>,
    diagonal: Vec<f64>,
}

impl Factor {
    /// Solves the system for a right-hand side.
    pub(super) fn solve(&self, right: &[DVec2]) -> Vec<DVec2> {
        let mut x: Vec<DVec2> = self.order.iter().map(|i| right[*i as usize]).collect();
        for (k, column) in self.columns.iter().enumerate() {
            let value = x[k];
            column.iter().for_each(|(j, lower)| x[*j as usize] -= value * *lower);
        }
        let mut out = vec![DVec2::ZERO; x.len()];
        for (k, column) in self.columns.iter().enumerate().rev() {
            let below: DVec2 = column.iter().map(|(j, lower)| x[*j as usize] * *lower).sum();
            x[k] = x[k] / self.diagonal[k] - below;
            out[self.order[k] as usize] = x[k];
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::uniform;

    /// Makes the Laplacian of a triangulated grid with random weights, plus `hold` on the diagonal. Five more unknowns
    /// are unconnected.
    fn sheet(side: usize, hold: f64) -> Symmetric {
        let n = side * side;
        let edges = (0..n).flat_map(move |i| {
            let (x, y) = (i % side, i / side);
            let to = [(x + 1 < side).then_some(i + 1), (y + 1 < side).then_some(i + side)];
            let across = (x + 1 < side && y + 1 < side).then_some(i + side + 1);
            to.into_iter().chain([across]).flatten().map(move |j| (i, j, 0.1 + uniform(7, (i * n + j) as u64)))
        });
        let entries = edges.flat_map(|(i, j, weight)| {
            let weight = f64::from(weight);
            [(i, i, weight), (j, j, weight), (i, j, -weight), (j, i, -weight)]
        });
        Symmetric::new(n + 5, entries.chain((0..n).map(|i| (i, i, hold))).chain((n..n + 5).map(|i| (i, i, 2.0))))
    }

    /// Solves a system by dense Gaussian elimination without pivoting.
    fn dense(matrix: &Symmetric, right: &[DVec2]) -> Vec<DVec2> {
        let n = right.len();
        let mut full = vec![vec![0.0; n]; n];
        for (row, entries) in full.iter_mut().zip(&matrix.rows) {
            entries.iter().for_each(|(j, value)| row[*j as usize] = *value);
        }
        let mut x = right.to_vec();
        for k in 0..n {
            for i in k + 1..n {
                let share = full[i][k] / full[k][k];
                let upper = full[k].clone();
                full[i].iter_mut().zip(&upper).for_each(|(entry, above)| *entry -= share * above);
                let above = x[k];
                x[i] -= above * share;
            }
        }
        for k in (0..n).rev() {
            let rest: DVec2 = (k + 1..n).map(|j| x[j] * full[k][j]).sum();
            x[k] = (x[k] - rest) / full[k][k];
        }
        x
    }

    #[test]
    fn sparse_and_dense_solutions_agree() {
        for side in [1, 2, 5, 6, 17] {
            let matrix = sheet(side, 1e-3);
            let n = side * side + 5;
            let right: Vec<DVec2> =
                (0..n as u64).map(|i| DVec2::new(f64::from(uniform(1, i)), f64::from(uniform(2, i)))).collect();
            let (found, expected) = (matrix.factor().unwrap().solve(&right), dense(&matrix, &right));
            let largest = expected.iter().map(|x| x.length()).fold(0.0, f64::max);
            assert!(found.iter().zip(&expected).all(|(a, b)| a.distance(*b) < 1e-11 * largest), "side {side}");
            assert!(matrix.times(&found).iter().zip(&right).all(|(a, b)| a.distance(*b) < 1e-11), "side {side}");
        }
    }

    #[test]
    fn nested_dissection_limits_fill() {
        let side = 60;
        let matrix = sheet(side, 1e-3);
        let mut order = matrix.order();
        let factor = matrix.factor().unwrap();
        let entries: usize = factor.columns.iter().map(Vec::len).sum();
        // In the natural order, the bandwidth would be `side + 1`.
        assert!(entries < side * side * side / 2, "{entries}");
        order.sort_unstable();
        assert!(order.iter().enumerate().all(|(k, i)| k == *i as usize));
    }

    #[test]
    fn a_hub_is_eliminated_late() {
        let n = 2000;
        let spokes = (1..n).flat_map(|i| [(0, i), (i, 1 + i % (n - 1))]);
        let both = spokes.flat_map(|(i, j)| [(i, i, 1.1), (j, j, 1.1), (i, j, -1.0), (j, i, -1.0)]);
        let entries: usize = Symmetric::new(n, both).factor().unwrap().columns.iter().map(Vec::len).sum();
        assert!(entries < 20 * n, "{entries}");
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_is_refused() {
        let of = |entries: &[(usize, usize, f64)]| Symmetric::new(2, entries.iter().copied()).factor().is_none();
        assert!(of(&[(0, 0, 1.0), (0, 1, 2.0), (1, 0, 2.0), (1, 1, 4.0)]), "singular");
        assert!(of(&[(0, 0, 1.0), (1, 1, -1.0)]), "indefinite");
        assert!(of(&[(0, 0, f64::NAN), (1, 1, 1.0)]), "not a number");
        assert!(of(&[(0, 0, 1.0)]), "a row without entries");
        assert!(Symmetric::new(0, std::iter::empty()).factor().unwrap().solve(&[]).is_empty());
    }
}
