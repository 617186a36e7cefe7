//! The parameter channel at work: jobs in, replies out (manual chapter 7.4.2; `ag03.md` 2).
//!
//! | file | holds |
//! | --- | --- |
//! | `engine` | [`Engine`]: takes the newest job once per application cycle, runs it once, keeps its reply |
//! | `code` | [`ErrorNumber`]: which number a refused job is answered with, and its text |
//!
//! ```
//! use profidrive::param::{Gear, Live, Model, Parameter, Store, WriteContext};
//! use profidrive::pkw::{Config, Engine};
//! use profidrive::ppo::{Ind, JobId, Pke, Pkw};
//!
//! let mut store = Store::new(Model::Ag03_1, Gear::Ratio48);
//! let mut engine = Engine::new(Config::default());
//! let (live, context) = (Live::default(), WriteContext::default());
//!
//! // Manual chapter 7.6.2: limit 1 (PNU 1016) shall be 250000.
//! let job = Pkw::new(Pke::of_job(JobId::WriteDoubleWord, 1016), Ind::default(), 250_000);
//! let outcome = engine.cycle(job, &mut store, &live, &context);
//! assert_eq!(outcome.reply.to_string(), "23F8 0000 0003 D090");
//! assert_eq!(store.value(Parameter::Limit1), 250_000);
//!
//! // 101 % acceleration is too much.
//! let job = Pkw::new(Pke::of_job(JobId::WriteWord, 1003), Ind::default(), 101);
//! let outcome = engine.cycle(job, &mut store, &live, &context);
//! assert_eq!(outcome.reply.to_string(), "73EB 0000 0000 0002");
//! assert_eq!(
//!     outcome.refusal.unwrap().to_string(),
//!     "job 23EB 0000 0000 0065 (write word, PNU 1003) refused with error 2, value outside the limits: \
//!      the value must be within 1 to 100, got 101",
//! );
//! ```

mod code;
mod engine;

pub use code::{ErrorNumber, JobError};
pub use engine::{Config, Engine, Outcome, Refusal, SubindexOctet};
