//! Why a PKW job was not executed, in words: the cause with the name and the unit of the parameter, and what to send.

use core::fmt;

use crate::devices::ag03::param::{Entry, Model, Parameter, Pnu, Unit, entry};
use crate::profibus::pkw;
use crate::profibus::pkw::JobError;
use crate::profibus::ppo::{JobId, Pke, Pkw};

/// A refused job in one line: the job, the parameter, the error number, the cause, what to send instead.
pub(super) struct Job<'a>(pub(super) &'a pkw::Refusal);

/// Why a job was refused and what to send instead ([`Device`](super::Device) and decoder say the same).
#[derive(Clone, Copy, Debug)]
pub(crate) struct JobText {
    /// The job as the master sent it.
    pub job: Pkw,
    /// What is wrong with it.
    pub cause: JobError,
}

impl fmt::Display for Job<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pkw::Refusal { job, number, cause, .. } = *self.0;
        write!(f, "job {job} ({}, PNU {}", job.pke.job(), job.pke.pnu())?;
        if let Some(entry) = known(job) {
            write!(f, " {}", entry.name)?;
        }
        write!(f, ") refused with {number}: {}", JobText { job, cause })
    }
}

impl fmt::Display for JobText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { job, cause } = *self;
        cause.fmt(f)?;
        let pnu = job.pke.pnu();
        let with = |id: JobId| With { id, pnu };
        match cause {
            JobError::OutOfRange { .. } => match known(job) {
                Some(entry) => Values(entry).fmt(f),
                None => Ok(()),
            },
            JobError::WrongWidth { expected, .. } => {
                let id = match expected {
                    pkw::Width::Word => JobId::WriteWord,
                    pkw::Width::Double => JobId::WriteDoubleWord,
                };
                write!(f, "; {}", with(id))
            }
            JobError::NotAnArray => match job.pke.job() {
                JobId::ReadElement | JobId::ReadElementCount => write!(f, "; {}", with(JobId::Read)),
                JobId::WriteElementWord => write!(f, "; {}", with(JobId::WriteWord)),
                JobId::WriteElementDoubleWord => write!(f, "; {}", with(JobId::WriteDoubleWord)),
                JobId::NoJob
                | JobId::Read
                | JobId::WriteWord
                | JobId::WriteDoubleWord
                | JobId::ReadDescription
                | JobId::WriteDescription
                | JobId::Reserved(_) => Ok(()),
            },
            JobError::IsArray { .. } => write!(f, "; {}", with(JobId::ReadElement)),
            // Somebody who writes no value wants to read: some texts call job 7 "read array".
            JobError::ReadOnly if job.double_word() == 0 => match job.pke.job() {
                JobId::WriteElementWord | JobId::WriteElementDoubleWord => {
                    write!(
                        f,
                        ". Job {} writes; to read an element {}",
                        job.pke.ak(),
                        with(JobId::ReadElement)
                    )
                }
                JobId::WriteWord | JobId::WriteDoubleWord => write!(f, "; to read it {}", with(JobId::Read)),
                JobId::NoJob
                | JobId::Read
                | JobId::ReadDescription
                | JobId::WriteDescription
                | JobId::ReadElement
                | JobId::ReadElementCount
                | JobId::Reserved(_) => Ok(()),
            },
            JobError::UnknownJob(_) => {
                f.write_str(
                    ". The highest job is 9 here; some manufacturers use 11 to 14 (write with, or without, EEPROM)",
                )?;
                Exchanged(job).fmt(f)
            }
            JobError::UnknownParameter { got } => {
                if let Some(entry) = entry(Model::Ag03_1, Pnu::from_low_bits(got)) {
                    return write!(f, " in an AG03; the AG03/1 has it ({})", entry.name);
                }
                Near(got).fmt(f)?;
                Exchanged(job).fmt(f)
            }
            JobError::NotNow(_) => {
                f.write_str("; write it again when the shaft stands and no job is active (ZSW.13 = 1)")
            }
            JobError::NotStored => {
                f.write_str("; write it again, and check the place where the images are kept")
            }
            JobError::NoPage { .. }
            | JobError::NamesNone { .. }
            | JobError::ReadOnly
            | JobError::SubindexOutOfRange { .. }
            | JobError::NoElement { .. }
            | JobError::Outside { .. }
            | JobError::NameTooLong
            | JobError::DescriptionTooLong
            | JobError::NoDescription
            | JobError::DescriptionReadOnly
            | JobError::WriteOnly
            | JobError::OnlyZero
            | JobError::NoRight => Ok(()),
        }
    }
}

fn known(job: Pkw) -> Option<&'static Entry> {
    let pnu = Pnu::from_low_bits(job.pke.pnu());
    [Model::Ag03_1, Model::Ag03].into_iter().find_map(|model| entry(model, pnu))
}

/// The parameters before and behind a number that is none, as the end of a sentence.
struct Near(u16);

impl fmt::Display for Near {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let entry = |number| entry(Model::Ag03_1, Pnu::from_low_bits(number));
        let (before, behind) = ((1..self.0).rev().find_map(entry), (self.0..1 << 11).find_map(entry));
        for (place, entry) in before.into_iter().chain(behind).enumerate() {
            let gap = if place == 0 { "; near it:" } else { "," };
            write!(f, "{gap} {} {}", entry.pnu, entry.name)?;
        }
        Ok(())
    }
}

/// What a job would be with the octets of PKE exchanged, as the end of a sentence; nothing if that is no job either.
struct Exchanged(Pkw);

impl fmt::Display for Exchanged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pke = Pke::from_raw(self.0.pke.raw().swap_bytes());
        let meant = Pkw { pke, ..self.0 };
        match (pke.job(), known(meant)) {
            (JobId::NoJob | JobId::Reserved(_), _) | (_, None) => Ok(()),
            (job, Some(entry)) => write!(
                f,
                "; the octets of PKE seem to be exchanged: {:04X} is {job}, PNU {} {}; send the high octet first",
                pke.raw(),
                pke.pnu(),
                entry.name
            ),
        }
    }
}

/// Which job to use.
struct With {
    id: JobId,
    pnu: u16,
}

impl fmt::Display for With {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { id, pnu } = self;
        write!(f, "use job {}, {id}: PKE {:04X}", id.ak(), Pke::of_job(*id, *pnu).raw())
    }
}

/// What the values of a parameter count or mean, as the end of a sentence.
pub(crate) struct Values(pub(crate) &'static Entry);

impl fmt::Display for Values {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.unit {
            Unit::Choice(choices) => choices.iter().enumerate().try_for_each(|(place, (number, meaning))| {
                write!(f, "{} {number} = {meaning}", if place == 0 { ";" } else { "," })
            }),
            Unit::None | Unit::Bits | Unit::Ascii | Unit::Version | Unit::Date => Ok(()),
            unit @ (Unit::Percent
            | Unit::PercentOfAcceleration
            | Unit::Rpm
            | Unit::Increments
            | Unit::Milliamperes) => write!(f, " {unit}"),
            // What they count depends on another parameter.
            unit @ (Unit::Position | Unit::Window) => {
                write!(
                    f,
                    ", counted in {unit}: mm if the spindle pitch is not 0 (PNU {})",
                    Parameter::SpindlePitch.entry().pnu
                )
            }
            // A number stands before the unit.
            unit @ (Unit::SpindlePitch | Unit::TenthDegrees | Unit::TenthVolts | Unit::HundredthVolts) => {
                write!(f, ", counted in {unit}")
            }
        }
    }
}
