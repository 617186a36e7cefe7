//! Two axes in one program, over the session that a real line has, in virtual time.

use profidrive::bench::Port;
use profidrive::client::{DriveClient, Goal, GoalError};
use profidrive::devices::ag03::profibus::Config;
use profidrive::host::Stop;
use profidrive::master::{Axes, Session, SessionError, Settings};
use profidrive::profibus::fdl::Address;
use profidrive::time::BaudRate;

const AXES: [Address; 2] = [Address::from_octet(5), Address::from_octet(6)];

fn axes() -> (Port, Axes<Port, Port>) {
    let port = Port::new(BaudRate::K500);
    for axis in AXES {
        port.line(|line| line.add_drive(Config::new(axis)).unwrap());
    }
    let settings = Settings::untimed(Address::from_octet(2), BaudRate::K500);
    let session = Session::new(port.clone(), port.clone(), Stop::new().unwrap(), settings).unwrap();
    let mut axes = Axes::new(session);
    for axis in AXES {
        axes.add(axis, DriveClient::default()).unwrap();
    }
    (port, axes)
}

fn position(port: &Port, axis: Address) -> i32 {
    port.line(|line| line.device(axis.number()).unwrap().status().position)
}

#[test]
fn two_axes_work_off_their_queues_at_the_same_time() {
    let (port, mut axes) = axes();
    let [width, height] = AXES;
    assert!(axes.queue(width, [Goal::Enable, Goal::MoveTo(800), Goal::MoveTo(-300), Goal::Disable]));
    assert!(axes.queue(height, [Goal::Enable, Goal::MoveTo(200), Goal::Disable]));
    assert!(!axes.queue(Address::from_octet(7), [Goal::Enable]), "there is no such axis");
    let over = axes.run().unwrap();
    let of = |axis| over.iter().filter(move |(of, _)| *of == axis).map(|(_, outcome)| outcome.goal);
    assert!(over.iter().all(|(_, outcome)| outcome.result.is_ok()), "{over:?}");
    let (disabled, moved) = (
        over.iter().position(|(axis, outcome)| (*axis, outcome.goal) == (height, Goal::Disable)).unwrap(),
        over.iter().position(|(axis, outcome)| (*axis, outcome.goal) == (width, Goal::MoveTo(800))).unwrap(),
    );
    assert!(disabled < moved, "the short way is over before the long one: {over:?}");
    assert!(of(width).eq([Goal::Enable, Goal::MoveTo(800), Goal::MoveTo(-300), Goal::Disable]));
    assert!(of(height).eq([Goal::Enable, Goal::MoveTo(200), Goal::Disable]));
    assert!((position(&port, width) + 300).abs() <= 5 && (position(&port, height) - 200).abs() <= 5);
    port.line(|line| line.assert_no_breach());
    axes.release().unwrap();
}

#[test]
fn a_goal_that_fails_ends_its_queue_and_no_other() {
    let (port, mut axes) = axes();
    let [width, height] = AXES;
    axes.queue(width, [Goal::Enable, Goal::MoveTo(9_999_999), Goal::MoveTo(100)]);
    axes.queue(height, [Goal::Enable, Goal::MoveTo(200)]);
    let over = axes.run().unwrap();
    let failed: Vec<_> = over.iter().filter(|(_, outcome)| outcome.result.is_err()).collect();
    let [(axis, outcome)] = failed[..] else { panic!("{over:?}") };
    assert_eq!((*axis, outcome.goal), (width, Goal::MoveTo(9_999_999)));
    assert!(matches!(outcome.result, Err(GoalError::Refused(_))), "{outcome:?}");
    assert_eq!((over.len(), position(&port, width)), (4, 0));
    assert!((position(&port, height) - 200).abs() <= 5);
}

#[test]
fn a_drive_that_is_lost_is_told_by_its_address() {
    let (port, mut axes) = axes();
    port.line(|line| line.inject(&["no-reply,station=6".parse().unwrap()]).unwrap());
    let error = loop {
        if let Err(error) = axes.cycle() {
            break error;
        }
    };
    assert!(matches!(error, SessionError::Silent { address } if address == AXES[1]), "{error}");
}
