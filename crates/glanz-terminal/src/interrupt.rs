//! Signals: Ctrl-C, SIGTERM and SIGHUP as a flag, none for files that become too large.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use glanz_job::CancelFlag;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::messages::CommandError;

/// Number of the signal of a terminal that is closed.
const SIGHUP: i32 = 1;

/// Exit codes of processes that a signal ends are larger than its number by this, as shells count.
const SIGNAL_CODE: i32 = 128;

/// Exit code of a command whose output nobody reads any longer: that of SIGPIPE, 13.
pub(crate) const CLOSED_PIPE: u8 = 141;

/// The last signal that was received; 0 before the first one.
static RECEIVED: OnceLock<Arc<AtomicUsize>> = OnceLock::new();

/// Flag of the first Ctrl-C, SIGTERM or SIGHUP from now on; the second one ends the process at once. A SIGHUP that is ignored, as by `nohup`, stays ignored.
///
/// # Errors
/// Signals that cannot be received.
pub fn listen() -> Result<CancelFlag, CommandError> {
    let cancel = CancelFlag::default();
    let received = RECEIVED.get_or_init(Arc::default);
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        if signal == SIGHUP && !receives_hangup() {
            continue;
        }
        // In this order: the first signal finds the flag down and raises it, the second finds it up.
        flag::register_conditional_shutdown(signal, SIGNAL_CODE + signal, cancel.atomic())
            .and_then(|_| flag::register_usize(signal, Arc::clone(received), signal as usize))
            .and_then(|_| flag::register(signal, cancel.atomic()))
            .map_err(|error| CommandError::new(format!("cannot listen to signals: {error}")))?;
    }
    Ok(cancel)
}

/// Exit code of a command that a signal has interrupted: 130 for Ctrl-C, 143 for SIGTERM, 129 for SIGHUP.
#[must_use]
pub fn exit_code() -> u8 {
    let received = RECEIVED.get().map_or(0, |signal| signal.load(Ordering::Relaxed));
    let signal = i32::try_from(received).ok().filter(|signal| *signal > 0).unwrap_or(SIGINT);
    u8::try_from(SIGNAL_CODE + signal).unwrap_or(u8::MAX)
}

/// Whether a hangup is not ignored. Only Linux shows that to a process; elsewhere SIGHUP is left as it is, so that `nohup` keeps its effect.
#[must_use]
pub fn receives_hangup() -> bool {
    std::fs::read_to_string("/proc/self/status").is_ok_and(|status| ignores(&status, SIGHUP) == Some(false))
}

/// Whether the process with this status file ignores a signal: bit `signal` - 1 of the hexadecimal number in the line `SigIgn:`.
fn ignores(status: &str, signal: i32) -> Option<bool> {
    let line = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
    let mask = u64::from_str_radix(line.trim(), 16).ok()?;
    Some(mask >> (signal - 1) & 1 == 1)
}

/// Lets writing beyond the limit of the size of files fail with an error, instead of ending the process without a word.
pub(crate) fn report_large_files_as_errors() {
    #[cfg(unix)]
    {
        // The flag is of no interest: a signal with a handler does not end the process. Without one, only the message is missing.
        let _ = flag::register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ignored_signals_are_found_in_the_status_file() {
        let status = "Name:\tglanz\nSigBlk:\t0000000000000001\nSigIgn:\t0000000000001003\nSigCgt:\t0\n";
        assert_eq!([1, 2, 3, 13].map(|signal| ignores(status, signal)), [true, true, false, true].map(Some));
        assert_eq!(ignores("Name:\tglanz\n", 1), None);
    }
}
