use core::time::Duration;

use super::*;

/// A client and the drive that it has: it answers by the words alone, two images late.
struct Pair {
    client: PpoClient,
    now: Instant,
    /// The status words and actual values on their way.
    late: [(u16, i16); 2],
}

impl Pair {
    fn new(kind: PpoType) -> Self {
        let client = PpoClient::new(kind, Profile::PROFIDRIVE, PpoLimits::default());
        Self { client, now: Instant::ZERO, late: [(0x0270, 0); 2] }
    }

    /// One exchange with a drive that shows this next.
    fn exchange(&mut self, zsw: u16, actual: i16) -> Option<PpoOutcome> {
        self.now = self.now.saturating_add(Duration::from_millis(1));
        let [(shown, speed), next] = self.late;
        self.late = [next, (zsw, actual)];
        let mut inputs = std::vec![0; if self.client.kind().has_pkw() { 8 } else { 0 }];
        inputs.extend(shown.to_be_bytes());
        inputs.extend(speed.to_be_bytes());
        inputs.resize(self.client.kind().len(), 0);
        assert!(self.client.handle_inputs(self.now, &inputs));
        self.client.poll_outcome()
    }

    fn octets(&self) -> std::vec::Vec<u8> {
        self.client.outputs(&mut [0; PpoClient::MOST]).to_vec()
    }

    /// So many exchanges, in which the goal does not end.
    fn goes_on(&mut self, zsw: u16, actual: i16, times: u32) {
        for _ in 0..times {
            assert_eq!(self.exchange(zsw, actual), None);
        }
    }

    fn ends(&mut self, zsw: u16, actual: i16) -> Result<i16, PpoGoalError> {
        (0..10).find_map(|_| self.exchange(zsw, actual)).expect("no end").result
    }
}

#[test]
fn a_drive_runs_by_off1_operation_and_setpoint() {
    for kind in PpoType::ALL.into_iter().filter(|kind| *kind != PpoType::SevenWords) {
        let mut pair = Pair::new(kind);
        let pzd = if kind.has_pkw() { 8 } else { 0 };
        pair.client.pursue(pair.now, PpoGoal::Run(-0x2000));
        assert_eq!(pair.octets().len(), kind.len());
        // Inhibited for as long as it likes.
        pair.goes_on(0x0270, 0, 20);
        assert_eq!(pair.client.stw().raw(), 0x047E);
        pair.goes_on(0x0231, 0, 4);
        assert_eq!((pair.client.stw().raw(), pair.octets()[pzd + 2]), (0x047F, 0), "no setpoint yet");
        pair.goes_on(0x0337, 0, 6);
        assert_eq!(pair.octets()[pzd..pzd + 4], [0x04, 0x7F, 0xE0, 0x00], "{kind}");
        pair.goes_on(0x0337, -0x1000, 6);
        assert_eq!(pair.ends(0x0337, -0x1F00), Ok(-0x1F00));
        // Another speed needs no OFF1.
        pair.client.pursue(pair.now, PpoGoal::Run(0x1000));
        assert_eq!(pair.client.stw().raw(), 0x047F);
        assert_eq!(pair.ends(0x0337, 0x1000), Ok(0x1000));
        pair.client.pursue(pair.now, PpoGoal::Disable);
        pair.goes_on(0x0333, 0x0800, 6);
        assert_eq!(pair.ends(0x0231, 0), Ok(0));
        assert_eq!(pair.client.stw().raw(), 0x047E);
    }
}

#[test]
fn an_old_status_word_ends_nothing() {
    let mut pair = Pair::new(PpoType::Ppo3);
    pair.late = [(0x0231, 0); 2];
    pair.client.pursue(pair.now, PpoGoal::Disable);
    // Those of before the control word.
    for _ in 0..STALE_IMAGES {
        assert_eq!(pair.exchange(0x0337, 0), None);
    }
    pair.goes_on(0x0337, 0, 5);
    assert_eq!(pair.ends(0x0231, 0), Ok(0));
}

#[test]
fn a_fault_ends_a_goal_and_is_acknowledged_by_an_edge() {
    let mut pair = Pair::new(PpoType::Ppo1);
    pair.client.pursue(pair.now, PpoGoal::Run(0x4000));
    assert_eq!(pair.ends(0x0238, 0), Err(PpoGoalError::Fault));
    assert_eq!(pair.client.stw().raw(), 0x047E);
    pair.client.pursue(pair.now, PpoGoal::Acknowledge);
    assert_eq!(pair.client.stw().raw(), 0x04FE);
    pair.goes_on(0x0238, 0, 10);
    assert_eq!(pair.ends(0x0270, 0), Ok(0));
    assert_eq!(pair.client.stw().raw(), 0x047E, "the next edge is one again");
}

#[test]
fn what_does_not_come_is_told_with_what_stands_against_it() {
    let mut pair = Pair::new(PpoType::Ppo1);
    pair.client.pursue(pair.now, PpoGoal::Enable);
    pair.goes_on(0x0240, 0, 10);
    pair.now = pair.client.poll_timeout().unwrap();
    let error = pair.ends(0x0240, 0).unwrap_err();
    let said = std::string::ToString::to_string(&error);
    assert!(said.contains("STW 047E, ZSW 0240") && said.contains("; OFF2: set STW bit 1"), "{said}");
    pair.client.pursue(pair.now, PpoGoal::Run(0x4000));
    pair.client.handle_data_exchange_lost();
    let lost = pair.client.poll_outcome().map(|outcome| outcome.result);
    assert_eq!(lost, Some(Err(PpoGoalError::Interrupted)));
    let mut silent = PpoClient::new(PpoType::Ppo1, Profile::PROFIDRIVE, PpoLimits::default());
    silent.pursue(Instant::ZERO, PpoGoal::Enable);
    silent.handle_timeout(silent.poll_timeout().unwrap());
    assert_eq!(silent.poll_outcome().map(|outcome| outcome.result), Some(Err(PpoGoalError::NoInputs)));
}

#[test]
fn a_drive_that_leaves_operation_is_not_asked_again() {
    let mut pair = Pair::new(PpoType::Ppo4);
    pair.client.pursue(pair.now, PpoGoal::Run(0x4000));
    pair.goes_on(0x0231, 0, 8);
    pair.goes_on(0x0337, 0, 8);
    assert!(matches!(pair.ends(0x0231, 0), Err(PpoGoalError::Ended { .. })));
    assert_eq!(pair.client.stw().raw(), 0x047E);
    assert!(
        pair.client.submit(pair.now, Job::read(crate::devices::ag03::param::Pnu::from_low_bits(1))).is_err()
    );
    assert!(!pair.client.handle_inputs(pair.now, &[0; 4]), "PPO 4 has twelve octets");
}
