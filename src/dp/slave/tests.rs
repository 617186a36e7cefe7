//! What only descriptions unlike the drive's show. Everything else is tested from the bus, in `tests/`.

use super::*;
use crate::fdl::Sap;

const MASTER: u8 = 2;

const IO: Description = Description { ident: 0x1234, configurations: &[&[0x23, 0x13]], ..Description::PLAIN };

fn request(sap: Option<u8>, data: &[u8]) -> Request<'_> {
    let address = Address::from_octet;
    let (dsap, ssap) = (sap.and_then(Sap::new), sap.and(Sap::new(62)));
    Request { da: address(5), sa: address(MASTER), dsap, ssap, data }
}

fn in_data_exchange(description: Description) -> Slave {
    let mut slave = Slave::new(description);
    slave.handle_srd(Instant::ZERO, &request(Some(61), &[0x80, 1, 1, 11, 0x12, 0x34, 0]));
    slave.handle_srd(Instant::ZERO, &request(Some(62), description.configurations[0]));
    assert_eq!(slave.state(), State::DataExch);
    slave
}

#[test]
fn p_12_sync_or_freeze_without_support_is_shown_and_does_not_stop_the_start_up() {
    for status in [0xA0, 0x90] {
        let mut slave = Slave::new(IO);
        slave.handle_srd(Instant::ZERO, &request(Some(61), &[status, 1, 1, 11, 0x12, 0x34, 0]));
        assert!(slave.diagnosis().not_supported);
        assert_eq!(slave.state(), State::WaitCfg);
        slave.handle_srd(Instant::ZERO, &request(Some(61), &[0x80, 1, 1, 11, 0x12, 0x34, 0]));
        assert!(!slave.diagnosis().not_supported, "cleared by the next good Set_Prm");
    }
}

#[test]
fn x_06_input_only_output_only_and_neither() {
    const INPUT: Description = Description { configurations: &[&[0x13]], ..IO };
    const OUTPUT: Description = Description { configurations: &[&[0x23]], ..IO };
    const NEITHER: Description = Description { configurations: &[&[0x00]], ..IO };
    for (description, outputs, reply) in [
        (INPUT, &[][..], Reply::DataLow(&[9, 9, 9, 9])),
        (OUTPUT, &[1, 2, 3, 4], Reply::ShortAcknowledge),
        (NEITHER, &[], Reply::ShortAcknowledge),
    ] {
        let mut slave = in_data_exchange(description);
        slave.set_inputs(&[9, 9, 9, 9]);
        let handled = slave.handle_srd(Instant::ZERO, &request(None, outputs));
        assert_eq!((handled.reply, handled.exchanged), (reply, true));
        assert_eq!(slave.outputs(), outputs);
    }
}

#[test]
fn inputs_never_offered_are_zero() {
    let mut slave = in_data_exchange(IO);
    let handled = slave.handle_srd(Instant::ZERO, &request(None, &[1, 2, 3, 4]));
    assert_eq!(handled.reply, Reply::DataLow(&[0; 4]));
}

#[test]
fn a_service_by_the_wrong_kind_of_request_has_no_effect() {
    let mut slave = in_data_exchange(IO);
    slave.handle_srd(Instant::ZERO, &request(None, &[1, 2, 3, 4]));
    let handled = slave.handle_srd(Instant::ZERO, &request(Some(58), &[0x02, 0x00]));
    assert_eq!(handled.reply, Reply::NotActivated, "Global_Control as SRD");
    assert_eq!(slave.handle_sdn(&request(Some(61), &[0x40, 0, 0, 0, 0, 0, 0])), None, "Set_Prm as SDN");
    assert_eq!((slave.state(), slave.outputs()), (State::DataExch, &[1, 2, 3, 4][..]));
}
