//! The command line: what may be asked for, and how a wrong question is answered.
#![allow(rustdoc::broken_intra_doc_links, reason = "comments here are help texts; `[,key=VALUE]` is no link")]

mod decode;
mod demo;
mod devices;
mod eds;
mod emulate;
mod encode;
mod gsd;
#[cfg(feature = "judge")]
mod judge;
#[cfg(feature = "judge")]
mod judged_device;
mod link;
#[cfg(feature = "manual")]
mod manual;
mod master;
mod master_link;
mod quantity;
mod records;
mod spec;
mod try_out;
#[cfg(not(feature = "judge"))]
mod unbuilt_judge;

use std::ffi::OsString;
use std::process::ExitCode;

use crate::gsd::did_you_mean;
use crate::host::list::Group;
pub(crate) use crate::host::list::named::{parameter as find_parameter, plain};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{ArgAction, CommandFactory, Parser, Subcommand};

use super::{Failure, report};

pub(crate) use decode::Decode;
pub(crate) use demo::Demo;
pub(crate) use devices::Devices;
pub(crate) use eds::{CheckFile, Eds, Sheet};
pub(crate) use emulate::{Emulate, MetricsSpec, SLOT_TIMES, metrics_place, panel_place};
pub(crate) use encode::{
    Control, Encode, Fcb, Octet, Parameter, Pkw, Service, Telegram, What, WidthSpec, Word,
};
pub(crate) use gsd::{Check, Gsd};
#[cfg(feature = "judge")]
pub(crate) use judge::{Compare, Judge, JudgedStation, Rows, millis as judge_millis, rows_of};
#[cfg(feature = "judge")]
pub(crate) use judged_device::{DeviceLink, JudgedNode, JudgedSlave};
#[cfg(test)]
pub(crate) use link::CAN_RATES;
pub(crate) use link::{BaudSpec, LinkSpec};
#[cfg(feature = "manual")]
pub(crate) use manual::{Completions, Man};
#[cfg(test)]
pub(crate) use master::Go;
pub(crate) use master::{Action, AddressRange, Asked, Direction, Master, Motion};
pub(crate) use master_link::{CanPlace, MasterLink};
pub(crate) use quantity::Quantity;
pub(crate) use records::{ParamAction, ParamChange, ParamPlace, Reach, RecordAction};
pub(crate) use try_out::Try;
#[cfg(not(feature = "judge"))]
pub(crate) use unbuilt_judge::Judge;

/// Emulated fieldbus drives on PROFIBUS-DP and CANopen, to test masters with.
///
/// A simulator only: it moves nothing, and nothing it says is a proof of safety for a real machine.
#[derive(Debug, Parser)]
#[command(name = "profidrive", version, after_help = examples(EXAMPLES), disable_help_subcommand = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
    #[command(flatten)]
    pub(crate) verbosity: Verbosity,
}

const EXAMPLES: &str = "\
Examples:
  profidrive demo                             a master and a drive in memory, explained step by step
  profidrive try                              a drive, a small master and the panel in one program
  profidrive emulate                          one drive at address 5; prints the terminal a master opens
  profidrive emulate --link pty:/tmp/bus      the same, under a name that stays
  profidrive emulate --help                   all its options
  profidrive master --link /tmp/bus --address 5 status
                                              commissions a drive, real or emulated
  profidrive decode 10 05 02 49 50 16         explains a telegram field by field
  profidrive encode pkw write limit1 250000   builds words and telegrams
  profidrive emulate --node 5,device={node.3} --link slcan-tcp:127.0.0.1:0
                                              a servo on CANopen, for masters that speak slcan
  profidrive eds {node.3}                      its electronic data sheet
  profidrive eds pump.eds                     explains the file of a node
  profidrive gsd valves.gsd                   explains the device file of a slave
  profidrive judge --station 5,ident=1234,cfg=2313
                                              judges a DP master row by row";

/// A text with the names of the list: `{node.2}` is the second device of `--node`, `{every group}` a line for each group on
/// PROFIBUS.
fn examples(template: &str) -> String {
    let groups = Group::ALL.into_iter().filter(|group| !group.is_on_can());
    let lines: Vec<_> =
        groups.map(|group| format!("  profidrive emulate --{} {}", group.name(), group.example())).collect();
    let mut text = template.replace("{every group}", &lines.join("\n"));
    for group in Group::ALL {
        for (number, device) in (1..).zip(group.devices()) {
            text = text.replace(&format!("{{{}.{number}}}", group.name()), device.name());
        }
    }
    text
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Demo(Demo),
    Try(Try),
    Emulate(Emulate),
    Master(Master),
    Decode(Decode),
    Encode(Encode),
    Eds(Eds),
    Gsd(Gsd),
    Judge(Box<Judge>),
    #[cfg(feature = "manual")]
    Completions(Completions),
    #[cfg(feature = "manual")]
    Man(Man),
}

