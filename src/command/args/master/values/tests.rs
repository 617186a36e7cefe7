use super::*;

#[test]
fn times_are_read_as_they_are_written() {
    assert_eq!(time("1.5s"), Ok(Duration::from_millis(1500)));
    assert_eq!(time("20ms"), Ok(Duration::from_millis(20)));
    for wrong in ["", "5", "s", "-1s", "1e99s", "2m", "nans"] {
        assert!(time(wrong).is_err(), "{wrong}");
    }
    assert!(watchdog("9ms").is_err() && watchdog("651s").is_err() && watchdog("10ms").is_ok());
}
