//! Z-buffer rasteriser for triangles with interpolated values, with supersampling.

use super::draw::Rgb;
use super::text::blend;
use glam::DVec3;
use tiny_skia::Pixmap;

/// Number of samples per pixel and axis.
const SUPER: usize = 2;

/// Corner of a triangle.
#[derive(Debug, Clone, Copy, Default)]
pub struct Vertex {
    /// Position: x right and y down, pixels; z is the depth (smaller is nearer, any unit).
    pub position: DVec3,
    /// Value passed to the shader.
    pub value: f64,
    /// Surface normal, in the frame of the light direction of the shader.
    pub normal: DVec3,
}

/// Rectangle of samples, drawn off-screen.
pub struct Raster {
    width: usize,
    height: usize,
    samples: Vec<Sample>,
}

/// Sample: depth, body (0 is none) and colour; compact, because there are millions.
#[derive(Clone, Copy)]
struct Sample {
    depth: f32,
    body: u8,
    rgb: Rgb,
}

impl Raster {
    /// Returns an empty rectangle of `width` x `height` pixels.
    pub fn new(width: usize, height: usize) -> Self {
        let (width, height) = (width * SUPER, height * SUPER);
        let empty = Sample { depth: f32::INFINITY, body: 0, rgb: [0; 3] };
        Raster { width, height, samples: vec![empty; width * height] }
    }

    /// Draws a triangle of `body` (not 0) where it is nearest; `shade(value, normal)` returns its colour.
    pub fn triangle(&mut self, corners: [Vertex; 3], body: u8, shade: impl Fn(f64, DVec3) -> [f32; 3]) {
        let [a, b, c] = corners.map(|v| v.position * DVec3::new(SUPER as f64, SUPER as f64, 1.0));
        let area = cross(a, b, c);
        if !(area.is_finite() && area.abs() > 1e-12) {
            return;
        }
        let clamp = |v: f64, limit: usize| v.clamp(0.0, limit as f64) as usize;
        let columns = clamp(a.x.min(b.x).min(c.x).floor(), self.width)..clamp(a.x.max(b.x).max(c.x).ceil(), self.width);
        let rows = clamp(a.y.min(b.y).min(c.y).floor(), self.height)..clamp(a.y.max(b.y).max(c.y).ceil(), self.height);
        for row in rows {
            for column in columns.clone() {
                let p = DVec3::new(column as f64 + 0.5, row as f64 + 0.5, 0.0);
                let weights = [cross(b, c, p) / area, cross(c, a, p) / area, cross(a, b, p) / area];
                // The tolerance prevents gaps between triangles that share an edge.
                if weights.iter().any(|&w| w < -1e-9) {
                    continue;
                }
                let depth = (weights[0] * a.z + weights[1] * b.z + weights[2] * c.z) as f32;
                let sample = &mut self.samples[row * self.width + column];
                if depth < sample.depth {
                    let value = (0..3).map(|i| weights[i] * corners[i].value).sum();
                    let normal: DVec3 = (0..3).map(|i| weights[i] * corners[i].normal).sum();
                    let rgb = shade(value, normal.normalize_or_zero()).map(byte);
                    *sample = Sample { depth, body, rgb };
                }
            }
        }
    }

    /// Sets the depth of all samples of `body` to `depth(x, y)`; x and y in pixels.
    pub fn move_to(&mut self, body: u8, depth: impl Fn(f64, f64) -> f64) {
        let pixel = |i: usize| (i as f64 + 0.5) / SUPER as f64;
        for (index, sample) in self.samples.iter_mut().enumerate().filter(|(_, sample)| sample.body == body) {
            sample.depth = depth(pixel(index % self.width), pixel(index / self.width)) as f32;
        }
    }

    /// Copies the samples of a raster of the same size that are nearer.
    pub fn merge(&mut self, other: &Self) {
        for (own, sample) in self.samples.iter_mut().zip(&other.samples) {
            if sample.depth < own.depth {
                *own = *sample;
            }
        }
    }

    /// Darkens the samples on the border of a body.
    pub fn outline(&mut self, strength: f32) {
        let body = |x: usize, y: usize| self.samples[y * self.width + x].body;
        let mut edges = Vec::new();
        for y in 1..self.height.saturating_sub(1) {
            for x in 1..self.width.saturating_sub(1) {
                let own = body(x, y);
                if own != 0
                    && [body(x - 1, y), body(x + 1, y), body(x, y - 1), body(x, y + 1)].iter().any(|&b| b != own)
                {
                    edges.push(y * self.width + x);
                }
            }
        }
        for index in edges {
            self.samples[index].rgb = self.samples[index].rgb.map(|c| byte(f32::from(c) * (1.0 - strength)));
        }
    }

    /// Averages the samples and blends them into the page, the top left corner at (`x`, `y`); `opacity` in 0..=1.
    pub fn paste(&self, page: &mut Pixmap, x: i32, y: i32, opacity: f32) {
        for row in 0..self.height / SUPER {
            for column in 0..self.width / SUPER {
                let (mut sum, mut hits) = ([0u16; 3], 0u16);
                for i in 0..SUPER * SUPER {
                    let sample = &self.samples[(row * SUPER + i / SUPER) * self.width + column * SUPER + i % SUPER];
                    if sample.body != 0 {
                        hits += 1;
                        (0..3).for_each(|k| sum[k] += u16::from(sample.rgb[k]));
                    }
                }
                if hits > 0 {
                    let rgb: Rgb = sum.map(|s| ((s + hits / 2) / hits) as u8);
                    let coverage = opacity * f32::from(hits) / (SUPER * SUPER) as f32;
                    blend(page, x + column as i32, y + row as i32, rgb, coverage);
                }
            }
        }
    }
}

fn byte(c: f32) -> u8 {
    c.round().clamp(0.0, 255.0) as u8
}

/// Returns twice the signed area of the triangle in the image plane.
fn cross(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearer_triangle_wins_in_either_order() {
        let triangle = |z: f64| {
            [(0.0, 0.0), (8.0, 0.0), (0.0, 8.0)]
                .map(|(x, y)| Vertex { position: DVec3::new(x, y, z), ..Vertex::default() })
        };
        for order in [[1.0, 2.0], [2.0, 1.0]] {
            let mut raster = Raster::new(4, 4);
            for z in order {
                raster.triangle(triangle(z), z as u8, |_, _| [0.0; 3]);
            }
            assert!(raster.samples.iter().take(3).all(|s| s.body == 1));
        }
    }

    #[test]
    fn neighbours_leave_no_hole() {
        let corner = |x: f64, y: f64| Vertex { position: DVec3::new(x, y, 0.0), ..Vertex::default() };
        let [a, b, c, d] = [corner(0.0, 0.0), corner(7.0, 0.0), corner(7.0, 7.0), corner(0.0, 7.0)];
        let mut raster = Raster::new(7, 7);
        raster.triangle([a, b, c], 1, |_, _| [0.0; 3]);
        raster.triangle([a, c, d], 1, |_, _| [0.0; 3]);
        assert!(raster.samples.iter().all(|s| s.body == 1));
    }

    #[test]
    fn nonsense_coordinates_draw_nothing() {
        let mut raster = Raster::new(4, 4);
        let bad = Vertex { position: DVec3::new(f64::NAN, 1.0, 0.0), ..Vertex::default() };
        raster.triangle([bad, Vertex::default(), bad], 1, |_, _| [0.0; 3]);
        assert!(raster.samples.iter().all(|s| s.body == 0));
    }
}
