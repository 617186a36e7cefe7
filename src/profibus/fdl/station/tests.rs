use super::*;
use crate::profibus::fdl::telegram::{Decoded, decode};

const OWN: u8 = 5;
const MASTER: u8 = 2;
const INPUTS: [u8; 4] = [1, 2, 3, 4];

fn station() -> Station {
    Station::new(Address::from_octet(OWN), BaudRate::K500, Some(100))
}

/// A telegram from `sa` to `da` with function code `fc`.
fn telegram(da: u8, sa: u8, fc: u8, saps: Option<(u8, u8)>, data: &[u8]) -> Vec<u8> {
    let (dsap, ssap) = (saps.and_then(|saps| Sap::new(saps.0)), saps.and_then(|saps| Sap::new(saps.1)));
    let telegram = DataTelegram {
        format: DataTelegram::customary_format(dsap, ssap, data),
        da: Address::from_octet(da),
        sa: Address::from_octet(sa),
        dsap,
        ssap,
        fc: FunctionCode::from_octet(fc),
        data,
    };
    telegram.encode(&mut [0; 255]).unwrap().to_vec()
}

fn diagnosis(fc: u8) -> Vec<u8> {
    telegram(OWN, MASTER, fc, Some((60, 62)), &[])
}

/// Hands `octets` to the station; a request that reaches the layer above is counted and answered with INPUTS.
fn exchange(station: &mut Station, now: Instant, octets: &[u8], served: &mut u32) -> Option<Vec<u8>> {
    let Decoded::Telegram { telegram, .. } = decode(octets) else { panic!("{octets:02X?}") };
    match station.handle_telegram(now, &telegram) {
        Reception::DataWithReply(request) => {
            *served += 1;
            station.reply(now, &request, Reply::DataLow(&INPUTS));
        }
        Reception::Data(_) => *served += 1,
        Reception::Ignored | Reception::Answered { .. } | Reception::Repeated { .. } => {}
    }
    let due = station.poll_timeout()?;
    station.poll_transmit(due).unwrap().map(<[u8]>::to_vec)
}

#[test]
fn f_01_fdl_status_is_answered_with_ok() {
    let mut station = station();
    let reply = exchange(&mut station, Instant::ZERO, &[0x10, 5, 2, 0x49, 0x50, 0x16], &mut 0);
    assert_eq!(reply.unwrap(), [0x10, 2, 5, 0, 7, 0x16]);
}

#[test]
fn f_02_f_15_f_16_f_17_f_18_what_is_not_for_us_stays_unanswered() {
    for (octets, what) in [
        (telegram(6, MASTER, 0x49, None, &[]), "FDL status of another station"),
        (telegram(127, MASTER, 0x49, None, &[]), "FDL status of everybody"),
        (telegram(127, MASTER, 0x6D, Some((60, 62)), &[]), "SRD to everybody"),
        (telegram(127, MASTER, 0x49, Some((60, 62)), &[]), "FDL status of everybody with SAPs"),
        (telegram(127, MASTER, 0x6D, None, &[1, 2, 3]), "Data_Exchange with everybody"),
        (telegram(6, 7, 0x08, Some((62, 60)), &[1]), "a response to another station"),
        (telegram(OWN, OWN, 0x6D, Some((60, 62)), &[]), "our own address as sender"),
        (telegram(OWN, 127, 0x6D, Some((60, 62)), &[]), "everybody as sender"),
        (telegram(OWN, MASTER, 0x42, None, &[]), "a reserved service"),
        (telegram(OWN, MASTER, 0xC9, None, &[]), "a clock telegram"),
        (vec![0xDC, OWN, MASTER], "the token"),
        (vec![0xE5], "a short acknowledge"),
    ] {
        let mut served = 0;
        assert_eq!(exchange(&mut station(), Instant::ZERO, &octets, &mut served), None, "{what}");
        assert_eq!(served, 0, "{what}");
    }
}

#[test]
fn f_16_no_response_is_answered_or_served_whatever_its_status_and_form_and_whoever_it_is_to() {
    let mut served = 0;
    for da in [OWN, 6, MASTER, 126, 127] {
        for fc in 0x00..=0x3F {
            // SD1, SD2 with and without SAPs.
            for (saps, data) in
                [(None, &[][..]), (None, &[1, 2]), (Some((62, 60)), &[1]), (Some((60, 62)), &[])]
            {
                let octets = telegram(da, 6, fc, saps, data);
                let mut station = station();
                assert_eq!(
                    exchange(&mut station, Instant::ZERO, &octets, &mut served),
                    None,
                    "{octets:02X?}"
                );
            }
            // SD3.
            let octets = DataTelegram {
                format: Format::Sd3,
                da: Address::from_octet(da),
                sa: Address::from_octet(6),
                dsap: None,
                ssap: None,
                fc: FunctionCode::from_octet(fc),
                data: &[0; 8],
            };
            let mut buf = [0; MAX_TELEGRAM_LEN];
            let octets = octets.encode(&mut buf).unwrap();
            assert_eq!(exchange(&mut station(), Instant::ZERO, octets, &mut served), None, "{octets:02X?}");
        }
    }
    assert_eq!(served, 0);
}

