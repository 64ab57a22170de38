//! Objects, pads and loads drawn at random, for data sets from which a network for arbitrary objects learns. An
//! alternative to `objects`.
//!
//! Each object has its own friction and loads, and one of a limited number of sensors (pads with their gel), because a
//! network computes the response of each sensor once. All values follow from the seed and the index of the object: a
//! data set begins with the objects of any smaller data set of the same seed.

mod draws;
mod pad;
mod shape;

use super::defaults;
use super::grasps::{Antipodal, Grasps};
use super::gripper::{Fingers, Gripper};
use super::leaf::{Count, NonNegative, Positive};
use super::loading::{Loading, ObjectPush, Squeeze};
use super::object::{DroppedAfter, Object, ObjectMotion};
use super::objects::{Entry, Name};
use super::span::Span;
use super::vector::{Tuple, Vec3};
use base::random::Random;
use draws::{Draws, round_for_text};
use serde::{Deserialize, Serialize};

pub use pad::PadSpans;
pub use shape::Family;

/// Objects, pads and loads drawn at random. Fractions are from 0 to 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Universe {
    /// Number of objects.
    pub objects: Count<1, 10000>,
    /// Number of grasps of each object.
    pub grasps: Count<1, 1000>,
    /// Seed; the same seed gives the same objects.
    pub seed: u64,
    /// Number of different sensors (pads with their gel).
    pub sensors: Count<1, 10000>,
    /// Families of shapes, used equally often.
    pub families: Vec<Family>,
    /// Range of the object width over the pad thickness, log-uniform; the width is limited to half of the gripper's
    /// opening.
    pub size: Span,
    /// Range of the coefficient of friction, uniform.
    pub friction: Span,
    /// Range of Poisson's ratio nu of the gel; 0.5 - nu is log-uniform, because it determines the compressibility.
    pub poisson: Span,
    /// Pads.
    pub pads: PadSpans,
    /// Range of the final force per finger over E t^2, with Young's modulus E and pad thickness t, uniform.
    pub force: Span,
    /// Range of the force per finger over E t^2 at which an object without weight is released, log-uniform. An object
    /// with weight is released as soon as friction can hold it.
    pub release: Span,
    /// Fraction of the objects, of families with faces or axes, that are grasped perpendicular to the faces or axes.
    pub square: NonNegative,
    /// Largest offset of the pads from the contacts, over half of the length and width of the pads; each object has its
    /// own largest offset, uniform up to this one.
    pub offset: NonNegative,
    /// Fraction of the objects with weight, in a random direction.
    pub heavy: NonNegative,
    /// Largest weight over the final sum of the finger forces; limited to two fifths of the friction limit.
    pub weight: Positive,
    /// Fraction of the objects to which a push and a torque are applied after the squeeze, in two fifths of the frames.
    pub pushed: NonNegative,
    /// Range of the final push and torque over the friction limit, approximately, uniform.
    pub push: Span,
    /// Fraction of the objects that are fixed and pressed by one finger.
    pub single: NonNegative,
}

impl Default for Universe {
    fn default() -> Self {
        Self {
            objects: defaults::UNIVERSE_OBJECTS,
            grasps: defaults::UNIVERSE_GRASPS,
            seed: 0,
            sensors: defaults::UNIVERSE_SENSORS,
            families: Family::ALL.to_vec(),
            size: defaults::UNIVERSE_SIZE,
            friction: defaults::UNIVERSE_FRICTION,
            poisson: defaults::UNIVERSE_POISSON,
            pads: PadSpans::default(),
            force: defaults::UNIVERSE_FORCE,
            release: defaults::UNIVERSE_RELEASE,
            square: defaults::UNIVERSE_SQUARE,
            offset: defaults::UNIVERSE_OFFSET,
            heavy: defaults::UNIVERSE_HEAVY,
            weight: defaults::UNIVERSE_WEIGHT,
            pushed: defaults::UNIVERSE_PUSHED,
            push: defaults::UNIVERSE_PUSH,
            single: defaults::UNIVERSE_SINGLE,
        }
    }
}

