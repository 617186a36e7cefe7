//! The master's side of a PPO drive: clients without I/O for the parameter channel and for the control words.
//!
//! A client is fed each input image and gives the words of each output image. It knows no bus, no port and no clock,
//! so it runs over profirust (`profidrive::master`), any other DP master, or a PLC's process image.
//!
//! | file | holds |
//! | --- | --- |
//! | `acyclic` | [`AcyclicClient`]: records, alarms and connections of a slave of DP-V1 |
//! | `parameters` | [`ParameterRequest`]: parameters by record 47 |
//! | `course` | the way to a goal as a table: words to write, bits to expect; for all three clients |
//! | `pkw` | [`PkwClient`]: one job of the parameter channel at a time, held until its own reply |
//! | [`node`] | [`NodeClient`]: the same end of a drive on CANopen |
//! | `ppo` | [`PpoClient`]: a drive with variable speed of PROFIDRIVE version 2, the same way |
//! | `drive` | [`DriveClient`]: enable, move to, jog and the like as goals, with the reasons if the drive refuses |

mod acyclic;
mod course;
mod drive;
pub mod node;
mod parameters;
mod pkw;
mod ppo;

pub use acyclic::{AcyclicAnswer, AcyclicClient, AcyclicError, Heard, NotAsked, ToSend};
pub use drive::{
    Ag03Channel, DriveClient, Findings, Goal, GoalError, GoalOutcome, Limits, Obstacle, Obstacles, Why,
};
pub(crate) use node::NodeSigns;
pub use node::{NodeClient, NodeGoal, NodeLimits, NodeOutcome, NodeTrouble};
pub use parameters::{NoResponse, ParameterRefused, ParameterRequest};
pub use pkw::{
    ArrayJobs, ErrorCode, Images, Job, Limit, Memory, NotSubmitted, Outcome, PkwClient, PkwError, Profile,
    Reply, Stage, SubindexPlace, WriteReply,
};
pub use ppo::{PpoClient, PpoGoal, PpoGoalError, PpoLimits, PpoOutcome};