#[test]
fn f_14_addresses_and_saps_are_mirrored() {
    let octets = telegram(OWN, MASTER, 0x6C, Some((59, 41)), &[]);
    let reply = exchange(&mut station(), Instant::ZERO, &octets, &mut 0).unwrap();
    assert_eq!(reply, telegram(MASTER, OWN, 0x08, Some((41, 59)), &INPUTS));
}

#[test]
fn f_19_f_20_services_of_no_dp_slave_are_not_activated() {
    for fc in [0x4E, 0x4F, 0x73, 0x75] {
        let mut served = 0;
        let octets = telegram(OWN, MASTER, fc, Some((60, 62)), &[]);
        let reply = exchange(&mut station(), Instant::ZERO, &octets, &mut served);
        assert_eq!(reply.unwrap(), [0x10, 2, 5, 3, 10, 0x16], "{fc:02X}");
        assert_eq!(served, 0, "{fc:02X}");
    }
}

#[test]
fn c_01_c_02_c_03_c_06_c_07_c_08_c_09_c_10_the_frame_count_bit_tells_retries_from_requests() {
    let other = |fc| telegram(OWN, 3, fc, Some((60, 62)), &[]);
    let get_cfg = |fc| telegram(OWN, MASTER, fc, Some((59, 62)), &[]);
    let status = || telegram(OWN, MASTER, 0x49, None, &[]);
    let foreign = || telegram(9, MASTER, 0x49, None, &[]);
    for (sequence, served_in_all, what) in [
        (vec![diagnosis(0x6D)], 1, "C-01 first cycle"),
        (vec![diagnosis(0x6D), diagnosis(0x5D), diagnosis(0x7D)], 3, "C-02 toggled"),
        (vec![diagnosis(0x6D), diagnosis(0x5D), diagnosis(0x5D), diagnosis(0x5D)], 2, "C-03 retries"),
        (vec![diagnosis(0x6D), diagnosis(0x7D)], 1, "C-03 FCB as stored by the first cycle"),
        (vec![diagnosis(0x6D), diagnosis(0x5D), other(0x5D), diagnosis(0x5D)], 4, "C-06 other initiator"),
        (vec![diagnosis(0x6D), diagnosis(0x6D)], 2, "C-07 first cycle twice"),
        (vec![diagnosis(0x6D), diagnosis(0x5D), get_cfg(0x5D)], 3, "C-08 same bit, other request"),
        (vec![diagnosis(0x5D)], 1, "C-09 counted at once, even"),
        (vec![diagnosis(0x7D)], 1, "C-09 counted at once, odd"),
        (vec![diagnosis(0x5D), status(), diagnosis(0x5D)], 2, "C-10 FDL status in between ends the retry"),
        (vec![diagnosis(0x5D), foreign(), diagnosis(0x5D)], 1, "a telegram for another station does not"),
    ] {
        let mut station = station();
        let mut served = 0;
        for octets in sequence {
            exchange(&mut station, Instant::ZERO, &octets, &mut served);
        }
        assert_eq!(served, served_in_all, "{what}");
    }
}

#[test]
fn c_03_a_retry_gets_the_stored_reply_octet_for_octet() {
    let mut station = station();
    let mut served = 0;
    let first = exchange(&mut station, Instant::ZERO, &diagnosis(0x5D), &mut served);
    let again = exchange(&mut station, Instant::from_millis(1), &diagnosis(0x5D), &mut served);
    assert!(first.is_some());
    assert_eq!((first, served), (again, 1));
}

#[test]
fn a_retry_with_other_data_is_a_new_request() {
    let mut station = station();
    let mut served = 0;
    for last in [7, 7, 8] {
        let octets = telegram(OWN, MASTER, 0x5D, None, &[1, 2, 3, 4, 5, 6, last]);
        exchange(&mut station, Instant::ZERO, &octets, &mut served);
    }
    assert_eq!(served, 2);
}

#[test]
fn p_07_no_reply_before_min_tsdr() {
    for (set, bits) in [(0, 11), (11, 11), (60, 60), (255, 255)] {
        for baud in BaudRate::ALL {
            let mut station = Station::new(Address::from_octet(OWN), baud, None);
            station.set_min_tsdr(set);
            let now = Instant::from_millis(3);
            let octets = diagnosis(0x6D);
            let Decoded::Telegram { telegram, .. } = decode(&octets) else { panic!() };
            let Reception::DataWithReply(request) = station.handle_telegram(now, &telegram) else { panic!() };
            station.reply(now, &request, Reply::ShortAcknowledge);
            let due = now.saturating_add(baud.bit_times(bits));
            assert_eq!(station.poll_timeout(), Some(due));
            let early = Instant::from_nanos(due.as_nanos() - 1);
            assert_eq!(station.poll_transmit(early), Ok(None));
            assert_eq!(station.poll_transmit(due), Ok(Some(&[0xE5][..])));
            assert_eq!(station.poll_transmit(due), Ok(None), "a reply is sent once");
        }
    }
}

