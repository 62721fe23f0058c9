//! Joins line segments between vertices to strands.

use std::collections::HashSet;

/// Joins line segments that share an end to strands. Returns the vertices of each strand from end to end; strands are
/// in the order of their first segments.
///
/// A strand ends where more than two segments meet. Each strand has the direction of the majority of its segments.
/// Repeated segments, and segments from a vertex to itself, are ignored.
///
/// * `vertices`: number of vertices, greater than any index in `lines`
pub fn join_lines(lines: &[[u32; 2]], vertices: usize) -> Vec<Vec<u32>> {
    let mut seen = HashSet::new();
    let is_new = |line: &[u32; 2]| line[0] != line[1] && seen.insert([line[0].min(line[1]), line[0].max(line[1])]);
    let lines: Vec<[u32; 2]> = lines.iter().copied().filter(is_new).collect();
    // Number of segments at each vertex, and the sum of their indices. If two segments meet at a vertex, the sum minus
    // the index of one gives the index of the other.
    let (mut count, mut sum) = (vec![0u32; vertices], vec![0usize; vertices]);
    for (number, line) in lines.iter().enumerate() {
        for end in line {
            count[*end as usize] += 1;
            sum[*end as usize] += number;
        }
    }
    // Returns the segment that continues `line` at its end `end`, and the other end of that segment. `None` if the
    // strand ends there.
    let next = |line: usize, end: u32| {
        let goes_on = count[end as usize] == 2;
        goes_on.then(|| {
            let other = sum[end as usize] - line;
            (other, if lines[other][0] == end { lines[other][1] } else { lines[other][0] })
        })
    };
    let mut used = vec![false; lines.len()];
    let mut strands = Vec::new();
    for first in 0..lines.len() {
        if used[first] {
            continue;
        }
        // Walk back to the beginning of the strand, or once around a closed loop.
        let (mut line, mut end) = (first, lines[first][0]);
        while let Some((before, begins)) = next(line, end) {
            (line, end) = if before == first { (first, lines[first][0]) } else { (before, begins) };
            if before == first {
                break;
            }
        }
        let mut strand = vec![end];
        let mut along = 0i64;
        let mut goes = Some((line, if lines[line][0] == end { lines[line][1] } else { lines[line][0] }));
        while let Some((line, end)) = goes.filter(|(line, _)| !used[*line]) {
            used[line] = true;
            along += if lines[line][1] == end { 1 } else { -1 };
            strand.push(end);
            goes = next(line, end);
        }
        if along < 0 {
            strand.reverse();
        }
        strands.push(strand);
    }
    strands
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_share_ends_are_one_strand() {
        assert_eq!(join_lines(&[[0, 1], [1, 2], [3, 4], [4, 5]], 6), [[0, 1, 2], [3, 4, 5]]);
        // The segments are unordered, and some are reversed.
        assert_eq!(join_lines(&[[4, 5], [1, 2], [4, 3], [3, 2], [0, 1], [5, 6]], 7), [[0, 1, 2, 3, 4, 5, 6]]);
        assert_eq!(join_lines(&[[1, 0], [2, 1]], 3), [[2, 1, 0]]);
        assert_eq!(join_lines(&[], 0), [[0; 0]; 0]);
    }

    #[test]
    fn forks_end_strands_and_rings_close() {
        let mut found = join_lines(&[[0, 1], [1, 2], [1, 3], [3, 4]], 5);
        found.sort();
        assert_eq!(found, [vec![0, 1], vec![1, 2], vec![1, 3, 4]]);
        assert_eq!(join_lines(&[[0, 1], [1, 2], [2, 0]], 3), [[0, 1, 2, 0]]);
        assert_eq!(join_lines(&[[0, 0], [0, 1], [1, 0]], 2), [[0, 1]], "a line alone, and one twice");
    }
}
