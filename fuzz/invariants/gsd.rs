//! A device file of a stranger and a configuration of a master: reading never fails but with a place, the description
//! stays within what Set_Prm and Slave_Diag can hold, and an accepted configuration is the modules it was split into.

use profidrive::gsd::{Gsd, Policy, Station};
use profidrive::profibus::dp::{Application, IoLengths};

/// One octet with the length of the configuration, the configuration, the file.
pub(crate) fn check(data: &[u8]) {
    let Some((&len, rest)) = data.split_first() else { return };
    let (configuration, file) = rest.split_at(usize::from(len).min(rest.len()).min(244));
    let gsd = match Gsd::read(file) {
        Ok(gsd) => gsd,
        Err(error) => {
            assert!(error.to_string().starts_with("line "), "{error}");
            return;
        }
    };
    assert_eq!(Gsd::read(file).as_ref(), Ok(&gsd), "reading is the same again");
    let (least, most) = gsd.user_prm_lengths();
    assert!(least <= most && most <= 237);
    for module in &gsd.modules {
        assert_eq!(IoLengths::of(&module.identifiers), Ok(module.lengths));
        assert!(module.place.line > 1 && module.place.column > 0);
    }
    for policy in [Policy::PROPOSED, Policy::STRICT] {
        let Ok(station) = Station::new(gsd.clone(), policy) else { continue };
        let description = station.description();
        assert!((6..=244).contains(&description.max_diag_len));
        assert!(station.configuration(None).len() <= 244);
        for cfg in [configuration, station.configuration(None)] {
            match station.modules(cfg, None) {
                Ok(plugged) if gsd.modules.is_empty() => assert!(plugged.is_empty()),
                Ok(plugged) => {
                    let octets = plugged.iter().flat_map(|modules| match modules.first() {
                        Some(module) => gsd.modules[*module].identifiers.clone(),
                        None => vec![0],
                    });
                    assert_eq!(octets.collect::<Vec<_>>(), cfg);
                    let modules: Vec<_> =
                        plugged.iter().filter_map(|modules| modules.first().copied()).collect();
                    let user_prm = gsd.default_user_prm(&modules);
                    station.remarks(cfg, &user_prm);
                    // The user parameters decide between readings, they refuse none.
                    assert!(station.modules(cfg, Some(&user_prm)).is_ok());
                    assert!(station.modules(cfg, Some(configuration)).is_ok());
                }
                Err(refusal) => {
                    assert!(refusal.index <= cfg.len());
                    assert_eq!(refusal.got, cfg.get(refusal.index).copied());
                }
            }
            let _ = station.judge_prm(cfg);
            let _ = station.judge_cfg(cfg, configuration);
        }
    }
}
