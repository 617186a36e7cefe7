use super::*;
use crate::can_bus::can::{Id, timing};

const NOW: Instant = Instant::ZERO;

fn base(number: u16) -> Id {
    Id::base(number).unwrap()
}

fn frame(id: u16) -> Frame {
    Frame::with(base(id), [0x55; 8])
}

fn bus() -> Bus<u8> {
    let mut bus = Bus::new(BitRate::K1000);
    bus.watch(true);
    bus
}

/// Runs the bus until nothing happens by itself any more, at most until `end`.
fn run(bus: &mut Bus<u8>, end: Instant) {
    while let Some(due) = bus.poll_timeout().filter(|due| *due <= end) {
        bus.handle_timeout(due);
    }
    bus.handle_timeout(end);
}

fn heard(bus: &mut Bus<u8>, seat: Seat) -> Vec<Frame> {
    core::iter::from_fn(|| bus.poll_heard(seat)).map(|heard| heard.frame).collect()
}

fn micros(frame: &Frame) -> u64 {
    u64::from(timing::bits(frame))
}

/// Answers each frame with its identifier plus one, and counts.
struct Echo {
    queue: VecDeque<Frame>,
    heard: u8,
    states: Vec<ErrorState>,
    /// Wants to be called at once as long as it has frames.
    eager: bool,
}

impl Echo {
    fn new() -> Box<Self> {
        Box::new(Self { queue: VecDeque::new(), heard: 0, states: Vec::new(), eager: false })
    }
}

impl CanParticipant for Echo {
    type Event = u8;

    fn handle_frame(&mut self, _: Instant, frame: &Frame) {
        self.heard += 1;
        if let Id::Base(id) = frame.id() {
            self.queue.push_back(super::tests::frame(id.number() + 1));
        }
    }
    fn handle_timeout(&mut self, _: Instant) {}
    fn set_error_state(&mut self, _: Instant, state: ErrorState) {
        self.states.push(state);
    }
    fn poll_transmit(&mut self, _: Instant) -> Option<Frame> {
        self.queue.pop_front()
    }
    fn poll_event(&mut self) -> Option<u8> {
        match core::mem::take(&mut self.heard) {
            0 => None,
            heard => Some(heard),
        }
    }
    fn poll_timeout(&self) -> Option<Instant> {
        (self.eager && !self.queue.is_empty()).then_some(NOW)
    }
}

#[test]
fn frames_offered_at_one_instant_go_out_lowest_identifier_first_and_nobody_hears_himself() {
    let mut bus = bus();
    let seats: Vec<Seat> = (0..4).map(|_| bus.connect(NOW)).collect();
    // The first one finds the bus free; the others wait for it.
    for (seat, id) in seats.iter().zip([0x700, 0x305, 0x080, 0x181]) {
        bus.send(NOW, *seat, frame(id)).unwrap();
    }
    run(&mut bus, Instant::from_millis(1));
    let all = [frame(0x700), frame(0x080), frame(0x181), frame(0x305)];
    for (seat, own) in seats.iter().zip([0, 3, 1, 2]) {
        let others: Vec<_> =
            all.iter().enumerate().filter(|(place, _)| *place != own).map(|(_, frame)| *frame).collect();
        assert_eq!(heard(&mut bus, *seat), others);
    }
    let mut ends = Vec::new();
    while let Some(event) = bus.poll_event() {
        let Event::Passed { at, .. } = event else { panic!("{event:?}") };
        ends.push(at.as_nanos() / 1000);
    }
    let mut end = 0;
    let expected: Vec<u64> = all
        .iter()
        .map(|frame| {
            let this = end + micros(frame);
            end = this + 3;
            this
        })
        .collect();
    assert_eq!(ends, expected, "three bits between two frames");
    assert!(bus.take_notes(seats[3]).arbitration_lost);
    assert!(!bus.take_notes(seats[0]).arbitration_lost);
}

#[test]
fn a_port_sends_in_its_own_order() {
    let mut bus = bus();
    let (one, other) = (bus.connect(NOW), bus.connect(NOW));
    for id in [0x300, 0x100, 0x200] {
        bus.send(NOW, one, frame(id)).unwrap();
    }
    run(&mut bus, Instant::from_millis(1));
    assert_eq!(heard(&mut bus, other), [frame(0x300), frame(0x100), frame(0x200)]);
    assert!(bus.is_idle(one));
}