/// Standard gravity, by which weights are converted to densities, m/s2.
const GRAVITY: f64 = 9.81;
/// Largest weight over the friction limit: at the final force, and at the force at which the object is released.
const WEIGHT_LIMITS: [f64; 2] = [0.4, 0.45];
/// Fraction of the frames that belong to the push.
const PUSH_FRAMES: f64 = 0.4;
/// Friction limit of the torque about the closing direction over the friction limit of the force and the pad thickness:
/// that of a circular contact with a radius of 0.6 thicknesses under uniform pressure.
const TORQUE_RATIO: f64 = 0.4;
/// Largest width of an object over the opening of the gripper.
const WIDEST: f64 = 0.5;
/// Largest angle between the closing axis and the normals in perpendicular grasps, degrees.
const PERPENDICULAR_TILT_DEG: f64 = 1e-3;

/// Streams of random numbers for objects and for sensors.
const OBJECTS: u64 = 0;
const SENSORS: u64 = 1;

impl Universe {
    /// Returns the first invalid field, with the message for the user.
    pub(super) fn problem(&self) -> Option<(String, String)> {
        let pads = &self.pads;
        let spans = [
            ("size", &self.size),
            ("friction", &self.friction),
            ("poisson", &self.poisson),
            ("force", &self.force),
            ("release", &self.release),
            ("push", &self.push),
            ("pads.length", &pads.length),
            ("pads.width", &pads.width),
            ("pads.thickness", &pads.thickness),
            ("pads.cells", &pads.cells),
        ];
        let field = |name: &str, message: &str| Some((format!("universe.{name}"), message.to_string()));
        if let Some((name, _)) = spans.iter().find(|(_, s)| s.0[0].get() > s.0[1].get()) {
            return field(name, "the first number is the minimum, the second the maximum: (1, 10)");
        }
        if self.poisson.0[1].get() >= 0.5 {
            return field("poisson", "a gel has a Poisson's ratio below 0.5");
        }
        if self.families.is_empty() {
            return field("families", "an empty list of families\nleave it out for all of them");
        }
        let parts = [("square", self.square), ("heavy", self.heavy), ("pushed", self.pushed), ("single", self.single)];
        let parts = parts.into_iter().chain([("pads.round", pads.round), ("pads.domed", pads.domed)]);
        let above = parts.clone().find(|(_, part)| part.get() > 1.0);
        above.and_then(|(name, _)| field(name, "a fraction of the objects\nallowed: 0 to 1"))
    }

    /// Returns the objects with their grasps, grippers and loads. Everything that is not drawn is taken from `gripper`;
    /// the number of frames is that of `squeeze`.
    pub(super) fn entries(&self, gripper: &Gripper, squeeze: &Squeeze) -> Vec<Entry> {
        (0..self.objects.get()).map(|i| self.entry(i, gripper, squeeze)).collect()
    }

    /// Returns the random numbers for item `index` of a stream.
    fn draws(&self, stream: u64, index: usize) -> Draws {
        let words = [self.seed, stream, index as u64];
        Draws(Random::new(words.into_iter().fold(0, |state, word| Random::new(state ^ word).next_u64())))
    }

