//! Disjoint sets as trees in a list of parents (union-find).

/// Returns the root of an element's set, and shortens the path to it. A root is its own parent.
///
/// # Panics
/// If a parent is not an index of the list.
pub fn root(parents: &mut [u32], mut element: u32) -> u32 {
    while parents[element as usize] != element {
        parents[element as usize] = parents[parents[element as usize] as usize];
        element = parents[element as usize];
    }
    element
}