#[test]
fn participants_answer_and_their_news_arrive() {
    let mut bus = bus();
    let master = bus.connect(NOW);
    let echo = bus.add(NOW, Echo::new());
    bus.send(NOW, master, frame(0x100)).unwrap();
    run(&mut bus, Instant::from_millis(1));
    assert_eq!(heard(&mut bus, master), [frame(0x101)]);
    let news: Vec<_> = core::iter::from_fn(|| bus.poll_event())
        .filter(|event| matches!(event, Event::Participant { .. }))
        .collect();
    assert_eq!(news, [Event::Participant { seat: echo, event: 1 }]);
    bus.with(Instant::from_millis(1), echo, |echo: &mut Echo, now| {
        assert_eq!(now, Instant::from_millis(1));
        echo.queue.push_back(frame(0x7FF));
    });
    run(&mut bus, Instant::from_millis(2));
    assert_eq!(heard(&mut bus, master), [frame(0x7FF)]);
}

#[test]
fn a_station_that_always_wants_to_be_called_at_once_does_not_stop_time() {
    let mut bus = bus();
    let master = bus.connect(NOW);
    let mut echo = Echo::new();
    echo.eager = true;
    echo.queue.extend((0..20).map(frame));
    bus.add(NOW, echo);
    run(&mut bus, Instant::from_millis(5));
    assert_eq!(heard(&mut bus, master).len(), 20);
}

#[test]
fn who_calls_late_finds_the_same_frames_at_the_same_times() {
    let play = |late: bool| {
        let mut bus = bus();
        let (one, other) = (bus.connect(NOW), bus.connect(NOW));
        for id in 0..50 {
            bus.send(NOW, one, frame(id)).unwrap();
        }
        if late {
            bus.handle_timeout(Instant::from_millis(20));
        } else {
            run(&mut bus, Instant::from_millis(20));
        }
        core::iter::from_fn(|| bus.poll_heard(other)).collect::<Vec<_>>()
    };
    assert_eq!(play(true), play(false));
    assert_eq!(play(true).len(), 50);
}

#[test]
fn the_load_is_the_time_of_the_bits() {
    let mut bus = bus();
    let one = bus.connect(NOW);
    bus.connect(NOW);
    let before = *bus.counters();
    let remote = Frame::remote(base(0x705), 1).unwrap();
    for frame in [frame(1), frame(2), remote] {
        bus.send(NOW, one, frame).unwrap();
    }
    run(&mut bus, Instant::from_millis(1));
    let bits = micros(&frame(1)) + micros(&frame(2)) + micros(&remote);
    assert_eq!(bus.counters().busy, Duration::from_micros(bits));
    assert_eq!((bus.counters().frames, bus.counters().remote), (3, 1));
    let load = bus.counters().load_since(&before, Duration::from_millis(1));
    assert!((load - bits as f64 / 1000.0).abs() < 1e-9, "{load}");
}

#[test]
fn an_error_frame_is_counted_by_everybody_and_the_frame_is_sent_again() {
    let mut bus = bus();
    let (one, other) = (bus.connect(NOW), bus.connect(NOW));
    bus.faults_mut().add(NOW, "frame-damaged,count=1".parse().unwrap());
    bus.send(NOW, one, frame(5)).unwrap();
    run(&mut bus, Instant::from_millis(1));
    assert_eq!(heard(&mut bus, other), [frame(5)]);
    // 8 - 1, and 1 - 1.
    assert_eq!(bus.confinement(one).unwrap().transmit_errors(), 7);
    assert_eq!(bus.confinement(other).unwrap().receive_errors(), 0);
    assert_eq!((bus.counters().errors, bus.counters().frames), (1, 1));
    assert!(bus.take_notes(one).bus_error && bus.take_notes(other).bus_error);
    let damaged = Event::Damaged {
        at: Instant::from_micros(micros(&frame(5)) / 2 + 20),
        from: one,
        frame: frame(5),
        damage: Damage::Bit,
    };
    assert_eq!(bus.poll_event(), Some(damaged));
}

