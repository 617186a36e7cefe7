//! The DP master as profirust's token calls it.

use core::cell::RefCell;

use profirust::dp::DpMaster;
use profirust::fdl::{FdlActiveStation, FdlApplication, Telegram, TelegramTx, TelegramTxResponse};

/// One turn of the DP master while it has the token. Several of them are several cycles.
#[derive(Clone, Copy)]
pub(super) struct Turn<'a> {
    pub(super) dp: &'a RefCell<DpMaster<'static>>,
    pub(super) passes: bool,
}

impl FdlApplication for Turn<'_> {
    fn transmit_telegram(
        &mut self,
        now: profirust::time::Instant,
        fdl: &FdlActiveStation,
        tx: TelegramTx<'_>,
        high_prio_only: bool,
    ) -> Option<TelegramTxResponse> {
        if self.passes {
            return None;
        }
        self.dp.borrow_mut().transmit_telegram(now, fdl, tx, high_prio_only)
    }

    fn receive_reply(
        &mut self,
        now: profirust::time::Instant,
        fdl: &FdlActiveStation,
        address: u8,
        telegram: Telegram<'_>,
    ) {
        self.dp.borrow_mut().receive_reply(now, fdl, address, telegram);
    }

    fn handle_timeout(&mut self, now: profirust::time::Instant, fdl: &FdlActiveStation, address: u8) {
        self.dp.borrow_mut().handle_timeout(now, fdl, address);
    }
}
