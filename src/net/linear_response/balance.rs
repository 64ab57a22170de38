//! Balance of a free object: forces and moments of both pads on it balance the load on it.
//!
//! Two forces on a body without load are collinear. The positions at which the pads press therefore determine the
//! tangential force of each, which causes most of the shear of a pad. The pressure is unchanged: each pad gets a force
//! along x, a force along y and a twist, distributed over its nodes in proportion to the projected contact forces. Of
//! those that balance, the smallest are taken (least squares over the pressure). Small contacts resist little rotation
//! about the closing direction: this equation is relaxed.
//!
//! Quantities are dimensionless, in hand axes, as in [`super::rigid_equilibrium`].

use crate::matrix::Number;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use geometry::Wrench;
use glam::{DMat3, DVec2, DVec3};

/// Number of equations of balance, equal to the number of pulls and twists of two pads.
pub const EQUATIONS: usize = 6;
/// Regularisation of the balance, over its largest stiffness: along the closing direction the forces of the fingers are
/// unchanged.
const SLACK: f64 = 1e-7;
/// Radius of gyration of a contact, over the thickness, below which it hardly resists a twist: near a point contact,
/// the forces that balance a twist about the closing direction would be unbounded.
const POINT: f64 = 0.3;
/// Index of that twist among the equations: fingers close along x.
const TWIST: usize = 3;

/// Pad under a load.
#[derive(Debug, Clone)]
pub struct PadLoad {
    /// Force with which it presses.
    pub force: f64,
    /// Rotation from its axes to those of the hand.
    pub rotation: DMat3,
    /// Point of application of the force of each face node, and the fraction of the force that the projected contact
    /// carries there.
    pub nodes: Vec<(DVec3, f64)>,
}

impl PadLoad {
    /// Returns the modes of each node: its fraction of a pull along x or y, and of a twist (x and y of its arm over the
    /// radius of gyration).
    fn modes(&self) -> Vec<[f64; 3]> {
        let whole = self.nodes.iter().map(|n| n.1).sum::<f64>().max(f64::MIN_POSITIVE);
        let at = |place: DVec3| (self.rotation.transpose() * place).truncate();
        let middle = self.nodes.iter().map(|n| at(n.0) * (n.1 / whole)).sum::<DVec2>();
        let square = self.nodes.iter().map(|n| at(n.0).distance_squared(middle) * (n.1 / whole)).sum::<f64>();
        let arm = |place: DVec3| (at(place) - middle) / square.sqrt().max(SLACK);
        let mode = |n: &(DVec3, f64)| {
            let twist = arm(n.0) * (n.1 / whole);
            [n.1 / whole, twist.x, twist.y]
        };
        self.nodes.iter().map(mode).collect()
    }
}

/// Balance of an object between two pads under one load.
#[derive(Debug, Clone)]
pub struct ObjectBalance {
    /// Force of a unit of each component of contact, for each pad (against the closing direction, along x, along y).
    axes: [[[f32; 3]; 3]; 2],
    /// Point of application of the force of each node, pad by pad.
    place: Vec<[f32; 3]>,
    /// Modes of each node, see [`PadLoad::modes`].
    modes: Vec<[f32; 3]>,
    /// Map from the imbalance to pulls and twists.
    inverse: [[f32; EQUATIONS]; EQUATIONS],
    /// Force and moment that the pads carry.
    load: [f32; EQUATIONS],
}

impl ObjectBalance {
    /// Creates the balance between `pads`; `pull` is the force and moment of the other loads on the object, about the
    /// origin.
    pub fn new(pads: &[PadLoad; 2], pull: Wrench) -> Self {
        let axes = pads.each_ref().map(|pad| {
            let [x, y, z] =
                [pad.rotation.x_axis, pad.rotation.y_axis, pad.rotation.z_axis].map(|axis| axis * pad.force);
            [-z, x, y]
        });
        let modes: Vec<[f64; 3]> = pads.iter().flat_map(PadLoad::modes).collect();
        let place: Vec<DVec3> = pads.iter().flat_map(|pad| pad.nodes.iter().map(|n| n.0)).collect();
        // Force and moment per unit of each pull and twist.
        let mut given = Mat::<f64>::zeros(EQUATIONS, EQUATIONS);
        for (i, (mode, at)) in modes.iter().zip(&place).enumerate() {
            let pad = i / pads[0].nodes.len();
            for (force, mode) in axes[pad][1..].iter().zip(tangential_contributions(mode)) {
                for (k, w) in wrench(*force, *at).iter().enumerate() {
                    (0..3).for_each(|m| given[(k, 3 * pad + m)] += w * mode[m]);
                }
            }
        }
        let mut square = &given * given.transpose();
        let small = SLACK * (0..EQUATIONS).map(|k| square[(k, k)]).fold(f64::MIN_POSITIVE, f64::max);
        (0..EQUATIONS).for_each(|k| square[(k, k)] += small);
        square[(TWIST, TWIST)] += (POINT * pads[0].force.max(pads[1].force)).powi(2);
        let solved = square.llt(Side::Lower).map(|factor| factor.solve(&given));
        // A failed factorisation yields numbers that are not finite, which the caller detects.
        let solved = solved.unwrap_or_else(|_| Mat::full(EQUATIONS, EQUATIONS, f64::NAN));
        Self {
            axes: axes.map(|pad| pad.map(|axis| axis.to_array().map(|v| v as f32))),
            place: place.iter().map(|x| x.to_array().map(|v| v as f32)).collect(),
            modes: modes.iter().map(|m| m.map(|v| v as f32)).collect(),
            inverse: std::array::from_fn(|m| std::array::from_fn(|k| solved[(k, m)] as f32)),
            load: std::array::from_fn(|k| pull.row()[k] as f32),
        }
    }

