use super::*;

#[test]
fn a_station_is_what_is_configured() {
    let station: JudgedStation =
        "5,ident=1234,cfg=2313,prm=0102,groups=01,failsafe=1,min-interval=2.5,watchdog=500,absent,dpv1"
            .parse()
            .unwrap();
    let Slave { address, ident, cfg, prm, groups, fail_safe, min_interval, watchdog, absent, dpv1, gsd: _ } =
        station.slave;
    assert_eq!((address.number(), ident, cfg, prm), (5, 0x1234, Some(vec![0x23, 0x13]), Some(vec![1, 2])));
    assert_eq!((groups, fail_safe, absent, dpv1), (Some(1), true, true, true));
    assert_eq!(min_interval, Some(Duration::from_micros(2500)));
    assert_eq!(watchdog, Some(Duration::from_millis(500)));
    for (spec, part) in [
        ("5", "ident and cfg must be given"),
        ("5,ident=12345,cfg=23", "does not fit ident"),
        ("5,ident=1234,cfg=2", "does not fit cfg"),
        ("5,ident=1234,cfg=", "does not fit cfg"),
        ("5,ident=1234,cfg=C0", "cut off"),
        ("5,ident=1234,cfg=23,groups=0102", "does not fit groups"),
        ("5,ident=1234,cfg=23,often", "'often' is not understood"),
        ("5,gsd=x,ident=1234", "in the device file already"),
        ("127,ident=1234,cfg=23", "outside 0 to 126"),
    ] {
        let error = spec.parse::<JudgedStation>().unwrap_err();
        assert!(error.contains(part), "{spec}: {error}");
    }
}
