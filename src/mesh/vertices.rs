//! One index per vertex out of several index streams.

/// Longest list of variants that is searched per position. Past it a vertex is repeated, which costs memory only; without
/// the bound, a fan of a million different texture coordinates around one point would take quadratic time.
const SEARCH_LIMIT: usize = 64;

const NONE: u32 = u32::MAX;

/// Vertices with distinct index tuples.
pub struct Unified {
    pub triangles: Vec<[u32; 3]>,
    /// For each vertex, the number of a corner that has its tuple.
    pub corners: Vec<u32>,
}

/// `tuples` holds `width` indices per corner, the position first; three corners make a triangle.
pub fn unify(tuples: &[u32], width: usize, positions: usize) -> Unified {
    // Variants of one position form a linked list. Their number is about one, so this beats hashing.
    let mut first = vec![NONE; positions];
    let mut next: Vec<u32> = Vec::with_capacity(positions);
    let mut corners: Vec<u32> = Vec::with_capacity(positions);
    let tuple = |corner: u32| &tuples[corner as usize * width..(corner as usize + 1) * width];
    let mut vertex_of = |corner: u32| {
        let own = tuple(corner);
        let head = &mut first[own[0] as usize];
        let variants = std::iter::successors((*head != NONE).then_some(*head), |&vertex| {
            let following = next[vertex as usize];
            (following != NONE).then_some(following)
        });
        let known = variants.take(SEARCH_LIMIT).find(|&vertex| tuple(corners[vertex as usize]) == own);
        known.unwrap_or_else(|| {
            let vertex = corners.len() as u32;
            corners.push(corner);
            next.push(*head);
            *head = vertex;
            vertex
        })
    };
    let triangles = (0..(tuples.len() / width) as u32 / 3)
        .map(|triangle| [vertex_of(3 * triangle), vertex_of(3 * triangle + 1), vertex_of(3 * triangle + 2)])
        .collect();
    Unified { triangles, corners }
}