#[test]
fn a_sender_of_damaged_frames_becomes_passive_then_bus_off_and_comes_back() {
    let mut bus = bus();
    let master = bus.connect(NOW);
    let echo = bus.add(NOW, Echo::new());
    bus.faults_mut().add(NOW, "frame-damaged,count=32,id=101".parse().unwrap());
    bus.send(NOW, master, frame(0x100)).unwrap();
    run(&mut bus, Instant::from_millis(100));
    let states = bus.with(Instant::from_millis(100), echo, |echo: &mut Echo, _| echo.states.clone()).unwrap();
    assert_eq!(states, [ErrorState::Passive, ErrorState::BusOff, ErrorState::Active]);
    assert_eq!(heard(&mut bus, master), [], "the frame was lost with bus off");
    // 16 errors, then 16 more, then 128 times 11 bits.
    let times: Vec<_> = core::iter::from_fn(|| bus.poll_event())
        .filter_map(|event| {
            let Event::State { at, seat, .. } = event else { return None };
            (seat == echo).then_some(at)
        })
        .collect();
    assert_eq!(times[2].saturating_since(times[1]), Duration::from_micros(128 * 11));
    bus.send(Instant::from_millis(100), master, frame(0x200)).unwrap();
    run(&mut bus, Instant::from_millis(101));
    assert_eq!(heard(&mut bus, master), [frame(0x201)]);
}

#[test]
fn a_station_that_is_bus_off_hears_and_sends_nothing() {
    let mut bus = bus();
    let (one, other) = (bus.connect(NOW), bus.connect(NOW));
    bus.provoke(NOW, other, ErrorState::BusOff);
    assert_eq!(bus.send(NOW, other, frame(1)), Err(Full));
    assert!(!bus.has_room(other));
    bus.send(NOW, one, frame(2)).unwrap();
    run(&mut bus, Instant::from_millis(1));
    assert_eq!(heard(&mut bus, other), []);
    run(&mut bus, Instant::from_millis(2));
    bus.send(Instant::from_millis(2), other, frame(1)).unwrap();
}

#[test]
fn without_acknowledge_a_sender_becomes_passive_and_tries_on() {
    let mut bus = bus();
    let one = bus.connect(NOW);
    let fault = bus.faults_mut().add(NOW, "frame-not-acknowledged".parse().unwrap());
    bus.send(NOW, one, frame(1)).unwrap();
    run(&mut bus, Instant::from_millis(100));
    assert_eq!(bus.confinement(one).unwrap().state(), ErrorState::Passive);
    assert!(bus.counters().errors > 500);
    bus.faults_mut().remove(fault);
    let other = bus.connect(Instant::from_millis(100));
    run(&mut bus, Instant::from_millis(101));
    assert_eq!(heard(&mut bus, other), [frame(1)]);
}

#[test]
fn frames_are_lost_late_and_doubled() {
    for (kind, expected) in
        [("frame-lost", vec![2]), ("frame-twice", vec![1, 1, 2]), ("frame-late=1ms", vec![2, 1])]
    {
        let mut bus = bus();
        let (one, other) = (bus.connect(NOW), bus.connect(NOW));
        bus.faults_mut().add(NOW, format!("{kind},id=001").parse().unwrap());
        bus.send(NOW, one, frame(1)).unwrap();
        bus.send(NOW, one, frame(2)).unwrap();
        run(&mut bus, Instant::from_millis(3));
        let ids: Vec<_> = heard(&mut bus, other).iter().map(|frame| frame.id().number()).collect();
        assert_eq!(ids, expected, "{kind}");
        assert_eq!(heard(&mut bus, one), [], "{kind}: nobody hears himself, not even late");
        assert_eq!(bus.faults_mut().iter().map(|listed| listed.injected).sum::<u32>(), 1);
    }
}

#[test]
fn what_nobody_takes_is_bounded() {
    let mut bus = bus();
    let (one, other) = (bus.connect(NOW), bus.connect(NOW));
    let mut now = NOW;
    for _ in 0..200 {
        while bus.send(now, one, frame(1)).is_ok() {}
        now = now.saturating_add(Duration::from_millis(10));
        run(&mut bus, now);
    }
    let taken = heard(&mut bus, other).len() as u64;
    let notes = bus.take_notes(other);
    assert_eq!(taken + notes.overruns, bus.counters().frames);
    assert!(notes.overruns > 0);
}

