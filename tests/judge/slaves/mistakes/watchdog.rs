//! The watchdog, and a master that goes.

use super::*;

pub(super) static WATCHDOG: &[Mistake] = &[
    Mistake {
        name: "the watchdog never expires",
        rows: &["S-W01"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == SET_PRM {
                return changed(&octets, |_, data| {
                    if data[1] > 0 && data[2] > 0 {
                        data[0] &= !0x08;
                    }
                });
            }
            octets
        },
        says: |slave, reply| {
            let watched = Slave::dsap(&slave.request) == SLAVE_DIAG && slave.state() != State::WaitPrm;
            diag(slave, &reply, |octets| octets[1] |= if watched { 0x08 } else { 0 })
        },
        ..RIGHT
    },
    Mistake {
        name: "the watchdog takes twice its time",
        rows: &["S-W01"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == SET_PRM {
                return changed(&octets, |_, data| {
                    if data[1] == 10 {
                        data[1] = 20;
                    }
                });
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "outputs outlive the watchdog",
        rows: &["S-W01"],
        hears: |slave, octets| {
            if is_exchange(&octets) && slave.state() == State::DataExch {
                slave.memory = data(&octets);
                slave.count = 1;
            }
            let status = data(&octets).first().copied().unwrap_or(0);
            if Slave::dsap(&octets) == SET_PRM {
                slave.count =
                    if status & 0x80 != 0 && slave.state() == State::WaitPrm { slave.count * 2 } else { 0 };
            }
            octets
        },
        says: |slave, reply| {
            let old = slave.memory.clone();
            if slave.count == 2 && Slave::dsap(&slave.request) == RD_OUTP && data(&reply).len() == 4 {
                return changed(&reply, |_, data| *data = old);
            }
            reply
        },
        ..RIGHT
    },
    Mistake {
        name: "without watchdog it leaves after a second",
        rows: &["S-W02"],
        does: |slave, _| {
            let now = slave.now.as_nanos();
            let off = slave.framed.station().slave().watchdog().is_none();
            if off && before(slave) > 0 && now - before(slave) > 1_000_000_000 {
                leaves(slave);
            }
            slave.memory = now.to_be_bytes().to_vec();
        },
        ..RIGHT
    },
    Mistake {
        name: "any traffic feeds the watchdog",
        rows: &["S-W03"],
        hears: |slave, octets| {
            let own = slave.framed.station().slave().watchdog().is_some();
            if own && sa(&octets) != OWNER && sa(&octets) != SLAVE && slave.state() == State::DataExch {
                let feed = changed(&prm(0, [0, 0]), |telegram, data| {
                    telegram.dsap = Sap::new(60);
                    data.clear();
                });
                slave.takes(&feed);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "the second factor of the watchdog is not looked at",
        rows: &["S-W04"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == SET_PRM {
                return changed(&octets, |_, data| {
                    if data[0] & 0x08 != 0 && data[2] != 0 && data[1] < 100 {
                        data[2] = 1;
                    }
                });
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "a power cycle does not end data exchange",
        rows: &["S-W05"],
        acts: |slave, action| action == "power-cycle" && slave.state() == State::DataExch,
        ..RIGHT
    },
    Mistake {
        name: "after the watchdog only the next power on helps",
        rows: &["S-W06"],
        hears: |slave, octets| {
            let now = slave.now.as_nanos();
            let silent = now - before(slave);
            slave.memory = now.to_be_bytes().to_vec();
            if (195_000_000..205_000_000).contains(&silent) {
                slave.count = 1;
            }
            if slave.count == 1 && Slave::dsap(&octets) == SET_PRM {
                slave.count = 0;
                return changed(&octets, |_, data| data[4] = 0);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "a silent master loses its slave to the next one",
        rows: &["S-W07"],
        hears: |slave, octets| {
            let silent = slave.now.as_nanos() - before(slave);
            if sa(&octets) == OWNER {
                slave.memory = slave.now.as_nanos().to_be_bytes().to_vec();
            } else if Slave::dsap(&octets) == SET_PRM && silent > 200_000_000 {
                slave.takes(&prm(0x40, [0, 0]));
            }
            octets
        },
        ..RIGHT
    },
];
