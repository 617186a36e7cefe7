//! Walks of a master that makes mistakes, on a line with one slave.

use core::time::Duration;
use std::collections::BTreeMap;

use super::slaves::{CYCLE, HELD, Line, MASTER, OTHER, Reply, SLAVE, TARGETS};
use super::{Told, advice, expect_none, walks, words};
use crate::chance::Random;
use crate::profibus::dp;
use crate::profibus::fdl::Service;

/// A walk: steps, and what was silent.
struct Walk {
    line: Line,
    random: Random,
    told: Told,
    silences: BTreeMap<String, String>,
}

impl Walk {
    fn pick<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.random.below(of.len())]
    }

    /// A step is over: was it acted upon, or told?
    fn judge(&mut self, what: &str, acted: bool) {
        let news = self.line.take_news();
        // Off it was told when it was switched off.
        if acted || self.line.is_off() || self.line.once.contains(what) {
            // What it told counts for the next time.
            self.told.covers(what, &news);
            return;
        }
        if !self.told.covers(what, &news) {
            self.note(what);
        }
    }

    /// A request for a service.
    fn service(&mut self, sa: u8, service: dp::Service, data: &[u8], how: &str) {
        let before = self.line.look();
        let (state, owner) = (self.line.state(), self.line.owner());
        let reply = self.line.ask(sa, service, data);
        self.line.wait(CYCLE);
        let changed = self.line.look() != before;
        let reads = match service {
            dp::Service::SetSlaveAdd | dp::Service::SetPrm | dp::Service::GlobalControl => false,
            // The same again changes nothing.
            dp::Service::ChkCfg => state == Some(dp::State::DataExch),
            _ => true,
        };
        let owned = owner.filter(|owner| *owner != sa);
        let how = if service == dp::Service::SetPrm && owned.is_some() { "not the owner" } else { how };
        // Masters unlock what nobody has.
        let nobodys = how == "unlock" && owner.is_none();
        let what = match (&reply, service) {
            (_, dp::Service::SetPrm) if self.line.state() == Some(dp::State::WaitCfg) && owned.is_none() => {
                "parameterised by master".to_owned()
            }
            (_, dp::Service::SetPrm) => format!("Set_Prm {how}"),
            (Reply::Status(_), _) if how == "with data" && state == Some(dp::State::DataExch) => {
                self.line.refused(how)
            }
            (Reply::Status(_), _) => self.line.refused(service.name()),
            _ => format!("{} of master {sa}, {how}, in {state:?} of {owner:?}", service.name()),
        };
        self.judge(&what, reply.is_positive() && (reads || changed || nobodys));
    }

    fn step(&mut self) {
        // What is told too often is counted: that is another test.
        self.line.bus.forget_told();
        let sa = if self.random.below(8) == 0 { OTHER } else { MASTER };
        match self.random.below(20) {
            0 | 1 => self.set_prm(sa),
            2 => self.chk_cfg(sa),
            3 => self.read(sa),
            4 => self.control(sa),
            5 => self.other_services(sa),
            6 => self.outside(),
            7 => self.length(),
            8 => {
                let time = Duration::from_millis(*self.pick(&[20, 150, 700, 7000]));
                self.line.story.push(format!("  nothing for {time:?}"));
                self.line.wait(time);
                self.line.take_news();
            }
            9 | 10 => {
                self.line.start_up();
                self.line.take_news();
            }
            _ => self.word(),
        }
        advice::names_a_reason(&mut self.line).unwrap_or_else(|(what, example)| {
            self.silences.entry(what).or_insert(example);
        });
        if self.random.below(8) == 0 {
            advice::makes_it_move(&mut self.line).unwrap_or_else(|(what, example)| {
                self.silences.entry(what).or_insert(example);
            });
            self.line.take_news();
        }
    }

    fn set_prm(&mut self, sa: u8) {
        let mut prm = self.line.prm();
        let how = *self.pick(&[
            "in order",
            "ident",
            "exchanged ident",
            "short",
            "long",
            "reserved",
            "unlock",
            "both",
            "no lock",
            "watchdog 0",
            "watchdog 20 ms",
            "no sync",
            "group",
            "min T_SDR 5",
        ]);
        match how {
            "ident" => prm[5] ^= 0x11,
            "exchanged ident" => prm.swap(4, 5),
            "short" => prm.truncate(5),
            "long" => prm.extend([1, 2, 3, 4, 5, 6, 7, 8]),
            "reserved" => prm[0] |= 0x07,
            "unlock" => prm[0] = 0x40,
            "both" => prm[0] |= 0x40,
            "no lock" => prm[0] &= 0x7F,
            "watchdog 0" => prm[0] |= 0x08,
            "watchdog 20 ms" => (prm[0], prm[1], prm[2]) = (prm[0] | 0x08, 2, 1),
            "no sync" => prm[0] &= !0x30,
            "group" => prm[6] = 1,
            "min T_SDR 5" => prm[3] = 5,
            _ => {}
        }
        self.service(sa, dp::Service::SetPrm, &prm, how);
    }

    fn chk_cfg(&mut self, sa: u8) {
        let mut cfg = self.line.target.cfg.to_vec();
        let how = *self.pick(&["in order", "in order", "in order", "wrong", "short", "long", "empty"]);
        match how {
            "wrong" => cfg[0] ^= 0x21,
            "short" => cfg.truncate(1),
            "long" => cfg.push(0x11),
            "empty" => cfg.clear(),
            _ => {}
        }
        self.service(sa, dp::Service::ChkCfg, &cfg, how);
    }

    fn read(&mut self, sa: u8) {
        let services = [dp::Service::SlaveDiag, dp::Service::GetCfg, dp::Service::RdInp, dp::Service::RdOutp];
        let service = *self.pick(&services);
        let data: &[u8] = if self.random.below(4) == 0 { &[1, 2] } else { &[] };
        self.service(sa, service, data, if data.is_empty() { "in order" } else { "with data" });
    }

    fn control(&mut self, sa: u8) {
        let command = *self.pick(&[0x00, 0x02, 0x04, 0x08, 0x10, 0x20, 0x28, 0x14, 0x01, 0x40, 0xFF]);
        let group = *self.pick(&[0, 0, 1, 2]);
        let long = self.random.below(8) == 0;
        let (before, state, owner) = (self.line.look(), self.line.state(), self.line.owner());
        let from = self.line.story.len();
        let latched = |line: &Line| words::reasons(line).iter().any(|name| name.ends_with("Holds"));
        let held = latched(&self.line);
        let octets = [command, group, 0];
        self.line.control(sa, if long { &octets } else { &octets[..2] });
        self.line.wait(CYCLE);
        let changed = self.line.look() != before || held != latched(&self.line);
        // What asks for nothing, or for the end of what is not on.
        let idle =
            !long && (command == 0 || (command == 0x04 || command == 0x10 || command == 0x14) && !held);
        let obeyed = self.line.story[from..]
            .iter()
            .any(|line| line.contains(&format!("Global_Control of master {sa}:")));
        let malformed = long || command & 0xC1 != 0;
        // Masters send it to all, also while stations start.
        let starts = !malformed && state != Some(dp::State::DataExch);
        let what = match () {
            () if malformed => "malformed".to_owned(),
            () if owner != Some(sa) => format!("of {sa} and not of {owner:?}"),
            () => "for another group".to_owned(),
        };
        self.judge(&format!("Global_Control {what}"), changed || idle || obeyed || starts);
    }

    fn other_services(&mut self, sa: u8) {
        let (state, owner) = (self.line.state(), self.line.owner());
        let which = self.random.below(9);
        let (what, octets) = match which {
            0 => ("SAP 51", self.line.request((sa, SLAVE), Service::SrdHigh, Some(51), 51, &[0x5E, 1, 1, 4])),
            1 => ("SAP 33", self.line.request((sa, SLAVE), Service::SrdHigh, Some(33), 62, &[1])),
            2 => ("SSAP 50", self.line.request((sa, SLAVE), Service::SrdHigh, Some(60), 50, &[])),
            3 => ("SDA Set_Prm", {
                let prm = self.line.prm();
                self.line.request((sa, SLAVE), Service::SdaHigh, Some(61), 62, &prm)
            }),
            4 => ("SDN Data_Exchange", self.line.request((sa, SLAVE), Service::SdnHigh, None, 62, &[1, 2])),
            5 => ("Ident", self.line.request((sa, SLAVE), Service::Ident, None, 62, &[])),
            6 => ("LSAP_Status", self.line.request((sa, SLAVE), Service::LsapStatus, None, 62, &[])),
            7 => ("Set_Slave_Add", {
                let [high, low] = self.line.ident.to_be_bytes();
                self.line.request((sa, SLAVE), Service::SrdHigh, Some(55), 62, &[9, high, low, 0])
            }),
            _ => (
                "Global_Control alone",
                self.line.request((sa, SLAVE), Service::SdnHigh, Some(58), 62, &[0x08, 0]),
            ),
        };
        let before = self.line.look();
        let reply = self.line.reply_to(&octets);
        self.line.story.push(format!("  {what} of master {sa}: {reply:02X?}"));
        self.line.wait(CYCLE);
        let acted = self.line.look() != before || matches!(reply, Reply::Data(_));
        let starts = which == 8 && state != Some(dp::State::DataExch);
        let what = match which {
            0..=1 => self.line.refused("a request"),
            2 => self.line.refused("Slave_Diag"),
            7 => self.line.refused("Set_Slave_Add"),
            8 => format!("Global_Control of {sa} and not of {owner:?}"),
            _ => "request that DP does not use".to_owned(),
        };
        self.judge(&what, acted || starts);
    }

    /// Something around the drive.
    fn outside(&mut self) {
        let mut faults = Vec::new();
        if let Some(device) = self.line.description() {
            device.each_fault(&mut |fault| faults.push(fault.name.to_string()));
        }
        let which = self.random.below(6);
        let fault = if faults.is_empty() { String::new() } else { self.pick(&faults).clone() };
        self.line.story.push(format!("  outside: {which} {fault}"));
        self.line.act(|device, now| match which {
            0 => device.switch_supply(now, false),
            1 => device.switch_supply(now, true),
            2 | 3 => _ = device.provoke(now, &fault),
            _ => device.make_nominal(now),
        });
        self.line.exchange(3);
        self.line.take_news();
    }

    /// Data_Exchange with another number of outputs.
    fn length(&mut self) {
        let (before, state, owner) = (self.line.look(), self.line.state(), self.line.owner());
        let whole = self.line.outputs.clone();
        let len = self.random.below(whole.len() + 3);
        if len == whole.len() {
            return;
        }
        self.line.outputs.resize(len, 0);
        let reply = self.line.exchange(2);
        self.line.outputs = whole;
        let acted = reply.is_positive() && self.line.look() != before;
        let exchanges = state == Some(dp::State::DataExch) && owner == Some(MASTER);
        let what = if exchanges {
            "Data_Exchange with another length".to_owned()
        } else {
            self.line.refused("Data_Exchange")
        };
        self.judge(&what, acted);
    }

    /// Another control word, setpoint or job for some cycles.
    fn word(&mut self) {
        let (before, state) = (words::Seen::of(&self.line), self.line.state());
        words::change(&mut self.line.outputs, self.line.target.kind, &mut self.random);
        let reply = self.line.exchange(HELD);
        if self.line.is_off() {
            return;
        }
        // What Sync holds back is told when it is left on.
        if words::reasons(&self.line).contains(&"SyncHolds") {
            self.line.exchange(600);
        }
        let news = self.line.take_news();
        let words::Seen { state: of_drive, .. } = &before;
        if state != Some(dp::State::DataExch) || !reply.is_positive() {
            let what = self.line.refused("Data_Exchange");
            if !self.line.once.contains(&what) && !reply.is_positive() {
                self.note(&what);
            }
            return;
        }
        let after = words::Seen::of(&self.line);
        for (want, met) in words::wants(self.line.target.kind, &before, &after) {
            let held = words::reasons(&self.line).contains(&"SyncHolds");
            let what = if held { "Sync of master".to_owned() } else { format!("{want} in '{of_drive}'") };
            if !met && !self.told.covers(&what, &news) && !self.line.once.contains(&what) {
                self.note(&what);
            }
        }
    }

    fn note(&mut self, what: &str) {
        let from = self.line.story.len().saturating_sub(8);
        let story = self.line.story[from..].join("\n");
        let why = self.line.bus.why(Line::slave()).map(|why| format!("  why: {why}"));
        self.silences
            .entry(what.to_owned())
            .or_insert_with(|| format!("{story}\n{}", why.unwrap_or_default()));
    }
}

#[test]
fn no_step_of_a_wrong_master_is_without_effect_and_without_a_word() {
    let mut all = BTreeMap::new();
    for target in TARGETS {
        let mut silences = BTreeMap::new();
        for seed in 1..=walks() {
            let mut line = Line::of(target);
            if seed % 2 == 0 {
                assert!(line.start_up(), "{}: {:#?}", target.name, line.story);
            }
            line.take_news();
            let (random, told) = (Random::new(seed), Told::default());
            let mut walk = Walk { line, random, told, silences: core::mem::take(&mut silences) };
            // Set_Slave_Add takes it away.
            for _ in 0..60 {
                if walk.line.state().is_some() {
                    walk.step();
                }
            }
            silences = walk.silences;
        }
        all.extend(silences.into_iter().map(|(what, example)| (format!("{}: {what}", target.name), example)));
    }
    expect_none(&all);
}
