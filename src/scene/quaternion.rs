//! Order of the components of a quaternion in a file.

use serde::{Deserialize, Serialize};

/// Order of the components of a quaternion; w is the real part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename = "quaternion")]
pub enum QuaternionOrder {
    /// Real part first: Eigen's constructor, MuJoCo, DefGraspSim.
    Wxyz,
    /// Real part last: ROS, SciPy, PyBullet, Isaac Gym.
    Xyzw,
}
