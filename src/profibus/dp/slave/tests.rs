//! What only descriptions unlike the drive's show. Everything else is tested from the bus, in `tests/`.

use super::*;
use crate::profibus::dp::CfgSyntax;
use crate::profibus::fdl::Sap;

const MASTER: u8 = 2;

const IO: Description = Description { ident: 0x1234, ..Description::PLAIN };
const CFG: &[u8] = &[0x23, 0x13];

fn slave(configuration: &'static [u8]) -> Slave<Exactly> {
    Slave::new(IO, Exactly(configuration))
}

/// An application that accepts one configuration.
struct Exactly(&'static [u8]);

impl Application for Exactly {
    fn judge_prm(&self, _: &[u8]) -> Result<(), Refusal> {
        Ok(())
    }
    fn judge_cfg(&self, configuration: &[u8], user_prm: &[u8]) -> Result<(), Refusal> {
        Fixed { configurations: &[self.0], ..Fixed::PLAIN }.judge_cfg(configuration, user_prm)
    }
    fn configuration<'a>(&'a self, _: Option<&'a [u8]>) -> &'a [u8] {
        self.0
    }
}

fn request(sap: Option<u8>, data: &[u8]) -> Request<'_> {
    let address = Address::from_octet;
    let (dsap, ssap) = (sap.and_then(Sap::new), sap.and(Sap::new(62)));
    Request { da: address(5), sa: address(MASTER), dsap, ssap, data }
}

fn in_data_exchange(configuration: &'static [u8]) -> Slave<Exactly> {
    let mut slave = slave(configuration);
    slave.handle_srd(Instant::ZERO, &request(Some(61), &[0x80, 1, 1, 11, 0x12, 0x34, 0]));
    slave.handle_srd(Instant::ZERO, &request(Some(62), configuration));
    assert_eq!(slave.state(), State::DataExch);
    slave
}

#[test]
fn p_12_sync_or_freeze_without_support_is_shown_and_does_not_stop_the_start_up() {
    for status in [0xA0, 0x90] {
        let mut slave = slave(CFG);
        slave.handle_srd(Instant::ZERO, &request(Some(61), &[status, 1, 1, 11, 0x12, 0x34, 0]));
        assert!(slave.diagnosis().not_supported);
        assert_eq!(slave.state(), State::WaitCfg);
        slave.handle_srd(Instant::ZERO, &request(Some(61), &[0x80, 1, 1, 11, 0x12, 0x34, 0]));
        assert!(!slave.diagnosis().not_supported, "cleared by the next good Set_Prm");
    }
}

#[test]
fn x_06_input_only_output_only_and_neither() {
    for (configuration, outputs, reply) in [
        (&[0x13], &[][..], Reply::DataLow(&[9, 9, 9, 9])),
        (&[0x23], &[1, 2, 3, 4], Reply::ShortAcknowledge),
        (&[0x00], &[], Reply::ShortAcknowledge),
    ] {
        let mut slave = in_data_exchange(configuration);
        slave.set_inputs(&[9, 9, 9, 9]);
        let handled = slave.handle_srd(Instant::ZERO, &request(None, outputs));
        assert_eq!((handled.reply, handled.exchanged), (reply, true));
        assert_eq!(slave.outputs(), outputs);
    }
}

#[test]
fn inputs_never_offered_are_zero() {
    let mut slave = in_data_exchange(CFG);
    let handled = slave.handle_srd(Instant::ZERO, &request(None, &[1, 2, 3, 4]));
    assert_eq!(handled.reply, Reply::DataLow(&[0; 4]));
}

#[test]
fn a_service_by_the_wrong_kind_of_request_has_no_effect() {
    let mut slave = in_data_exchange(CFG);
    slave.handle_srd(Instant::ZERO, &request(None, &[1, 2, 3, 4]));
    let handled = slave.handle_srd(Instant::ZERO, &request(Some(58), &[0x02, 0x00]));
    assert_eq!(handled.reply, Reply::NotActivated, "Global_Control as SRD");
    assert_eq!(
        slave.handle_sdn(Instant::ZERO, &request(Some(61), &[0x40, 0, 0, 0, 0, 0, 0])),
        None,
        "Set_Prm as SDN"
    );
    assert_eq!((slave.state(), slave.outputs()), (State::DataExch, &[1, 2, 3, 4][..]));
}

#[test]
fn g_07_a_configuration_that_no_slave_can_exchange_is_a_fault_although_the_application_accepts_it() {
    for (configuration, expected) in [
        (&[0xC0, 0x7F, 0x7F, 0xC0, 0x7F, 0x7F][..], CfgSyntax::TooLong { got: 256 }),
        (&[0xC0, 0x00], CfgSyntax::CutOff),
    ] {
        let mut slave = slave(configuration);
        slave.handle_srd(Instant::ZERO, &request(Some(61), &[0x80, 1, 1, 11, 0x12, 0x34, 0]));
        let handled = slave.handle_srd(Instant::ZERO, &request(Some(62), configuration));
        let fault = CfgFault::Impossible(expected);
        let master = Address::from_octet(MASTER);
        assert_eq!(
            (handled.reply, handled.event),
            (Reply::ShortAcknowledge, Some(Event::CfgRejected { master, fault }))
        );
        assert!(slave.diagnosis().cfg_fault && slave.state() == State::WaitPrm);
    }
}