/// How much is logged.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct Verbosity {
    /// Log more (-vv: everything); overrides RUST_LOG
    #[arg(short, long, global = true, display_order = 100, action = ArgAction::Count, conflicts_with = "quiet")]
    pub(crate) verbose: u8,

    /// Log warnings and errors only; overrides RUST_LOG
    #[arg(short, long, global = true, display_order = 101)]
    pub(crate) quiet: bool,
}

/// A command line that leads to no command: wrong, or a question for help or the version.
pub(crate) struct Refusal(clap::Error);

impl Args {
    /// The arguments of this process.
    pub(crate) fn from_command_line() -> Result<Self, Refusal> {
        Self::from_arguments(std::env::args_os())
    }

    fn from_arguments(arguments: impl IntoIterator<Item = OsString>) -> Result<Self, Refusal> {
        let args = Self::try_parse_from(arguments).map_err(Refusal)?;
        args.check().map_err(|line| {
            let mut command = Self::command();
            command.build();
            Refusal(command.error(ErrorKind::ValueValidation, line))
        })?;
        Ok(args)
    }

    /// How much is logged: the demo tells its story without the master's log, unless that is asked for.
    pub(crate) fn log_verbosity(&self) -> Verbosity {
        match self.command {
            Command::Demo(_) if self.verbosity.verbose == 0 => Verbosity { quiet: true, ..self.verbosity },
            Command::Demo(_)
            | Command::Try(_)
            | Command::Emulate(_)
            | Command::Decode(_)
            | Command::Encode(_)
            | Command::Eds(_)
            | Command::Gsd(_)
            | Command::Judge(_) => self.verbosity,
            #[cfg(feature = "manual")]
            Command::Completions(_) | Command::Man(_) => self.verbosity,
            // What it says is its result, and a failure its last line.
            Command::Master(_) => Verbosity { quiet: self.verbosity.verbose == 0, ..self.verbosity },
        }
    }

    /// Whether the result is JSON, for programs: then a failure is too.
    pub(crate) fn wants_json(&self) -> bool {
        match &self.command {
            Command::Master(master) => master.json,
            Command::Gsd(gsd) => gsd.json,
            Command::Eds(eds) => eds.json,
            Command::Encode(encode) => encode.json,
            // Each line of its input has its object, with what is wrong in it.
            Command::Decode(_) => false,
            Command::Demo(_) | Command::Try(_) | Command::Emulate(_) | Command::Judge(_) => false,
            #[cfg(feature = "manual")]
            Command::Completions(_) | Command::Man(_) => false,
        }
    }

    /// What no single argument shows.
    fn check(&self) -> Result<(), String> {
        match &self.command {
            Command::Demo(_)
            | Command::Decode(_)
            | Command::Encode(_)
            | Command::Eds(_)
            | Command::Gsd(_) => Ok(()),
            #[cfg(feature = "manual")]
            Command::Completions(_) | Command::Man(_) => Ok(()),
            Command::Try(tried) => tried.emulate().map(drop),
            Command::Emulate(emulate) => emulate.check(),
            Command::Master(master) => master.check(),
            Command::Judge(judge) => judge.check(),
        }
    }
}

impl Refusal {
    /// Prints what was asked for, or one line that says what is wrong; says the exit code.
    pub(crate) fn print(&self) -> ExitCode {
        let kind = self.0.kind();
        if matches!(kind, ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
            // Whoever asked may have closed the pipe after the first lines (`| head`).
            let _ = self.0.print();
            return ExitCode::SUCCESS;
        }
        let line = match kind == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
            true => format!("a command is missing; {}", read_on()),
            false => self.line(),
        };
        report(&Failure::Usage(line), wants_json(std::env::args_os()))
    }

    /// The first paragraph of the parser's error as one line, and where to read on.
    fn line(&self) -> String {
        let text = self.0.to_string();
        let lines: Vec<&str> = text.lines().map(str::trim).take_while(|line| !line.is_empty()).collect();
        let line = lines.join(" ");
        let line = line.strip_prefix("error: ").unwrap_or(&line);
        format!("{line}{}; {}", self.suggested(), read_on())
    }

    /// What was perhaps meant.
    fn suggested(&self) -> String {
        let kinds =
            [ContextKind::SuggestedSubcommand, ContextKind::SuggestedArg, ContextKind::SuggestedValue];
        let values = kinds.into_iter().find_map(|kind| self.0.get(kind));
        let quoted = match values {
            Some(ContextValue::String(one)) => format!("'{one}'"),
            Some(ContextValue::Strings(some)) => {
                some.iter().map(|one| format!("'{one}'")).collect::<Vec<_>>().join(" or ")
            }
            // A kind that is of no use here, or a newer one.
            Some(_) | None => String::new(),
        };
        if quoted.is_empty() { quoted } else { format!("; did you mean {quoted}?") }
    }
}

