//! Adjacency of the triangles of a surface, and the parts of the surface that interact with a point.

/// Part of one triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TrianglePart {
    /// Interior.
    Face,
    /// Edge `i`, from corner `i` to corner `i + 1`.
    Edge(usize),
    /// Corner `i`.
    Corner(usize),
}

/// Part of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SurfacePart {
    /// Interior of a triangle.
    Face(u32),
    /// Edge.
    Edge(u32),
    /// Vertex.
    Corner(u32),
}

/// Position of a triangle relative to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TrianglePosition {
    /// Triangle out of range.
    Beyond,
    /// Triangle whose back faces the point: the other side of a thin ridge.
    Behind,
    /// Triangle of which this part is nearest.
    At(TrianglePart),
}

/// Adjacency of the triangles of a surface.
#[derive(Debug, Clone, Default)]
pub struct TriangleAdjacency {
    corners: Vec<[u32; 3]>,
    /// Edges of each triangle; edge `i` runs from its corner `i` to its corner `i + 1`, or back.
    edges: Vec<[u32; 3]>,
    /// First triangle of each edge, and the index of the edge in it.
    owner: Vec<(u32, usize)>,
    /// Two triangles at each edge; None on the rim of the surface.
    sides: Vec<Option<[u32; 2]>>,
    /// Offset of the triangles of each vertex in `triangles`; one more entry than vertices.
    first: Vec<usize>,
    /// Triangles around each vertex, ascending.
    triangles: Vec<u32>,
    /// True for each vertex whose triangles form a closed fan around it.
    closed: Vec<bool>,
}

impl TriangleAdjacency {
    /// Builds the adjacency of triangles given by their vertices.
    pub fn new(corners: Vec<[u32; 3]>) -> Self {
        let count = corners.iter().flatten().max().map_or(0, |v| *v as usize + 1);
        let mut first = vec![0; count + 1];
        corners.iter().flatten().for_each(|v| first[*v as usize + 1] += 1);
        (1..=count).for_each(|v| first[v] += first[v - 1]);
        let mut next = first.clone();
        let mut triangles = vec![0; 3 * corners.len()];
        let mut met: Vec<([u32; 2], u32, usize)> = Vec::with_capacity(3 * corners.len());
        for (t, c) in (0..).zip(&corners) {
            for i in 0..3 {
                let (a, b) = (c[i], c[(i + 1) % 3]);
                met.push(([a.min(b), a.max(b)], t, i));
                triangles[next[a as usize]] = t;
                next[a as usize] += 1;
            }
        }
        met.sort_unstable();
        let (mut edges, mut closed) = (vec![[0; 3]; corners.len()], vec![true; count]);
        let (mut owner, mut sides) = (Vec::new(), Vec::new());
        for meeting in met.chunk_by(|a, b| a.0 == b.0) {
            meeting.iter().for_each(|&(_, t, i)| edges[t as usize][i] = sides.len() as u32);
            let (ends, t, i) = meeting[0];
            owner.push((t, i));
            sides.push(if let [(_, s, _), (_, t, _)] = *meeting { Some([s, t]) } else { None });
            if meeting.len() != 2 {
                ends.iter().for_each(|v| closed[*v as usize] = false);
            }
        }
        Self { corners, edges, owner, sides, first, triangles, closed }
    }

    /// Returns the triangles around a vertex, ascending.
    pub fn vertex_triangles(&self, vertex: u32) -> &[u32] {
        let v = vertex as usize;
        if v < self.closed.len() { &self.triangles[self.first[v]..self.first[v + 1]] } else { &[] }
    }

    /// Returns the two triangles at edge `i` of a triangle; None on the rim of the surface.
    pub fn edge_triangles(&self, triangle: u32, i: usize) -> Option<[u32; 2]> {
        self.sides[self.edges[triangle as usize][i] as usize]
    }

    /// Returns a triangle at an edge, and the index of the edge in it.
    pub fn triangle_of_edge(&self, edge: u32) -> (u32, usize) {
        self.owner[edge as usize]
    }

    /// Returns a triangle at a vertex, and the index of the corner in it.
    pub fn triangle_of_vertex(&self, vertex: u32) -> Option<(u32, usize)> {
        let &t = self.vertex_triangles(vertex).first()?;
        Some((t, self.corners[t as usize].iter().position(|c| *c == vertex)?))
    }

