//! The parameter channel at work: jobs in, replies out (manual chapter 7.4.2; `ag03.md` 2).
//!
//! | file | holds |
//! | --- | --- |
//! | `engine` | [`Engine`]: takes the newest job once per application cycle, runs it once, keeps its reply |
//! | `table` | [`Parameters`]: what it asks of a device, a table of parameters |
//! | `code` | [`ErrorNumber`]: which number a refused job is answered with, and its text |
//!
//! ```
//! use profidrive::profibus::pkw::{Config, Engine, JobError, Parameters, Value, Written};
//! use profidrive::profibus::ppo::{Ind, JobId, Pke, Pkw};
//!
//! /// A device with one parameter, 100: a ramp time of 1 to 60 s.
//! struct Device {
//!     ramp: u16,
//! }
//!
//! impl Parameters for Device {
//!     fn elements(&self, pnu: u16) -> Result<Option<u8>, JobError> {
//!         if pnu == 100 { Ok(None) } else { Err(JobError::UnknownParameter { got: pnu }) }
//!     }
//!
//!     fn read(&self, pnu: u16, _: Option<u8>) -> Result<Value, JobError> {
//!         self.elements(pnu).map(|_| Value::Word(self.ramp))
//!     }
//!
//!     fn write(&mut self, pnu: u16, _: Option<u8>, value: Value) -> Result<Written, JobError> {
//!         self.elements(pnu)?;
//!         match value {
//!             Value::Word(ramp @ 1..=60) => self.ramp = ramp,
//!             other => return Err(JobError::OutOfRange { low: 1, high: 60, got: other.bits() as i32 }),
//!         }
//!         Ok(Written::at_once(value))
//!     }
//! }
//!
//! let mut device = Device { ramp: 10 };
//! let mut engine = Engine::new(Config::default());
//! let job = Pkw::new(Pke::of_job(JobId::WriteWord, 100), Ind::default(), 30);
//! assert_eq!(engine.cycle(job, &mut device).reply.to_string(), "1064 0000 0000 001E");
//! assert_eq!(device.ramp, 30);
//!
//! let job = Pkw::new(Pke::of_job(JobId::WriteWord, 100), Ind::default(), 61);
//! let outcome = engine.cycle(job, &mut device);
//! assert_eq!(outcome.reply.to_string(), "7064 0000 0000 0002");
//! assert_eq!(
//!     outcome.refusal.unwrap().to_string(),
//!     "job 2064 0000 0000 003D (write word, PNU 100) refused with error 2, value outside the limits: \
//!      the value must be within 1 to 60, got 61",
//! );
//! ```

mod code;
mod engine;
mod table;

pub use code::{ErrorNumber, JobError};
pub use engine::{Config, Engine, Outcome, Pages, Refusal, SubindexOctet};
pub use table::{Parameters, Value, Width, Written};
