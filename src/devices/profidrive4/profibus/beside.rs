//! What masters reach beside the cyclic exchange, as panel and page show it.

use super::ProfidriveDevice;
use super::application::TelegramOnly;
use crate::face::Reason;
use crate::face::acyclic::{Acyclic, OwnersChannel, SERVICE_REFUSED};
use crate::profibus::dp::Application;
use crate::profibus::dpv1::Link;

impl<A: Application> Acyclic for ProfidriveDevice<TelegramOnly<A>> {
    fn channel(&self) -> OwnersChannel {
        OwnersChannel { open: self.acyclic.is_open(), busy: self.acyclic.is_busy() }
    }

    fn each_obstacle(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        self.acyclic
            .each_obstacle(self.slave(), &mut |obstacle| tell(Reason::new(obstacle.name(), &obstacle)));
        if let Some(event) = self.refused.event() {
            tell(Reason::new(SERVICE_REFUSED, event));
        }
        if let Some(event) = &self.not_done {
            tell(Reason::new("ParameterRefused", event));
        }
    }

    fn each_link(&self, tell: &mut dyn FnMut(Link)) {
        self.acyclic.links().for_each(tell);
    }

    fn most_links(&self) -> u8 {
        self.acyclic.offer().ms2.map_or(0, |ms2| ms2.connections)
    }

    fn each_identification(&self, tell: &mut dyn FnMut(u16, &[u8; 64], bool)) {
        tell(0, &self.identification.octets(), false);
    }
}
