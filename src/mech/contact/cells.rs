//! Uniform grid for queries of the faces of a deformed surface near a point: each cell of the bounding box lists the
//! faces close to it.

use glam::{DVec3, UVec3};

/// Faces by cell.
#[derive(Debug, Clone)]
pub(crate) struct FaceGrid {
    /// Distance within which a cell lists all faces around any of its points, m: at most the mean width of a face.
    pub near: f64,
    reach: f64,
    low: DVec3,
    size: f64,
    count: UVec3,
    /// Start of the faces of each cell in `faces`; one more entry than cells.
    first: Vec<u32>,
    faces: Vec<u32>,
}

/// Maximum number of cells along an axis.
const MAX_CELLS_PER_AXIS: f64 = 64.0;

impl FaceGrid {
    /// Creates a grid without faces; its cells will list those nearer than `reach` (m), or than the mean width of a
    /// face if that is less.
    pub fn new(reach: f64) -> Self {
        Self {
            near: reach,
            reach,
            low: DVec3::ZERO,
            size: 1.0,
            count: UVec3::ZERO,
            first: Vec::new(),
            faces: Vec::new(),
        }
    }

    /// Sorts faces, given by the corners of their bounding boxes (m), into cells half as wide as a face; the box from
    /// `low` to `high` encloses them all.
    pub fn update(&mut self, boxes: &[[DVec3; 2]], low: DVec3, high: DVec3) {
        let widths: f64 = boxes.iter().map(|[low, high]| (*high - *low).max_element()).sum();
        let width = widths / boxes.len().max(1) as f64;
        self.near = self.reach.min(width);
        let extent = (high - low).max(DVec3::ZERO) + 2.0 * self.near;
        self.low = low - self.near;
        self.size = (0.5 * width).max(extent.max_element() / MAX_CELLS_PER_AXIS);
        self.count = (extent / self.size).as_uvec3() + 1;
        let mut next = vec![0; (self.count.x * self.count.y * self.count.z) as usize + 1];
        for face in boxes {
            self.covered(face, |cell| next[cell + 1] += 1);
        }
        (1..next.len()).for_each(|c| next[c] += next[c - 1]);
        self.first.clone_from(&next);
        let mut faces = std::mem::take(&mut self.faces);
        faces.resize(next[next.len() - 1] as usize, 0);
        for (face, i) in boxes.iter().zip(0..) {
            self.covered(face, |cell| {
                faces[next[cell] as usize] = i;
                next[cell] += 1;
            });
        }
        self.faces = faces;
    }

    /// Faces that may be nearer than `near` to `y`, ascending; farther faces may be among them.
    pub fn at(&self, y: DVec3) -> &[u32] {
        let place = (y - self.low) / self.size;
        let outside = self.first.is_empty() || place.cmplt(DVec3::ZERO).any();
        let at = place.as_uvec3();
        if outside || at.cmpge(self.count).any() {
            return &[];
        }
        let cell = self.index(at);
        &self.faces[self.first[cell] as usize..self.first[cell + 1] as usize]
    }

    fn index(&self, at: UVec3) -> usize {
        ((at.x * self.count.y + at.y) * self.count.z + at.z) as usize
    }

    /// Visits the cells within distance `near` of a face with this box.
    fn covered(&self, [low, high]: &[DVec3; 2], mut visit: impl FnMut(usize)) {
        let place = |p: DVec3| ((p - self.low) / self.size).max(DVec3::ZERO).as_uvec3().min(self.count - 1);
        let (from, to) = (place(*low - self.near), place(*high + self.near));
        for x in from.x..=to.x {
            for y in from.y..=to.y {
                for z in from.z..=to.z {
                    visit(self.index(UVec3::new(x, y, z)));
                }
            }
        }
    }
}