#[test]
fn t_02_a_reply_whose_time_is_over_is_dropped_and_said() {
    let mut station = station();
    let octets = diagnosis(0x6D);
    let Decoded::Telegram { telegram, .. } = decode(&octets) else { panic!() };
    let Reception::DataWithReply(request) = station.handle_telegram(Instant::ZERO, &telegram) else {
        panic!()
    };
    station.reply(Instant::ZERO, &request, Reply::ShortAcknowledge);
    let limit = Duration::from_micros(200);
    let after = Duration::from_micros(201);
    assert_eq!(station.poll_transmit(Instant::from_micros(201)), Err(TooLate { after, limit }));
    assert_eq!(station.poll_transmit(Instant::from_micros(202)), Ok(None));
}

#[test]
fn a_min_tsdr_set_beyond_max_tsdr_delays_replies_and_does_not_forbid_them() {
    let mut station = station();
    station.set_min_tsdr(255);
    let octets = diagnosis(0x6D);
    let Decoded::Telegram { telegram, .. } = decode(&octets) else { panic!() };
    for late in [Duration::from_micros(510), Duration::from_micros(710), Duration::from_micros(711)] {
        let Reception::DataWithReply(request) = station.handle_telegram(Instant::ZERO, &telegram) else {
            panic!()
        };
        station.reply(Instant::ZERO, &request, Reply::ShortAcknowledge);
        let now = Instant::ZERO.saturating_add(late);
        assert_eq!(station.poll_transmit(now).is_ok(), late.as_micros() <= 710, "{late:?}");
    }
}

#[test]
fn a_new_request_on_the_line_ends_the_time_of_the_old_reply() {
    let mut station = station();
    let octets = diagnosis(0x6D);
    let Decoded::Telegram { telegram: first, .. } = decode(&octets) else { panic!() };
    let Reception::DataWithReply(request) = station.handle_telegram(Instant::ZERO, &first) else { panic!() };
    station.reply(Instant::ZERO, &request, Reply::ShortAcknowledge);
    let foreign = telegram(9, MASTER, 0x49, None, &[]);
    let Decoded::Telegram { telegram: foreign, .. } = decode(&foreign) else { panic!() };
    assert_eq!(station.handle_telegram(Instant::from_micros(10), &foreign), Reception::Ignored);
    assert_eq!(station.poll_timeout(), None);
}

#[test]
fn f_21_the_longest_reply_fits_and_a_longer_one_becomes_no_resource() {
    let octets = diagnosis(0x6D);
    let Decoded::Telegram { telegram, .. } = decode(&octets) else { panic!() };
    let data = [0x5A; 245];
    for (len, expected) in [(244, 255), (245, 6), (0, 6)] {
        let mut station = station();
        let Reception::DataWithReply(request) = station.handle_telegram(Instant::ZERO, &telegram) else {
            panic!()
        };
        station.reply(Instant::ZERO, &request, Reply::DataLow(&data[..len]));
        let reply = station.poll_transmit(Instant::from_micros(22)).unwrap().unwrap();
        assert_eq!(reply.len(), expected, "{len} octets");
    }
}

#[test]
fn each_reply_has_its_telegram() {
    let octets = diagnosis(0x6D);
    let Decoded::Telegram { telegram: asked, .. } = decode(&octets) else { panic!() };
    let data = [0x5A; 245];
    for (reply, expected) in [
        (Reply::DataHigh(&[]), telegram(MASTER, OWN, 0x0A, None, &[])),
        (Reply::DataHigh(&data[..1]), telegram(MASTER, OWN, 0x0A, Some((62, 60)), &data[..1])),
        (Reply::DataHigh(&data[..244]), telegram(MASTER, OWN, 0x0A, Some((62, 60)), &data[..244])),
        (Reply::DataHigh(&data), telegram(MASTER, OWN, 0x02, None, &[])),
        (Reply::DataLow(&data[..1]), telegram(MASTER, OWN, 0x08, Some((62, 60)), &data[..1])),
        (Reply::NoReplyData, telegram(MASTER, OWN, 0x09, None, &[])),
        (Reply::NoResource, telegram(MASTER, OWN, 0x02, None, &[])),
        (Reply::NotActivated, telegram(MASTER, OWN, 0x03, None, &[])),
        (Reply::ShortAcknowledge, vec![0xE5]),
    ] {
        let mut station = station();
        let Reception::DataWithReply(request) = station.handle_telegram(Instant::ZERO, &asked) else {
            panic!()
        };
        station.reply(Instant::ZERO, &request, reply);
        assert_eq!(station.poll_transmit(Instant::from_micros(22)), Ok(Some(&expected[..])), "{reply:?}");
    }
}