    /// Returns the triangles that share a vertex with `triangle`, itself included, ascending.
    fn ring(&self, triangle: u32) -> Vec<u32> {
        let mut ring: Vec<u32> =
            self.corners[triangle as usize].iter().flat_map(|v| self.vertex_triangles(*v)).copied().collect();
        ring.sort_unstable();
        ring.dedup();
        ring
    }

    /// Converts a part of a triangle to a part of the surface.
    pub fn to_surface_part(&self, triangle: u32, part: TrianglePart) -> SurfacePart {
        let t = triangle as usize;
        match part {
            TrianglePart::Face => SurfacePart::Face(triangle),
            TrianglePart::Edge(i) => SurfacePart::Edge(self.edges[t][i]),
            TrianglePart::Corner(i) => SurfacePart::Corner(self.corners[t][i]),
        }
    }

    /// Returns the parts of the surface that interact with a point in addition to the closest part, which is `nearest`
    /// of triangle `own`. Each has a weight in a sum in which the weight of the closest part is 1 (inclusion and
    /// exclusion). `view` returns the position of an adjacent triangle relative to the point; `along` returns the part
    /// (edge or corner) of the given triangle that contains the closest point of its given edge.
    pub fn additional_parts(
        &self,
        own: u32,
        nearest: TrianglePart,
        view: impl Fn(u32) -> TrianglePosition,
        along: impl Fn(u32, usize) -> TrianglePart,
    ) -> Vec<(SurfacePart, f64)> {
        let mut found = Vec::new();
        for t in self.ring(own) {
            match if t == own { TrianglePosition::At(nearest) } else { view(t) } {
                TrianglePosition::Beyond => {}
                TrianglePosition::At(part) => found.push((t, part)),
                // At a thin ridge only the closest part interacts.
                TrianglePosition::Behind => return Vec::new(),
            }
        }
        if found.len() < 2 {
            return Vec::new();
        }
        let closest = self.to_surface_part(own, nearest);
        let mut weights = self.weights(&found, along);
        weights.iter_mut().filter(|(place, _)| *place == closest).for_each(|(_, weight)| *weight -= 1.0);
        weights.retain(|(_, weight)| *weight != 0.0);
        weights
    }

    /// Returns the parts of the surface that interact with a point, with weights for a sum of energies of their
    /// distances.
    ///
    /// Near a concave edge (valley) a point is in contact with both incident faces, and the sum over triangles is
    /// smooth where the smallest of their distances has a kink. On flat regions and at convex edges, the triangles at
    /// an edge are equally near and would count twice. Edges within range are therefore subtracted and vertices added
    /// again, so that the sum is that of a single contact (inclusion and exclusion; Li, Ferguson, Schneider et al.
    /// 2023, "Convergent incremental potential contact", section 4).
    ///
    /// `found` contains the triangles within range and the closest part of each.
    fn weights(
        &self,
        found: &[(u32, TrianglePart)],
        along: impl Fn(u32, usize) -> TrianglePart,
    ) -> Vec<(SurfacePart, f64)> {
        let mut weights: Vec<(SurfacePart, f64)> = Vec::new();
        let mut add = |place: SurfacePart, weight: f64| match weights.iter_mut().find(|(p, _)| *p == place) {
            Some(known) => known.1 += weight,
            None => weights.push((place, weight)),
        };
        let within = |triangle: &u32| found.iter().any(|(t, _)| t == triangle);
        for &(t, part) in found {
            add(self.to_surface_part(t, part), 1.0);
            for i in 0..3 {
                let edge = self.edges[t as usize][i];
                // Once per edge, by the first of its triangles.
                if let Some(sides) = self.sides[edge as usize]
                    && self.owner[edge as usize].0 == t
                    && sides.iter().all(within)
                {
                    add(self.to_surface_part(t, along(t, i)), -1.0);
                }
                let vertex = self.corners[t as usize][i];
                let ring = self.vertex_triangles(vertex);
                if self.closed[vertex as usize] && ring[0] == t && ring.iter().all(within) {
                    add(SurfacePart::Corner(vertex), 1.0);
                }
            }
        }
        weights.retain(|(_, weight)| *weight != 0.0);
        weights
    }
}