/// Whether a command line that was not understood asks for JSON. Of `judge` it names a file.
fn wants_json(arguments: impl IntoIterator<Item = OsString>) -> bool {
    let arguments: Vec<_> = arguments.into_iter().skip(1).collect();
    let named = |name: &str| arguments.iter().any(|argument| argument == name);
    named("--json") && !named("judge")
}

/// Where to read on, for who got the command line wrong.
fn read_on() -> String {
    let named = |name: &str| std::env::args_os().any(|argument| argument == name);
    let command =
        ["emulate", "master", "decode", "encode", "eds", "gsd", "judge"].into_iter().find(|name| named(name));
    format!("see 'profidrive{} --help'", command.map(|name| format!(" {name}")).unwrap_or_default())
}

/// `did you mean gear? ` if a known word is near to one that is not known, else nothing.
fn nearest<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> String {
    did_you_mean(word, known).map(|near| format!("did you mean {near}? ")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_declared_arguments_are_consistent() {
        Args::command().debug_assert();
    }

    #[test]
    fn every_command_has_help_with_an_example_of_itself() {
        fn walk(command: &mut clap::Command, path: &str, leaves: &mut Vec<String>) {
            if !command.has_subcommands() {
                leaves.push(path.to_owned());
                let help = command.render_long_help().to_string();
                let (_, examples) = help.split_once("\nExample").unwrap_or_default();
                let name = path.rsplit(' ').next().unwrap();
                let is_of_itself = |line: &str| {
                    line.trim_start().starts_with("profidrive ") && line.split(' ').any(|word| word == name)
                };
                assert!(examples.lines().any(is_of_itself), "{path}: {help}");
            }
            for part in command.get_subcommands_mut() {
                let path = format!("{path} {}", part.get_name());
                walk(part, &path, leaves);
            }
        }
        let mut leaves = Vec::new();
        let mut command = Args::command();
        command.build();
        walk(&mut command, "profidrive", &mut leaves);
        for known in ["profidrive emulate", "profidrive master scan", "profidrive encode telegram set-prm"] {
            assert!(leaves.iter().any(|leaf| leaf == known), "{leaves:?}");
        }
    }

    #[test]
    fn drives_and_ranges_add_up_and_must_not_overlap() {
        let numbers = |arguments: &[&str]| {
            let arguments = ["profidrive", "emulate"].iter().chain(arguments).map(OsString::from);
            let args = Args::from_arguments(arguments).map_err(|refusal| refusal.0.to_string())?;
            let Command::Emulate(emulate) = args.command else { panic!("not emulate") };
            Ok(emulate.slaves().iter().map(|drive| drive.place).collect::<Vec<_>>())
        };
        let all = numbers(&["--drives", "3-5", "--drive", "9", "--drives", "1-1"]);
        assert_eq!(all, Ok::<_, String>(vec![9, 3, 4, 5, 1]));
        assert_eq!(numbers(&["--drives", "1-2"]), Ok(vec![1, 2]), "no default beside them");
        assert_eq!(numbers(&[]), Ok(vec![5]));
        for overlap in [&["--drives", "1-5", "--drive", "3"], &["--drives", "1-5", "--drives", "5-9"]] {
            let error = numbers(overlap).unwrap_err();
            assert!(error.contains("two drives have address"), "{error}");
        }
    }

    /// The command lines of a page: in blocks, behind `$` or not, of `profidrive` or `cargo run`.
    fn command_lines(page: &str) -> Vec<String> {
        let whole = page.replace("\\\n", " ");
        let lines = whole.lines().map(|line| line.trim_start().trim_start_matches("$ "));
        let of_us = lines.filter_map(|line| match line.split_once(" -- ") {
            Some((cargo, arguments)) if cargo.starts_with("cargo run") && !cargo.contains("--example") => {
                Some(arguments)
            }
            Some(_) | None => line.strip_prefix("profidrive "),
        });
        of_us
            .map(|line| line.split(['#', '>', '<', '|', '&']).next().unwrap_or_default().trim().to_owned())
            .collect()
    }

    #[test]
    fn every_command_line_of_a_document_is_one() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let docs = std::fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path());
        let pages =
            docs.chain([root.join("README.md")]).filter(|page| page.extension().is_some_and(|md| md == "md"));
        let mut checked = 0;
        for page in pages {
            for line in command_lines(&std::fs::read_to_string(&page).unwrap()) {
                // The form of a command, with places to fill in.
                if line.contains('[') || line.contains("...") {
                    continue;
                }
                let words = line.split_whitespace().map(|word| OsString::from(word.trim_matches('\'')));
                if let Err(refusal) =
                    Args::from_arguments([OsString::from("profidrive")].into_iter().chain(words))
                {
                    let asked =
                        matches!(refusal.0.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion);
                    assert!(asked, "{}: profidrive {line}: {}", page.display(), refusal.0);
                }
                checked += 1;
            }
        }
        assert!(checked > 25, "{checked}");
    }
}
