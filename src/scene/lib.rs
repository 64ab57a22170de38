//! Scene files: the schema, one file per topic, and the loader.
//!
//! `load("scene.ron")` returns a complete [`Scene`]: includes merged, defaults filled in, paths resolved, all values
//! checked.
//!
//! ```text
//! text -> outline (where is what) --+
//!      -> ron + leaf checks ---------+-> lint -> merge includes -> complete -> check across fields -> Scene
//!                    any refusal -> diagnose: message, file:line:column, caret, what is allowed
//! ```

mod axis;
pub mod bonding;
mod check;
pub mod convention;
pub mod defaults;
mod diagnose;
pub mod dialect;
pub mod dynamic;
mod either;
mod excerpt;
pub mod expect;
mod field_positions;
pub mod grasps;
pub mod gripper;
pub mod ground;
mod include;
pub mod leaf;
mod lint;
pub mod load;
pub mod loading;
pub mod material;
pub mod motion;
pub mod object;
pub mod objects;
pub mod observation;
mod outline;
pub mod output;
pub mod overrides;
pub mod pad;
mod paths;
mod quaternion;
pub mod reward;
pub mod robot;
pub mod rotation;
mod schema;
mod source;
mod span;
pub mod stepper;
pub mod task;
pub mod universe;
pub mod vector;

pub use convention::{Convention, HandAxis, QuaternionOrder};
pub use dialect::{from_json, from_ron, recheck, to_ron};
pub use dynamic::Dynamic;
pub use expect::Expectation;
pub use grasps::{Antipodal, GraspCount, GraspFile, Grasps, ListedPose, Select};
pub use gripper::{Fingers, Gripper, Placement, RightFinger, Robot, RobotNotice};
pub use ground::Ground;
pub use load::{Loaded, LoadedSet, load, load_object, load_seeded, load_set, locate_error_in};
pub use loading::{Loading, Press, Squeeze};
pub use material::{Law, MaterialChoice, MaterialSpec, Preset};
pub use object::{Object, ObjectMotion, ObjectShape};
pub use objects::{Name, Split};
pub use observation::{Grid, Markers, Observe};
pub use output::{Arrays, Field, Record};
pub use overrides::{Backend, Overrides};
pub use pad::Pads;
pub use reward::Reward;
pub use schema::{NamedScene, Scene};
pub use source::MAX_TOTAL_SIZE;
pub use stepper::{Condensed, Element, Fem, FinerMesh, Gnn, Solver, StepperChoice, Tolerance};
pub use task::Task;
pub use universe::Universe;
