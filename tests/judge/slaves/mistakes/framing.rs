//! Telegrams, addresses and forms of requests.

use super::*;

pub(super) static FRAMING: &[Mistake] = &[
    Mistake {
        name: "no FDL status before Set_Prm",
        rows: &["S-F01"],
        hears: |slave, octets| {
            let is_dropped = service(&octets) == Some(Service::FdlStatus) && slave.state() == State::WaitPrm;
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "FDL status is RS in data exchange",
        rows: &["S-F01"],
        says: |slave, reply| {
            let is_it =
                service(&slave.request) == Some(Service::FdlStatus) && slave.state() == State::DataExch;
            if is_it { refused(slave) } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "FDL status says that it is a master",
        rows: &["S-F14"],
        says: |slave, reply| {
            if service(&slave.request) != Some(Service::FdlStatus) {
                return reply;
            }
            changed(&reply, |data, _| data.fc = FunctionCode::from_octet(0x20))
        },
        ..RIGHT
    },
    Mistake {
        name: "the highest address is answered, too",
        rows: &["S-F02"],
        hears: |_, octets| {
            if parsed(&octets).is_some_and(|data| data.da.number() == 125) {
                to(&octets, SLAVE)
            } else {
                octets
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "the checksum is not looked at",
        rows: &["S-F03"],
        hears: |_, octets| {
            if is_wrong(&octets) && octets.last() == Some(&0x16) { mended(&octets) } else { octets }
        },
        ..RIGHT
    },
    Mistake {
        name: "the end delimiter is not looked at",
        rows: &["S-F04"],
        hears: |_, mut octets| {
            if is_wrong(&octets) && octets.len() > 5 {
                *octets.last_mut().unwrap() = 0x16;
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "LEr is not looked at",
        rows: &["S-F05"],
        hears: |_, mut octets| {
            if is_wrong(&octets) && octets.len() > 9 && octets[0] == 0x68 && octets[3] == 0x68 {
                octets[2] = octets[1];
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "the fourth octet is not looked at",
        rows: &["S-F05"],
        hears: |_, mut octets| {
            if is_wrong(&octets) && octets.len() > 9 && octets[0] == 0x68 && octets[1] == octets[2] {
                octets[3] = 0x68;
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "LE of 3 is answered",
        rows: &["S-F05"],
        does: |slave, octets| {
            if octets.get(..3) == Some(&[0x68, 3, 3]) {
                slave.say(Duration::from_micros(40), &RS);
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "behind a broken telegram the next one is not heard",
        rows: &["S-F07"],
        hears: |slave, octets| {
            let is_dropped = slave.count > 0;
            let is_token = octets.first() == Some(&0xDC);
            slave.count = u32::from(is_wrong(&octets) && octets.len() > 1 && !is_token);
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "behind a single 68 the next telegram is taken for the rest of it",
        rows: &["S-F09"],
        hears: |slave, octets| {
            let is_dropped = slave.count > 0;
            slave.count = u32::from(octets == [0x68]);
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "a request with its own address as SA is answered",
        rows: &["S-F18"],
        does: |slave, octets| {
            if sa(octets) == SLAVE && service(octets) == Some(Service::FdlStatus) {
                slave.say(Duration::from_micros(40), &RS);
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "two requests at once are answered with RS",
        rows: &["S-F10"],
        hears: |slave, octets| {
            let now = slave.now.as_nanos();
            let gap = now - before(slave);
            slave.memory = now.to_be_bytes().to_vec();
            if gap == 6 * 22_000 {
                slave.say(Duration::from_micros(40), &RS);
                return Vec::new();
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "SD3 is not heard",
        rows: &["S-F11"],
        hears: |_, octets| {
            let is_dropped = octets.first() == Some(&0xA2) && !is_wrong(&octets);
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "a diagnosis of six octets is sent as SD3",
        rows: &["S-F11"],
        says: |_, reply| {
            if reply.len() != 17 || reply[0] != 0x68 {
                return reply;
            }
            let mut sd3 = vec![0xA2];
            sd3.extend(&reply[4..]);
            sd3
        },
        ..RIGHT
    },
    Mistake {
        name: "SRD low is not answered",
        rows: &["S-F12"],
        hears: |_, octets| {
            let is_dropped = service(&octets) == Some(Service::SrdLow);
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "Data_Exchange as SRD low is refused",
        rows: &["S-F12"],
        says: |slave, reply| {
            let low = service(&slave.request) == Some(Service::SrdLow);
            if low && Slave::dsap(&slave.request).is_none() { refused(slave) } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "a SAP that is not there is silent",
        rows: &["S-F13"],
        hears: |_, octets| {
            let is_dropped = matches!(Slave::dsap(&octets), Some(40 | 52));
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "a SAP that is not there is acknowledged",
        rows: &["S-F13"],
        says: |slave, reply| {
            if matches!(Slave::dsap(&slave.request), Some(40 | 52)) { vec![0xE5] } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "the reply goes to SAP 62 whichever asked",
        rows: &["S-F14"],
        says: |_, reply| {
            changed(&reply, |data, _| {
                if data.dsap.is_some() {
                    data.dsap = Sap::new(62);
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "the SAPs of a reply are those of the request, not exchanged",
        rows: &["S-F14"],
        says: |_, reply| changed(&reply, |data, _| core::mem::swap(&mut data.dsap, &mut data.ssap)),
        ..RIGHT
    },
    Mistake {
        name: "a reply has another SA",
        rows: &["S-F14"],
        says: |slave, reply| {
            if Slave::dsap(&slave.request) != GET_CFG {
                return reply;
            }
            changed(&reply, |data, _| data.sa = Address::from_octet(6))
        },
        ..RIGHT
    },
    Mistake {
        name: "a request to everybody is answered",
        rows: &["S-F15"],
        hears: |_, octets| {
            let all = parsed(&octets).is_some_and(|data| data.da == Address::BROADCAST);
            if all && service(&octets) == Some(Service::SrdHigh) { to(&octets, SLAVE) } else { octets }
        },
        ..RIGHT
    },
    Mistake {
        name: "a reply to its address is taken for a request",
        rows: &["S-F16"],
        does: |slave, octets| {
            let reply = parsed(octets).filter(|data| data.da.number() == SLAVE);
            if reply.is_some_and(|data| matches!(data.fc.function(), Function::Response(..))) {
                slave.say(Duration::from_micros(40), &RS);
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "SC of another makes it leave",
        rows: &["S-F16"],
        does: |slave, octets| {
            if octets == [0xE5] && slave.state() == State::DataExch {
                slave.station().abort();
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "a token is answered",
        rows: &["S-F17"],
        does: |slave, octets| {
            if octets.first() == Some(&0xDC) && octets.get(1) == Some(&SLAVE) {
                slave.say(Duration::from_micros(40), &[0xE5]);
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "Ident is acknowledged",
        rows: &["S-F19"],
        says: |slave, reply| if service(&slave.request) == Some(Service::Ident) { vec![0xE5] } else { reply },
        ..RIGHT
    },
    Mistake {
        name: "SDA is acknowledged",
        rows: &["S-F20"],
        says: |slave, reply| {
            let sda = matches!(service(&slave.request), Some(Service::SdaLow | Service::SdaHigh));
            if sda { vec![0xE5] } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "the longest telegram does not fit its buffer",
        rows: &["S-F21"],
        hears: |_, octets| {
            let is_dropped = octets.len() > 250;
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "its own reply is answered",
        rows: &["S-F22"],
        does: |slave, octets| {
            if !octets.is_empty() && octets == slave.reply && sa(octets) == SLAVE {
                slave.say(Duration::from_micros(40), &RS);
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "octets that begin no telegram make it leave",
        rows: &["S-F23"],
        does: |slave, octets| {
            let begins = octets.first().is_none_or(|first| [0x10, 0x68, 0xA2, 0xDC, 0xE5].contains(first));
            if !begins && octets.len() > 5 {
                slave.station().abort();
            }
        },
        ..RIGHT
    },
];