#[test]
fn a_process_that_slept_for_an_hour_goes_on_at_once() {
    let mut bus = bus();
    let master = bus.connect(NOW);
    struct Ticker(Instant, u32);
    impl CanParticipant for Ticker {
        type Event = u8;
        fn handle_frame(&mut self, _: Instant, _: &Frame) {}
        fn handle_timeout(&mut self, now: Instant) {
            if now >= self.0 {
                self.0 = now.saturating_add(Duration::from_millis(1));
                self.1 += 1;
            }
        }
        fn set_error_state(&mut self, _: Instant, _: ErrorState) {}
        fn poll_transmit(&mut self, _: Instant) -> Option<Frame> {
            None
        }
        fn poll_event(&mut self) -> Option<u8> {
            None
        }
        fn poll_timeout(&self) -> Option<Instant> {
            Some(self.0)
        }
    }
    let ticker = bus.add(NOW, Box::new(Ticker(Instant::from_millis(1), 0)));
    bus.handle_timeout(Instant::from_millis(50));
    assert_eq!(bus.participant::<Ticker>(ticker).unwrap().1, 50);
    bus.handle_timeout(Instant::from_millis(3_600_000));
    let ticks = bus.participant::<Ticker>(ticker).unwrap().1;
    assert!((150..=152).contains(&ticks), "{ticks}");
    assert!(bus.send(Instant::from_millis(3_600_000), master, frame(1)).is_ok());
}

/// A bus with a port that sends, and a station that answers each frame with the next identifier.
fn asked(rate: BitRate) -> (Bus<u8>, Seat) {
    let mut bus = Bus::new(rate);
    let port = bus.connect(NOW);
    bus.add(NOW, Echo::new());
    bus.send(NOW, port, frame(0x200)).unwrap();
    (bus, port)
}

#[test]
fn ahead_of_the_clock_the_end_of_the_answer_is_known_and_nothing_comes_earlier() {
    let (mut bus, port) = asked(BitRate::K1000);
    let request = bus.poll_timeout().unwrap();
    assert_eq!(bus.poll_noticed(), Some(request));
    bus.look_ahead();
    let answer = request.saturating_add(Duration::from_micros(3 + micros(&frame(0x201))));
    assert_eq!(bus.poll_noticed(), Some(answer), "the next thing that a port can notice");
    // Once ahead, not further.
    bus.look_ahead();
    assert_eq!((bus.poll_noticed(), heard(&mut bus, port)), (Some(answer), Vec::new()));
    bus.handle_timeout(answer);
    assert_eq!(bus.poll_heard(port).map(|heard| (heard.at, heard.frame)), Some((answer, frame(0x201))));
}

#[test]
fn what_a_port_sends_meanwhile_takes_part_in_the_arbitration() {
    let (mut bus, port) = asked(BitRate::K1000);
    let request = bus.poll_timeout().unwrap();
    bus.look_ahead();
    let late = bus.connect(NOW);
    bus.send(Instant::from_micros(50), late, frame(0x100)).unwrap();
    run(&mut bus, Instant::from_millis(2));
    let first = bus.poll_heard(port).unwrap();
    assert_eq!(first.frame, frame(0x100), "the lower identifier wins");
    assert_eq!(first.at, request.saturating_add(Duration::from_micros(3 + micros(&frame(0x100)))));
    assert_eq!(heard(&mut bus, port)[..], [frame(0x201), frame(0x101)]);
}

#[test]
fn the_bus_is_not_taken_ahead_when_somebody_would_hear_it_too_early() {
    let ahead = |bus: &mut Bus<u8>| {
        let before = bus.poll_timeout();
        bus.look_ahead();
        bus.poll_timeout() != before
    };
    let (mut bus, _) = asked(BitRate::K1000);
    assert!(ahead(&mut bus));
    let (mut bus, _) = asked(BitRate::K1000);
    let closed = bus.connect(NOW);
    bus.listen(closed, false);
    assert!(ahead(&mut bus), "an adapter that is closed hears nothing");
    let (mut bus, _) = asked(BitRate::K1000);
    bus.connect(NOW);
    assert!(!ahead(&mut bus), "another port hears the request");
    let (mut bus, port) = asked(BitRate::K1000);
    run(&mut bus, Instant::from_micros(200));
    assert!(bus.is_idle(port) && !ahead(&mut bus), "the answer of the station is heard");
    let (mut bus, _) = asked(BitRate::from_bits_per_second(50_000).unwrap());
    assert!(!ahead(&mut bus), "a frame of two milliseconds is too far ahead");
}

#[test]
fn a_fault_may_end_a_frame_early_so_its_beginning_counts() {
    let (mut bus, _) = asked(BitRate::K1000);
    bus.faults_mut().add(NOW, "frame-damaged,id=7ff".parse().unwrap());
    bus.look_ahead();
    assert_eq!(bus.poll_noticed(), bus.poll_timeout());
}
