//! Number types that validate their value during deserialisation.
//!
//! RON reports the parser's position when a value is refused. A check inside the leaf type therefore points at the
//! number itself; a check of the whole struct could only point at its closing parenthesis. The first line of a refusal
//! is the message; the others become the `help:` of the printed error.

use base::number::format_number;
use serde::de::{Deserialize, Deserializer, Error as _, Unexpected, Visitor};
use serde::{Serialize, Serializer};

/// Largest length allowed in a scene, m: a gripper scene in metres never needs more.
pub const MAX_LENGTH: f64 = 2.0;
/// Smallest side of a pad, m: far below any real gel. Step sizes towards an object scale with the size of the pad.
pub const MIN_PAD_SIDE: f64 = 1e-5;
/// Smallest stiffness allowed in a scene, Pa: a smaller number was most likely meant in MPa.
pub const MIN_MODULUS: f64 = 1.0;
/// Longest time allowed in a scene, s.
pub const MAX_TIME: f64 = 1000.0;
/// Largest ratio of cell sizes within a pad.
pub const MAX_CELL_RATIO: f64 = 20.0;

macro_rules! number {
    ($(#[$doc:meta])* $name:ident, $check:path) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
        pub struct $name(f64);

        impl $name {
            /// Returns the value if it is allowed.
            ///
            /// # Errors
            /// Fails if the value is not allowed, with the message for a scene file.
            pub fn new(value: f64) -> Result<Self, String> {
                finite(value)?;
                $check(value).map(|()| Self(value))
            }
            /// Returns the number.
            pub const fn get(self) -> f64 {
                self.0
            }
            /// Creates a default without a check; a test checks all defaults.
            #[allow(dead_code)]
            pub const fn new_unchecked(value: f64) -> Self {
                Self(value)
            }
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_f64(self.0)
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                Self::new(f64::deserialize(deserializer)?).map_err(D::Error::custom)
            }
        }
    };
}

number! {
    /// Finite number (RON itself also reads `inf` and `NaN`).
    Finite, anything
}
number! {
    /// Finite number above zero.
    Positive, positive
}
number! {
    /// Finite number, zero or above.
    NonNegative, non_negative
}
number! {
    /// Length above zero and at most [`MAX_LENGTH`], m.
    Length, length
}
number! {
    /// Length from zero to [`MAX_LENGTH`], m.
    Depth, depth
}
number! {
    /// Stiffness, Pa; at least [`MIN_MODULUS`].
    Modulus, modulus
}
number! {
    /// Poisson's ratio: above -1 and below 0.5.
    Poisson, poisson
}
number! {
    /// Fraction above zero and at most one.
    Fraction, fraction
}
number! {
    /// Time above zero and at most [`MAX_TIME`], s.
    Seconds, seconds
}
number! {
    /// Ratio from one to [`MAX_CELL_RATIO`].
    Ratio, ratio
}

