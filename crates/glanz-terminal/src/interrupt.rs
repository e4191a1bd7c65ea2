//! Ctrl-C and SIGTERM.

use glanz_job::CancelFlag;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::messages::CommandError;

/// Exit code of a command that was interrupted: 128 and the number of SIGINT, as shells count.
pub const EXIT_CODE: u8 = 130;

/// Flag of the first Ctrl-C or SIGTERM from now on; the second ends the process at once.
///
/// # Errors
/// Signals that cannot be received.
pub fn listen() -> Result<CancelFlag, CommandError> {
    let cancel = CancelFlag::default();
    for signal in [SIGINT, SIGTERM] {
        // In this order: the first signal finds the flag down and raises it, the second finds it up.
        flag::register_conditional_shutdown(signal, i32::from(EXIT_CODE), cancel.atomic())
            .and_then(|_| flag::register(signal, cancel.atomic()))
            .map_err(|error| CommandError::new(format!("cannot listen to signals: {error}")))?;
    }
    Ok(cancel)
}
