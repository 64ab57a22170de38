//! Bounding-volume tree over the triangles of a mesh, for closest points and rays.
//!
//! Binned surface-area heuristic (Wald 2007, "On fast construction of SAH-based bounding volume hierarchies").

use crate::Aabb;
use crate::shape::facet::Facet;
use glam::DVec3;

const LEAF: usize = 4;
const BINS: usize = 16;
/// Depth beyond which nodes are split at the median, which bounds the depth of the tree by
/// `SAH_DEPTH + log2(u32::MAX)`.
const SAH_DEPTH: usize = 40;
const STACK: usize = 80;

/// Node: a leaf has `count > 0` facets from `first`; an inner node has the children `first` and `first + 1`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BvhNode {
    pub bounds: Aabb,
    pub first: u32,
    pub count: u32,
}

/// Tree with its facets, in the order of the leaves.
#[derive(Debug, Clone)]
pub(crate) struct Bvh {
    pub(crate) nodes: Vec<BvhNode>,
    pub facets: Vec<Facet>,
}

impl Bvh {
    pub fn new(mut facets: Vec<Facet>) -> Self {
        let mut items: Vec<(Aabb, DVec3, u32)> =
            facets.iter().zip(0..).map(|(f, i)| (f.aabb(), f.aabb().center(), i)).collect();
        let mut nodes = vec![BvhNode { bounds: Aabb::EMPTY, first: 0, count: items.len() as u32 }];
        let mut todo = vec![(0_usize, 0_usize)];
        while let Some((at, depth)) = todo.pop() {
            let (first, count) = (nodes[at].first as usize, nodes[at].count as usize);
            let range = &mut items[first..first + count];
            nodes[at].bounds = union(range.iter().map(|i| &i.0));
            if count <= LEAF {
                continue;
            }
            let left = split(range, depth);
            nodes[at] = BvhNode { first: nodes.len() as u32, count: 0, ..nodes[at] };
            for (first, count) in [(first, left), (first + left, count - left)] {
                todo.push((nodes.len(), depth + 1));
                nodes.push(BvhNode { bounds: Aabb::EMPTY, first: first as u32, count: count as u32 });
            }
        }
        facets = items.iter().map(|i| facets[i.2 as usize]).collect();
        Self { nodes, facets }
    }

    pub fn bounds(&self) -> Aabb {
        self.nodes[0].bounds
    }

    /// Returns the squared distance and the index of the facet nearest to `q` if the distance is below `best.0`;
    /// otherwise `best`.
    #[inline]
    pub fn nearest(&self, q: DVec3, mut best: (f64, u32)) -> (f64, u32) {
        let mut stack = [(0.0_f64, 0_u32); STACK];
        let mut depth = 0;
        let mut at = self.nodes[0];
        if at.bounds.distance_squared(q) >= best.0 {
            return best;
        }
        loop {
            if at.count > 0 {
                for i in at.first..at.first + at.count {
                    let (d, _) = self.facets[i as usize].nearest_within(q, best.0);
                    if d < best.0 {
                        best = (d, i);
                    }
                }
            } else {
                let pair = [at.first, at.first + 1].map(|c| (self.nodes[c as usize].bounds.distance_squared(q), c));
                let [near, far] = if pair[0].0 <= pair[1].0 { pair } else { [pair[1], pair[0]] };
                if far.0 < best.0 {
                    stack[depth] = far;
                    depth += 1;
                }
                if near.0 < best.0 {
                    at = self.nodes[near.1 as usize];
                    continue;
                }
            }
            loop {
                if depth == 0 {
                    return best;
                }
                depth -= 1;
                if stack[depth].0 < best.0 {
                    at = self.nodes[stack[depth].1 as usize];
                    break;
                }
            }
        }
    }

    /// Calls `f` for every facet of the leaves whose bounding boxes intersect `bounds`.
    pub fn overlapping(&self, bounds: &Aabb, mut f: impl FnMut(u32)) {
        let mut stack = vec![0_u32];
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at as usize];
            if !node.bounds.intersects(bounds) {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.first + 1, node.first]);
            } else {
                (node.first..node.first + node.count).for_each(&mut f);
            }
        }
    }

    /// Returns `t` and the index of the first facet through which the ray `o + t d` enters.
    pub fn ray_entry(&self, o: DVec3, d: DVec3) -> Option<(f64, u32)> {
        let inverse = d.recip();
        let mut best = (f64::INFINITY, u32::MAX);
        let mut stack = vec![0_u32];
        while let Some(at) = stack.pop() {
            let node = self.nodes[at as usize];
            if node.bounds.ray_entry(o, inverse, best.0).is_none() {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.first + 1, node.first]);
                continue;
            }
            for i in node.first..node.first + node.count {
                if let Some(t) = self.facets[i as usize].ray_entry(o, d)
                    && t < best.0
                {
                    best = (t, i);
                }
            }
        }
        best.0.is_finite().then_some(best)
    }
}

fn union<'a>(boxes: impl Iterator<Item = &'a Aabb>) -> Aabb {
    boxes.fold(Aabb::EMPTY, |mut all, b| {
        all.merge(b);
        all
    })
}

fn half_area(b: &Aabb) -> f64 {
    let s = b.size().max(DVec3::ZERO);
    s.x * s.y + s.y * s.z + s.z * s.x
}

/// Reorders `items` into two parts and returns the length of the first; neither part is empty.
fn split(items: &mut [(Aabb, DVec3, u32)], depth: usize) -> usize {
    let centers = Aabb::from_points(items.iter().map(|i| i.1));
    let size = centers.size();
    let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
    let bin = |c: DVec3| (((c[axis] - centers.min[axis]) / size[axis] * BINS as f64) as usize).min(BINS - 1);
    if depth < SAH_DEPTH && size[axis] > 0.0 {
        let mut bins = [(Aabb::EMPTY, 0_usize); BINS];
        for item in items.iter() {
            let b = &mut bins[bin(item.1)];
            b.0.merge(&item.0);
            b.1 += 1;
        }
        let cost = |part: &[(Aabb, usize)]| {
            half_area(&union(part.iter().map(|b| &b.0))) * part.iter().map(|b| b.1).sum::<usize>() as f64
        };
        let mut best = (f64::INFINITY, 0);
        for cut in 1..BINS {
            let c = cost(&bins[..cut]) + cost(&bins[cut..]);
            if c < best.0 {
                best = (c, cut);
            }
        }
        items.sort_by_key(|i| (bin(i.1) >= best.1, i.2));
        let left = items.partition_point(|i| bin(i.1) < best.1);
        if left > 0 && left < items.len() {
            return left;
        }
    }
    items.sort_by(|a, b| a.1[axis].total_cmp(&b.1[axis]).then(a.2.cmp(&b.2)));
    items.len() / 2
}