fn finite(v: f64) -> Result<(), String> {
    if v.is_finite() { Ok(()) } else { Err(format!("must be a finite number, found {}", format_number(v))) }
}
fn anything(_: f64) -> Result<(), String> {
    Ok(())
}
fn positive(v: f64) -> Result<(), String> {
    if v > 0.0 { Ok(()) } else { Err(format!("must be above zero, found {}", format_number(v))) }
}
fn non_negative(v: f64) -> Result<(), String> {
    if v >= 0.0 { Ok(()) } else { Err(format!("must be zero or above, found {}", format_number(v))) }
}
fn not_millimetres(v: f64) -> Result<(), String> {
    if v <= MAX_LENGTH {
        return Ok(());
    }
    Err(format!(
        "must be at most {MAX_LENGTH} m, found {}\nlengths are in metres: {} mm is {}",
        format_number(v),
        format_number(v),
        format_number(v * 1e-3)
    ))
}
fn length(v: f64) -> Result<(), String> {
    positive(v).and_then(|()| not_millimetres(v))
}
fn depth(v: f64) -> Result<(), String> {
    non_negative(v).and_then(|()| not_millimetres(v))
}
fn modulus(v: f64) -> Result<(), String> {
    positive(v)?;
    if v >= MIN_MODULUS {
        return Ok(());
    }
    Err(format!(
        "must be at least {MIN_MODULUS} Pa, found {}\nstiffness is in pascals: {} MPa is {}",
        format_number(v),
        format_number(v),
        format_number(v * 1e6)
    ))
}
fn poisson(v: f64) -> Result<(), String> {
    if v > -1.0 && v < 0.5 {
        return Ok(());
    }
    let mut message = format!("Poisson's ratio must be above -1 and below 0.5, found {}", format_number(v));
    if v >= 0.5 {
        message.push_str(
            "\n0.5 is exactly incompressible and has no finite stiffness; use 0.49 (mean dilatation handles up to 0.499)",
        );
    }
    Err(message)
}
fn fraction(v: f64) -> Result<(), String> {
    if v > 0.0 && v <= 1.0 { Ok(()) } else { Err(format!("must be above 0 and at most 1, found {}", format_number(v))) }
}
fn seconds(v: f64) -> Result<(), String> {
    positive(v)?;
    if v <= MAX_TIME {
        return Ok(());
    }
    Err(format!(
        "must be at most {MAX_TIME} s, found {}\ntimes are in seconds: {} ms is {}",
        format_number(v),
        format_number(v),
        format_number(v * 1e-3)
    ))
}
fn ratio(v: f64) -> Result<(), String> {
    if (1.0..=MAX_CELL_RATIO).contains(&v) {
        return Ok(());
    }
    Err(format!("must be from 1 to {MAX_CELL_RATIO}, found {}", format_number(v)))
}

/// Whole number from `MIN` to `MAX`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Count<const MIN: u64, const MAX: u64>(u64);

impl<const MIN: u64, const MAX: u64> Count<MIN, MAX> {
    /// Returns the value if it is allowed.
    ///
    /// # Errors
    /// Fails if the value is not allowed, with the message for a scene file.
    pub fn new(value: u64) -> Result<Self, String> {
        if (MIN..=MAX).contains(&value) {
            return Ok(Self(value));
        }
        Err(format!("must be a whole number from {MIN} to {MAX}, found {value}"))
    }
    /// Returns the number.
    pub const fn get(self) -> usize {
        self.0 as usize
    }
    /// Creates a default without a check; a test checks all defaults.
    pub const fn new_unchecked(value: u64) -> Self {
        Self(value)
    }
}

impl<const MIN: u64, const MAX: u64> Serialize for Count<MIN, MAX> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u64(self.0)
    }
}

impl<'de, const MIN: u64, const MAX: u64> Deserialize<'de> for Count<MIN, MAX> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        // `deserialize_any` passes 2.5 and -3 to the visitor as numbers, so that the message can quote them; otherwise
        // the parser reports an unexpected comma or digit.
        deserializer.deserialize_any(CountVisitor::<MIN, MAX>)
    }
}

struct CountVisitor<const MIN: u64, const MAX: u64>;

impl<const MIN: u64, const MAX: u64> Visitor<'_> for CountVisitor<MIN, MAX> {
    type Value = Count<MIN, MAX>;
    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "a whole number from {MIN} to {MAX}")
    }
    fn visit_u64<E: serde::de::Error>(self, v: u64) -> Result<Self::Value, E> {
        Count::new(v).map_err(E::custom)
    }
    fn visit_i64<E: serde::de::Error>(self, v: i64) -> Result<Self::Value, E> {
        u64::try_from(v)
            .map_err(|_| E::invalid_value(Unexpected::Other(&format!("`{v}`")), &self))
            .and_then(|v| self.visit_u64(v))
    }
    fn visit_f64<E: serde::de::Error>(self, v: f64) -> Result<Self::Value, E> {
        Err(E::invalid_value(Unexpected::Other(&format!("`{}`", format_number(v))), &self))
    }
}
