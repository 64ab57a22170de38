//! Position and orientation of an element, in all forms of MJCF.

use crate::robot::xml::XmlElement;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// Attributes that specify an orientation.
pub(super) const ORIENTATIONS: [&str; 5] = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];

/// Settings of `<compiler>`.
#[derive(Debug, Clone)]
pub(super) struct Compiler {
    /// Flag: angles are in degrees.
    pub degrees: bool,
    /// Axes of the three Euler angles; lower case is intrinsic (body axes), upper case extrinsic (fixed axes).
    pub sequence: String,
    /// Flag: a joint with a range is limited.
    pub autolimits: bool,
}

impl Default for Compiler {
    fn default() -> Self {
        Self { degrees: true, sequence: "xyz".into(), autolimits: true }
    }
}

impl Compiler {
    /// Applies the settings of a `<compiler>`.
    ///
    /// # Errors
    /// Fails for global coordinates and for an invalid Euler sequence.
    pub fn add(&mut self, compiler: &XmlElement) -> Result<(), String> {
        if compiler.text("coordinate").is_some_and(|kind| kind != "local") {
            return Err(compiler
                .error("has global coordinates, which MuJoCo no longer supports; save the model with local ones"));
        }
        self.degrees = compiler.text("angle").map_or(self.degrees, |unit| unit != "radian");
        self.autolimits = compiler.text("autolimits").map_or(self.autolimits, |flag| flag == "true");
        if let Some(sequence) = compiler.text("eulerseq") {
            if sequence.len() != 3 || sequence.chars().any(|axis| !"xyzXYZ".contains(axis)) {
                return Err(compiler.error(format_args!("has eulerseq={sequence:?}; three of xyz or XYZ are needed")));
            }
            self.sequence = sequence.into();
        }
        Ok(())
    }

    /// Converts an angle of the attribute `name` to rad.
    pub fn angle(&self, element: &XmlElement, name: &str, angle: f64) -> Result<f64, String> {
        match self.degrees {
            true => Ok(angle.to_radians()),
            false => element.check_radians(name, &[angle]).map(|()| angle),
        }
    }

    /// Returns the transform from the axes of an element to those of its parent, m.
    ///
    /// # Errors
    /// Fails for an invalid position or orientation.
    pub fn pose(&self, element: &XmlElement) -> Result<DAffine3, String> {
        let mut position = element.numbers("pos")?.map(DVec3::from_array).unwrap_or_default();
        if let Some([a, b, c, d, e, f]) = element.numbers("fromto")? {
            position = 0.5 * DVec3::new(a + d, b + e, c + f);
        }
        let rotation = self.rotation(element)?;
        Ok(DAffine3::from_mat3_translation(rotation, position))
    }

    fn rotation(&self, element: &XmlElement) -> Result<DMat3, String> {
        let Some(form) = ORIENTATIONS.into_iter().find(|form| element.text(form).is_some()) else {
            return Ok(DMat3::IDENTITY);
        };
        let none = || element.error(format_args!("has a {form} of zero length"));
        let unit = |v: [f64; 3]| DVec3::from_array(v).try_normalize().ok_or_else(none);
        match form {
            "quat" => {
                let [w, x, y, z] = element.numbers(form)?.unwrap_or_default();
                let length = DQuat::from_xyzw(x, y, z, w).length();
                if length < f64::MIN_POSITIVE.sqrt() {
                    return Err(none());
                }
                Ok(DMat3::from_quat(DQuat::from_xyzw(x / length, y / length, z / length, w / length)))
            }
            "axisangle" => {
                let [x, y, z, angle] = element.numbers(form)?.unwrap_or_default();
                Ok(DMat3::from_axis_angle(unit([x, y, z])?, self.angle(element, form, angle)?))
            }
            "euler" => {
                let angles: [f64; 3] = element.numbers(form)?.unwrap_or_default();
                let mut rotation = DMat3::IDENTITY;
                for (angle, letter) in angles.into_iter().zip(self.sequence.chars()) {
                    let axis = match letter.to_ascii_lowercase() {
                        'x' => DVec3::X,
                        'y' => DVec3::Y,
                        _ => DVec3::Z,
                    };
                    let turn = DMat3::from_axis_angle(axis, self.angle(element, form, angle)?);
                    rotation = if letter.is_ascii_lowercase() { rotation * turn } else { turn * rotation };
                }
                Ok(rotation)
            }
            "xyaxes" => {
                let [a, b, c, d, e, f] = element.numbers(form)?.unwrap_or_default();
                let x = unit([a, b, c])?;
                let y = DVec3::new(d, e, f);
                let y = unit((y - x * x.dot(y)).to_array())?;
                Ok(DMat3::from_cols(x, y, x.cross(y)))
            }
            _ => {
                let z = unit(element.numbers(form)?.unwrap_or_default())?;
                let axis = DVec3::Z.cross(z);
                // Rotations by 0 and pi are about x.
                let turn = axis.try_normalize().unwrap_or(DVec3::X);
                Ok(DMat3::from_axis_angle(turn, axis.length().atan2(z.z)))
            }
        }
    }
}
