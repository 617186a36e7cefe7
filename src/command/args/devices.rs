//! The devices of a line: an option for each group of the list, and one for a range of addresses.

use clap::builder::ArgPredicate;
use clap::{Arg, ArgAction, ArgMatches, Command, Error, FromArgMatches};

use super::spec::RangeSpec;
use crate::host::list::{DEVICES, Device, Group, Spec};

/// The option for several drives that differ in their addresses only.
const RANGE: &str = "drives";

/// The devices of a line, as asked for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Devices {
    /// Those on PROFIBUS, group by group.
    pub(crate) slaves: Vec<Spec>,
    /// Those on CANopen.
    pub(crate) nodes: Vec<Spec>,
}

impl Devices {
    /// The names of the options.
    pub(crate) fn options() -> impl Iterator<Item = &'static str> {
        Group::ALL.into_iter().map(Group::name).chain([RANGE])
    }

    /// Adds one to those of its bus.
    pub(crate) fn push(&mut self, spec: Spec) {
        let of_bus = if spec.device.group().is_on_can() { &mut self.nodes } else { &mut self.slaves };
        of_bus.push(spec);
    }

    /// The group of what is there if nothing is asked for.
    fn usual() -> Option<Group> {
        DEVICES.first().map(Device::group)
    }
}

fn option(group: Group) -> Arg {
    Arg::new(group.name())
        .long(group.name())
        .value_name("SPEC")
        .action(ArgAction::Append)
        .value_parser(move |text: &str| Spec::parse(group, text).map_err(|wrong| wrong.words))
        .help(group.help())
        .long_help(group.long_help())
}

fn range(group: Group) -> Arg {
    let form = group.form("FIRST-LAST");
    Arg::new(RANGE)
        .long(RANGE)
        .value_name("SPECS")
        .action(ArgAction::Append)
        .value_parser(str::parse::<RangeSpec>)
        .help(format!(
            "A range of identical drives: {form}, as in 1-125,gear=24; may be repeated and mixed with --{}",
            group.name()
        ))
}

impl clap::Args for Devices {
    fn augment_args(mut command: Command) -> Command {
        let usual = Self::usual();
        for group in Group::ALL {
            let mut option = option(group);
            if usual == Some(group) {
                let others = Self::options().filter(|other| *other != group.name()).chain(["line"]);
                let unless = others.map(|other| (other, ArgPredicate::IsPresent, None::<&'static str>));
                option = option.default_value(group.usual(5)).default_value_ifs(unless);
                command = command.arg(option).arg(range(group));
            } else {
                command = command.arg(option);
            }
        }
        command
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Devices {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let mut all = Self::default();
        for group in Group::ALL {
            let specs = matches.get_many::<Spec>(group.name()).into_iter().flatten();
            specs.cloned().for_each(|spec| all.push(spec));
            if Self::usual() == Some(group) {
                let ranges = matches.get_many::<RangeSpec>(RANGE).into_iter().flatten();
                ranges.flat_map(RangeSpec::drives).for_each(|spec| all.push(spec));
            }
        }
        Ok(all)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