    fn entry(&self, index: usize, gripper: &Gripper, squeeze: &Squeeze) -> Entry {
        let mut draws = self.draws(OBJECTS, index);
        let family = self.families[index % self.families.len()];
        // Sensors do not depend on the seed: data sets of several seeds share their sensors, whose responses are
        // computed once.
        let mut sensor = Self { seed: 0, ..self.clone() }.draws(SENSORS, draws.0.uniform_below(self.sensors.get()));
        let (pads, thickness) = self.pads.draw(&mut sensor);
        let [low, high] = [0, 1].map(|k| (0.5 - self.poisson.0[k].get()).ln());
        let poisson = round_for_text(0.5 - sensor.between(low, high).exp());
        let width = (draws.factor(&self.size) * thickness).min(WIDEST * gripper.opening.get());
        let (shape, volume) = family.draw(width, &mut draws);
        let segments = family.segments(&mut draws);
        let friction = round_for_text(draws.within(&self.friction));
        let spec = gripper.material.spec();
        let force = round_for_text(2.0 * draws.within(&self.force) * spec.young * thickness * thickness);
        let square = draws.is_in(self.square.get()) && family.has_faces();
        let tilt = if square { Positive::new_unchecked(PERPENDICULAR_TILT_DEG) } else { defaults::TILT };
        let offset = round_for_text(draws.between(0.0, self.offset.get()));
        let single = draws.is_in(self.single.get());
        let release =
            round_for_text((draws.factor(&self.release) * 2.0 * spec.young * thickness * thickness).min(force));
        let weight = self.weight.get().min(WEIGHT_LIMITS[0] * friction) * force * draws.between(0.05, 1.0);
        let heavy = draws.is_in(self.heavy.get() * f64::from(u8::from(!single))).then(|| {
            let first = Positive::new_unchecked(round_for_text(weight / (WEIGHT_LIMITS[1] * friction)));
            (weight / (GRAVITY * volume), first, direction(&mut draws))
        });
        let carried = if heavy.is_some() { weight } else { 0.0 };
        let (density, first, release) = heavy
            .map_or((defaults::OBJECT_DENSITY, None, release), |(density, first, _)| {
                (Positive::new_unchecked(round_for_text(density)), Some(first), first.get())
            });
        let pushed = draws.is_in(self.pushed.get() * f64::from(u8::from(!single)));
        let frames = squeeze.frames.get();
        let after = (PUSH_FRAMES * frames as f64).round() as usize;
        let push = (pushed && after > 0 && after < frames).then(|| {
            let holds = friction * force - carried;
            let (force, torque) = push(draws.within(&self.push), holds, thickness, &mut draws);
            ObjectPush { force, torque, frames: Count::new_unchecked(after as u64) }
        });
        let frames = if push.is_some() { Count::new_unchecked((frames - after) as u64) } else { squeeze.frames };
        Entry {
            name: Name::near(&format!("{}-{index:04}", family.name())),
            object: Object {
                shape,
                scale: None,
                repair: false,
                surface: None,
                dropped_after: DroppedAfter::default(),
                density,
                segments,
                motion: if single { ObjectMotion::Fixed } else { ObjectMotion::Free },
                velocity: None,
                spin: None,
            },
            grasps: Some(Grasps::Antipodal(Antipodal {
                count: Count::new_unchecked(self.grasps.get() as u64),
                seed: index as u64,
                tilt_deg: tilt,
                offset: NonNegative::new_unchecked(offset),
            })),
            gripper: Some(Gripper {
                pads,
                // `problem` has checked that the values are in the range of the material.
                material: gripper.material.with(spec.young, poisson).unwrap_or(gripper.material),
                friction: NonNegative::new_unchecked(friction),
                fingers: if single { Fingers::One } else { gripper.fingers },
                ..gripper.clone()
            }),
            loading: Some(Loading::Squeeze(Squeeze {
                // One finger carries the whole force, each of two fingers one half.
                force: Positive::new_unchecked(if single { 0.5 * force } else { force }),
                from: first,
                release: (!single).then(|| Positive::new_unchecked(release)),
                frames,
                push,
            })),
            gravity: heavy.map(|(.., direction)| direction),
        }
    }
}

/// Draws gravity with a direction uniform on the sphere, m/s2.
fn direction(draws: &mut Draws) -> Vec3 {
    let (z, angle) = (draws.between(-1.0, 1.0), draws.between(0.0, std::f64::consts::TAU));
    let r = (1.0 - z * z).max(0.0).sqrt();
    let along = [r * angle.cos(), r * angle.sin(), z];
    Tuple(along.map(|v| super::leaf::Finite::new_unchecked(round_for_text(GRAVITY * v))))
}

/// Draws the force, N, and torque, N m, of a push: a force perpendicular to the closing direction and a torque about
/// it, of the fraction `part` of the friction limit `holds` (N) between pads of a thickness, m (limit surface of Howe
/// and Cutkosky 1996), and a torque perpendicular to the closing direction.
fn push(part: f64, holds: f64, thickness: f64, draws: &mut Draws) -> (Vec3, Vec3) {
    let [across, kind, about] = [(); 3].map(|()| draws.between(0.0, std::f64::consts::TAU));
    let (force, torque) = (part * holds * kind.cos(), part * holds * TORQUE_RATIO * thickness);
    let tilt = torque * draws.between(0.0, 0.5);
    let vector = |v: [f64; 3]| Tuple(v.map(|v| super::leaf::Finite::new_unchecked(round_for_text(v))));
    (
        vector([0.0, force * across.cos(), force * across.sin()]),
        vector([torque * kind.sin(), tilt * about.cos(), tilt * about.sin()]),
    )
}
