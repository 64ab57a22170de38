//! Volume, centre of mass and inertia of unit density.

use crate::mesh::TriMesh;
use crate::shape::outer;
use crate::shape::polygon::Profile;
use glam::{DMat3, DVec3};
use std::f64::consts::PI;

/// Mass properties at unit density; multiply volume and inertia by the density in kg/m3.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProperties {
    /// Volume, m3.
    pub volume: f64,
    /// Centre of mass, m.
    pub center: DVec3,
    /// Inertia tensor about the centre of mass, axes of the object's frame, m5 (kg m2 at 1 kg/m3).
    pub inertia: DMat3,
}

impl MassProperties {
    /// Builds the mass properties from the volume, the centre and the second moments `integral of r r^T` about the
    /// centre, m5.
    pub fn from_moments(volume: f64, center: DVec3, second: DMat3) -> Self {
        let trace = second.x_axis.x + second.y_axis.y + second.z_axis.z;
        Self { volume, center, inertia: DMat3::from_diagonal(DVec3::splat(trace)) - second }
    }

    /// Computes the mass properties of the polyhedron inside a closed, outward-wound mesh: sums over the tetrahedra
    /// from a reference point to each triangle, for which all moments are exact (Tonon 2004, eq. 9; the same integrals
    /// as Mirtich 1996 and Eberly 2002).
    pub fn of_mesh(mesh: &TriMesh) -> Self {
        // A reference point at the centroid of the vertices avoids cancellation for an object far from its origin.
        let count = mesh.vertices.len().max(1) as f64;
        let reference = mesh.vertices.iter().copied().sum::<DVec3>() / count;
        let (mut volume, mut first, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| mesh.vertices[v as usize] - reference);
            let v = a.dot(b.cross(c)) / 6.0;
            let sum = a + b + c;
            volume += v;
            first += v / 4.0 * sum;
            second += (outer(sum) + outer(a) + outer(b) + outer(c)) * (v / 20.0);
        }
        let center = first / volume;
        Self::from_moments(volume, reference + center, second - outer(center) * volume)
    }

    /// Computes the mass properties of an ellipsoid with the given semi-axes, m.
    pub fn of_ellipsoid(semi: DVec3) -> Self {
        let volume = 4.0 / 3.0 * PI * semi.element_product();
        Self::from_moments(volume, DVec3::ZERO, DMat3::from_diagonal(semi * semi * (volume / 5.0)))
    }

    /// Computes the mass properties of a capsule along z: a cylinder of length `2 half` and two hemispheres, m.
    pub fn of_capsule(radius: f64, half: f64) -> Self {
        let (r2, h) = (radius * radius, half);
        let tube = 2.0 * PI * r2 * h;
        let ball = 4.0 / 3.0 * PI * r2 * radius;
        let across = tube * r2 / 4.0 + ball * r2 / 5.0;
        // The centroid of a hemisphere is 3/8 r from its flat face.
        let along = tube * h * h / 3.0 + ball * (r2 / 5.0 + 2.0 * h * 3.0 / 8.0 * radius + h * h);
        Self::from_moments(tube + ball, DVec3::ZERO, DMat3::from_diagonal(DVec3::new(across, across, along)))
    }

    /// Computes the mass properties of a box with the half sizes `core`, offset outward by `radius` (Steiner's
    /// decomposition into the core, slabs, quarter cylinders along the edges and eighths of a ball), m.
    pub fn of_cuboid(core: DVec3, radius: f64) -> Self {
        let (s, r) = (2.0 * core, radius);
        let disc = PI * r * r;
        let ball = 4.0 / 3.0 * PI * r.powi(3);
        let faces = s.x * s.y + s.y * s.z + s.z * s.x;
        let volume = s.element_product() + 2.0 * r * faces + disc * s.element_sum() + ball;
        let moment = |i: usize| {
            let (a, b, c) = (s[i], s[(i + 1) % 3], s[(i + 2) % 3]);
            let h = a / 2.0;
            let flat = a * a / 12.0;
            let core = a * b * c * flat;
            let slabs = 2.0 * b * c * ((h + r).powi(3) - h.powi(3)) / 3.0 + 2.0 * r * a * (b + c) * flat;
            let edges = disc * a * flat + (b + c) * (h * h * disc + a * 4.0 / 3.0 * r.powi(3) + PI * r.powi(4) / 4.0);
            let corners = h * h * ball + a * PI * r.powi(4) / 2.0 + 4.0 / 15.0 * PI * r.powi(5);
            core + slabs + edges + corners
        };
        let second = DVec3::new(moment(0), moment(1), moment(2));
        Self::from_moments(volume, DVec3::ZERO, DMat3::from_diagonal(second))
    }

    /// Computes the mass properties of the solid of revolution of a profile about z: `V = pi * integral rho^2 dz` along
    /// the profile, and likewise the moments, by 3-point Gauss quadrature, which is exact for these polynomials.
    pub fn of_profile(profile: &Profile) -> Self {
        let half_gap = 0.6_f64.sqrt() / 2.0;
        let rule = [(0.5 - half_gap, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.5 + half_gap, 5.0 / 18.0)];
        let (low, high) = profile.bounds();
        let reference = 0.5 * (low.y + high.y);
        let (mut volume, mut first, mut across, mut along) = (0.0, 0.0, 0.0, 0.0);
        for i in 0..profile.segments() {
            let (a, b) = profile.segment(i);
            for (t, w) in rule {
                let p = a.lerp(b, t);
                let (r2, z, w) = (p.x * p.x, p.y - reference, w * PI * (b.y - a.y));
                volume += w * r2;
                first += w * r2 * z;
                across += w * r2 * r2 / 4.0;
                along += w * r2 * z * z;
            }
        }
        let z = first / volume;
        let second = DVec3::new(across, across, along - volume * z * z);
        Self::from_moments(volume, DVec3::Z * (reference + z), DMat3::from_diagonal(second))
    }

    /// Returns the mass properties of the object scaled by `factor` about the origin.
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            volume: self.volume * factor.powi(3),
            center: self.center * factor,
            inertia: self.inertia * factor.powi(5),
        }
    }
}
