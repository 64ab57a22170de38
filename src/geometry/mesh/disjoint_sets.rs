//! Disjoint sets of numbers (union-find with path halving: Tarjan and van Leeuwen 1984).

/// Disjoint sets of the numbers from 0 on; each is represented by its smallest number.
#[derive(Debug)]
pub(crate) struct DisjointSets(Vec<u32>);

impl DisjointSets {
    /// Creates `count` sets of one number each.
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// Returns the smallest number of the set that contains `i`.
    pub fn find(&mut self, mut i: u32) -> u32 {
        let parent = &mut self.0;
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }

    /// Joins the sets that contain two numbers.
    pub fn union(&mut self, [a, b]: [u32; 2]) {
        let [a, b] = [a, b].map(|i| self.find(i));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
