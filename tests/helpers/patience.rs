//! How long a test waits.

use std::time::Duration;

/// For what must come, on a machine that is busy with other tests: only a test that fails waits so long.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);
