//! SD2 and SD3, low and high priority: the same requests in each form.

use super::*;

#[test]
fn x_09_eight_octets_each_way_come_as_sd2_or_sd3_and_go_as_sd2() {
    let mut line = SlaveLine::judged_by(accepting(&[&[0x27, 0x17]]), IO, Policy::PROPOSED);
    line.request(MASTER, Some(61), &PRM);
    line.request(MASTER, Some(62), &[0x27, 0x17]);
    line.station.set_inputs(&[1, 2, 3, 4, 5, 6, 7, 8]);
    let reply = Some(hex("68 0B 0B 68 02 05 08 01 02 03 04 05 06 07 08 33 16"));
    assert_eq!(line.send(&hex("A2 05 02 6D 08 07 06 05 04 03 02 01 98 16")), reply);
    assert_eq!(line.outputs(), [8, 7, 6, 5, 4, 3, 2, 1]);
    assert_eq!(line.send(&hex("68 0B 0B 68 05 02 7D 01 02 03 04 05 06 07 08 A8 16")), reply);
    assert_eq!(line.outputs(), [1, 2, 3, 4, 5, 6, 7, 8]);
}

/// Six identifiers: eight octets of output, eight of input. With its SAPs a Chk_Cfg of them has eight octets, too.
const SIX: [u8; 6] = [0x21, 0x21, 0x23, 0x11, 0x11, 0x13];

/// The same request as SD2 or SD3 (`format`).
fn framed(format: Format, fc: FunctionCode, dsap: Option<u8>, data: &[u8]) -> Vec<u8> {
    let (dsap, ssap) = (dsap.and_then(Sap::new), dsap.and(Sap::new(62)));
    let (da, sa) = (Address::station(SLAVE).unwrap(), Address::station(MASTER).unwrap());
    let request = DataTelegram { format, da, sa, dsap, ssap, fc, data };
    request.encode(&mut [0; 255]).unwrap().to_vec()
}

#[test]
fn f_11_an_sd3_request_is_answered_and_carried_out_like_its_sd2_form() {
    const EIGHT: Fixed<'static> = accepting(&[&SIX]);
    let fc = |count| FunctionCode::request(Service::SrdHigh, count);
    let both = [Format::Sd2, Format::Sd3].map(|format| {
        let mut line = SlaveLine::judged_by(EIGHT, IO, Policy::PROPOSED);
        let mut replies = Vec::new();
        // A refused Chk_Cfg, an accepted one, two exchanges.
        for (prm, cfg) in [(true, [0x21; 6]), (true, SIX)] {
            assert!(prm && line.request(MASTER, Some(61), &PRM) == Answer::Sc);
            replies.push(line.send(&framed(format, fc(FrameCount::First), Some(62), &cfg)));
            replies.push(Some(line.diagnosis(OTHER)));
        }
        line.station.set_inputs(&[1, 2, 3, 4, 5, 6, 7, 8]);
        for (count, outputs) in [(FrameCount::Even, [9; 8]), (FrameCount::Odd, [8, 7, 6, 5, 4, 3, 2, 1])] {
            let reply = line.send(&framed(format, fc(count), None, &outputs));
            assert_eq!(reply.as_ref().unwrap()[0], 0x68, "in SD2");
            assert_eq!(line.outputs(), outputs);
            replies.push(reply);
        }
        // Eight octets of Set_Prm with its SAPs: one too few, refused alike.
        replies.push(line.send(&framed(
            format,
            fc(FrameCount::First),
            Some(61),
            &[0x80, 1, 1, 11, 0x12, 0x34],
        )));
        replies.push(Some(line.diagnosis(OTHER)));
        // Eight octets to services that take none.
        for sap in [56, 57, 59, 60] {
            replies.push(line.send(&framed(format, fc(FrameCount::First), Some(sap), &[0; 6])));
        }
        replies
    });
    assert_eq!(both[0], both[1]);
    assert_eq!(both[1][1].as_ref().unwrap()[0], 0x06, "six identifiers that are not ours");
    assert_eq!(both[1][5].as_ref().unwrap()[..4], [0x68, 0x0B, 0x0B, 0x68]);
}

#[test]
fn f_12_x_01_requests_of_low_and_high_priority_are_alike_in_every_service() {
    let [low, high] =
        [(Service::SrdLow, Service::SdnLow), (Service::SrdHigh, Service::SdnHigh)].map(|services| {
            let (srd, sdn) = services;
            let mut line = SlaveLine::new(IO);
            let mut seen = Vec::new();
            let requests: [(u8, Option<u8>, &[u8]); 13] = [
                (SLAVE, Some(55), &[6, 0x12, 0x34, 0]),
                (6, Some(60), &[]),
                (6, Some(59), &[]),
                (6, Some(61), &[0xB8, 10, 10, 11, 0x12, 0x34, 1]),
                (6, Some(62), &CFG),
                (6, None, &[1, 2, 3, 4]),
                (6, Some(56), &[]),
                (6, Some(57), &[]),
                // Global_Control: Sync and Freeze, then outputs that wait, then Clear_Data.
                (127, Some(58), &[0x28, 1]),
                (6, None, &[5, 6, 7, 8]),
                (6, Some(60), &[]),
                (6, Some(58), &[0x02, 0]),
                (6, Some(40), &[]),
            ];
            for (da, dsap, data) in requests {
                line.station.set_inputs(&[0xA0 + seen.len() as u8; 4]);
                let (service, count) =
                    if dsap == Some(58) { (sdn, FrameCount::Unused) } else { (srd, FrameCount::First) };
                let reply =
                    line.send(&telegram(da, MASTER, FunctionCode::request(service, count), dsap, data));
                assert_eq!(reply.is_none(), dsap == Some(58), "{dsap:?}");
                let slave = line.station.slave();
                let (outputs, passed) = (slave.outputs().to_vec(), slave.output_updates());
                seen.push((
                    reply,
                    slave.state(),
                    outputs,
                    passed,
                    slave.diagnosis().octets(),
                    line.station.address(),
                ));
            }
            seen
        });
    assert_eq!(low, high);
    // applied once each, whatever the priority.
    assert_eq!((&low[5].2[..], low[5].3), (&[1, 2, 3, 4][..], low[4].3 + 1));
    assert_eq!(low[9].2, [1, 2, 3, 4], "Sync holds");
    assert_eq!(low[11].2, [0; 4], "cleared");
}