    /// Returns the balance of an object that is held fixed: its support carries the imbalance of the pads.
    pub fn supported(self) -> Self {
        Self { inverse: [[0.0; EQUATIONS]; EQUATIONS], ..self }
    }

    /// Returns the number of contact forces: nodes of both pads.
    pub fn nodes(&self) -> usize {
        self.place.len()
    }

    /// Returns the force and moment per unit of each component of contact at node `i`.
    pub fn wrenches(&self, i: usize) -> [[f32; EQUATIONS]; 3] {
        let [x, y, z] = self.place[i];
        self.axes[self.pad(i)].map(|[a, b, c]| [a, b, c, y * c - z * b, z * a - x * c, x * b - y * a])
    }

    /// Returns the contributions per unit of each pull and twist along x and y at node `i`: [`EQUATIONS`] each.
    pub fn correction_contributions(&self, i: usize) -> [[f32; EQUATIONS]; 2] {
        let mut all = [[0.0; EQUATIONS]; 2];
        for (all, own) in all.iter_mut().zip(tangential_contributions(&self.modes[i])) {
            all[3 * self.pad(i)..][..3].copy_from_slice(&own);
        }
        all
    }

    /// Returns the map from the imbalance to pulls and twists, and the load that is carried.
    pub fn correction_map(&self) -> (&[[f32; EQUATIONS]; EQUATIONS], &[f32; EQUATIONS]) {
        (&self.inverse, &self.load)
    }

    fn pad(&self, i: usize) -> usize {
        i / (self.place.len() / 2).max(1)
    }

    /// Balances `contact`, (nodes, 3), whose components along x and y have the signs `mirror` of those of the pads.
    pub fn balance<T: Number>(&self, contact: &mut [T], mirror: [f32; 2]) {
        let [x, y] = mirror.map(T::from);
        let mut left = self.load.map(T::from);
        for (i, c) in contact.as_chunks::<3>().0.iter().enumerate() {
            for (wrench, c) in self.wrenches(i).iter().zip([c[0], x * c[1], y * c[2]]) {
                left.iter_mut().zip(wrench).for_each(|(left, w)| *left += -(T::from(*w) * c));
            }
        }
        let pulls = self.inverse.map(|row| row.iter().zip(&left).map(|(k, v)| T::from(*k) * *v).sum::<T>());
        for (i, c) in contact.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            let own = &pulls[3 * self.pad(i)..][..3];
            let [along_x, along_y] = tangential_contributions(&self.modes[i])
                .map(|mode| mode.iter().zip(own).map(|(m, p)| T::from(*m) * *p).sum::<T>());
            c[1] += x * along_x;
            c[2] += y * along_y;
        }
    }

    /// Converts the gradient with respect to the output of [`Self::balance`] into that with respect to its input, in
    /// place.
    pub fn gradient<T: Number>(&self, gradient: &mut [T], mirror: [f32; 2]) {
        let [x, y] = mirror.map(T::from);
        let mut pulls = [T::from(0.0); EQUATIONS];
        for (i, g) in gradient.as_chunks::<3>().0.iter().enumerate() {
            let own = &mut pulls[3 * self.pad(i)..][..3];
            for (mode, g) in tangential_contributions(&self.modes[i]).iter().zip([x * g[1], y * g[2]]) {
                own.iter_mut().zip(mode).for_each(|(p, m)| *p += T::from(*m) * g);
            }
        }
        let left: [T; EQUATIONS] =
            std::array::from_fn(|k| self.inverse.iter().zip(&pulls).map(|(row, p)| T::from(row[k]) * *p).sum::<T>());
        for (i, g) in gradient.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            let by = self.wrenches(i).map(|wrench| wrench.iter().zip(&left).map(|(w, v)| T::from(*w) * *v).sum::<T>());
            g[0] += -by[0];
            g[1] += -(x * by[1]);
            g[2] += -(y * by[2]);
        }
    }
}

/// Returns the force and moment of a force at a point.
fn wrench(force: DVec3, at: DVec3) -> [f64; EQUATIONS] {
    Wrench { force, torque: at.cross(force) }.row()
}

/// Returns the contributions of the pulls along x and y and the twist of a pad, along x and y, at a node with these
/// modes.
fn tangential_contributions<T: Copy + Default + std::ops::Neg<Output = T>>([fraction, x, y]: &[T; 3]) -> [[T; 3]; 2] {
    [[*fraction, T::default(), -*y], [T::default(), *fraction, *x]]
}
