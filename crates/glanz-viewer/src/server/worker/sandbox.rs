//! Limits that the process of an opened scene imposes on itself, before it reads anything of the scene.
//!
//! Everywhere: none beyond those of the server, which measures memory and time. On Unix: sizes of files, open files, core dumps and priority. On Linux: memory,
//! reading of the uploaded files only (landlock), no sockets, programs or further processes (seccomp), and the end of the server ends the process.

use std::io;
use std::path::{Path, PathBuf};

use super::WorkerTask;

/// Confines this process, whose threads must not have begun, to the uploaded `files` and the `libraries` of a denoiser.
///
/// # Errors
/// If a limit cannot be set. Of landlock and seccomp, errors are ignored: a system without them has the other limits.
pub(super) fn enter(files: &Path, libraries: &[PathBuf], task: &WorkerTask) -> io::Result<()> {
    #[cfg(unix)]
    limits::set(task)?;
    #[cfg(target_os = "linux")]
    {
        // If the machine has no memory left, this goes before the server.
        let _ = std::fs::write("/proc/self/oom_score_adj", "500");
        rustix::process::set_parent_process_death_signal(Some(rustix::process::Signal::KILL))?;
        // Without them the other limits hold.
        let _ = linux::restrict_files(files, libraries);
        let _ = linux::restrict_calls();
    }
    #[cfg(not(target_os = "linux"))]
    let _ = (files, libraries, task);
    Ok(())
}

#[cfg(unix)]
mod limits {
    use std::io;

    use rustix::process::{Resource, Rlimit, getrlimit, nice, setrlimit};

    use super::WorkerTask;

    /// Most files that are open at a time.
    const OPEN_FILES: u64 = 256;

    /// Bytes that are allocated beyond those in use, such as stacks of threads.
    #[cfg(target_os = "linux")]
    const UNUSED: u64 = 1 << 30;

    /// Difference of the priority to that of the server, which has to answer other pages meanwhile.
    const NICENESS: i32 = 5;

    /// Sets the limits of resources.
    ///
    /// # Errors
    /// The error of the system.
    pub(super) fn set(task: &WorkerTask) -> io::Result<()> {
        let limits = [
            (Resource::Core, 0),
            (Resource::Nofile, OPEN_FILES),
            (Resource::Fsize, task.model_bytes),
            // The server measures what is in use; this refuses at once what could never be used.
            #[cfg(target_os = "linux")]
            (Resource::Data, task.memory.saturating_add(UNUSED)),
        ];
        for (resource, most) in limits {
            let most = getrlimit(resource).maximum.map_or(most, |maximum| maximum.min(most));
            setrlimit(resource, Rlimit { current: Some(most), maximum: Some(most) })?;
        }
        nice(NICENESS)?;
        Ok(())
    }
}

#[cfg(target_os = "linux")]
mod linux {
    use std::collections::BTreeMap;
    use std::error::Error;
    use std::path::{Path, PathBuf};

    use landlock::{
        ABI, Access, AccessFs, Ruleset, RulesetAttr, RulesetCreatedAttr, RulesetError, path_beneath_rules,
    };
    use seccompiler::{
        BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition, SeccompFilter,
        SeccompRule, apply_filter,
    };

    /// What the libraries of a denoiser read: libraries, and the processors.
    const SYSTEM: [&str; 7] = [
        "/lib",
        "/lib64",
        "/usr/lib",
        "/usr/lib64",
        "/usr/local/lib",
        "/etc/ld.so.cache",
        "/sys/devices/system",
    ];

    /// Restricts this thread and those that it starts to reading `files` and libraries, as far as the system can.
    ///
    /// # Errors
    /// The error of the system; none if it lacks landlock.
    pub(super) fn restrict_files(files: &Path, libraries: &[PathBuf]) -> Result<(), RulesetError> {
        let abi = ABI::V5;
        let folders = SYSTEM.iter().map(PathBuf::from).chain(libraries.iter().cloned());
        let folders = folders.chain([files.to_owned()]);
        // Folders that do not exist are left out, and so are rights that the system does not know.
        let rules = path_beneath_rules(folders, AccessFs::from_read(abi) & !AccessFs::Execute);
        Ruleset::default()
            .handle_access(AccessFs::from_all(abi))?
            .create()?
            .add_rules(rules)?
            .restrict_self()?;
        Ok(())
    }

    /// Refuses system calls that no reader needs to this thread and those that it starts.
    ///
    /// # Errors
    /// The error of the system, also if it lacks seccomp.
    pub(super) fn restrict_calls() -> Result<(), Box<dyn Error>> {
        for filter in [processes_by_clone3()?, forbidden_calls()?] {
            apply_filter(&filter)?;
        }
        Ok(())
    }

    /// A filter that answers the `rules` with an error and allows everything else.
    fn filter(
        rules: BTreeMap<i64, Vec<SeccompRule>>,
        error: i32,
    ) -> Result<BpfProgram, seccompiler::BackendError> {
        let refusal = SeccompAction::Errno(error.unsigned_abs());
        let architecture = std::env::consts::ARCH.try_into()?;
        SeccompFilter::new(rules, SeccompAction::Allow, refusal, architecture)?.try_into()
    }

    /// Makes the C library start its threads by `clone`, whose arguments a filter can see.
    fn processes_by_clone3() -> Result<BpfProgram, seccompiler::BackendError> {
        filter(BTreeMap::from([(libc::SYS_clone3, vec![])]), libc::ENOSYS)
    }

    /// Refuses sockets, programs, further processes, and whatever acts on other processes or the system.
    fn forbidden_calls() -> Result<BpfProgram, seccompiler::BackendError> {
        let when = |argument, operator, value| {
            SeccompCondition::new(argument, SeccompCmpArgLen::Dword, operator, value)
                .and_then(|condition| SeccompRule::new(vec![condition]))
        };
        let always = [
            libc::SYS_socket,
            libc::SYS_connect,
            libc::SYS_bind,
            libc::SYS_listen,
            libc::SYS_execve,
            libc::SYS_execveat,
            #[cfg(target_arch = "x86_64")]
            libc::SYS_fork,
            #[cfg(target_arch = "x86_64")]
            libc::SYS_vfork,
            libc::SYS_kill,
            libc::SYS_tkill,
            libc::SYS_rt_sigqueueinfo,
            libc::SYS_rt_tgsigqueueinfo,
            libc::SYS_pidfd_open,
            libc::SYS_pidfd_send_signal,
            libc::SYS_pidfd_getfd,
            libc::SYS_ptrace,
            libc::SYS_process_vm_readv,
            libc::SYS_process_vm_writev,
            libc::SYS_io_uring_setup,
            libc::SYS_bpf,
            libc::SYS_perf_event_open,
            libc::SYS_userfaultfd,
            libc::SYS_keyctl,
            libc::SYS_add_key,
            libc::SYS_request_key,
            libc::SYS_unshare,
            libc::SYS_setns,
            libc::SYS_mount,
        ];
        let mut rules: BTreeMap<i64, Vec<SeccompRule>> = always.map(|call| (call, vec![])).into();
        // Threads, not processes.
        let threads = libc::CLONE_THREAD.unsigned_abs().into();
        rules.insert(libc::SYS_clone, vec![when(0, SeccompCmpOp::MaskedEq(threads), 0)?]);
        // Limits of itself, which the C library reads.
        rules.insert(libc::SYS_prlimit64, vec![when(0, SeccompCmpOp::Ne, 0)?]);
        // Signals to itself, as `abort` sends them.
        let own = std::process::id().into();
        rules.insert(libc::SYS_tgkill, vec![when(0, SeccompCmpOp::Ne, own)?]);
        filter(rules, libc::EPERM)
    }

    #[cfg(test)]
    mod tests {
        use std::net::TcpListener;
        use std::os::unix::net::UnixStream;
        use std::process::Command;

        use super::*;

        /// Whether a file of the system contains a word.
        fn lists(file: &str, word: &str) -> bool {
            std::fs::read_to_string(file).is_ok_and(|text| text.contains(word))
        }

        /// In a thread of its own, which alone is confined.
        #[test]
        fn confined_thread_reads_its_files_and_nothing_else() {
            if !lists("/sys/kernel/security/lsm", "landlock") {
                println!("this system has no landlock");
                return;
            }
            let (inside, outside) = (tempfile::TempDir::new().unwrap(), tempfile::TempDir::new().unwrap());
            std::fs::write(inside.path().join("a.pbrt"), "x").unwrap();
            std::fs::write(outside.path().join("b.pbrt"), "x").unwrap();
            std::os::unix::fs::symlink(outside.path().join("b.pbrt"), inside.path().join("link")).unwrap();
            let confined = || {
                restrict_files(inside.path(), &[]).unwrap();
                let read = |folder: &tempfile::TempDir, name: &str| {
                    std::fs::read(folder.path().join(name)).map_err(|error| error.kind())
                };
                let refused = Err(std::io::ErrorKind::PermissionDenied);
                assert_eq!(read(&inside, "a.pbrt"), Ok(b"x".to_vec()));
                assert_eq!(read(&outside, "b.pbrt"), refused);
                assert_eq!(read(&inside, "link"), refused);
                assert!(std::fs::read("/etc/passwd").is_err());
                assert!(std::fs::write(inside.path().join("a.pbrt"), "y").is_err());
                assert!(std::fs::write(inside.path().join("c.pbrt"), "y").is_err());
            };
            std::thread::scope(|scope| scope.spawn(confined).join().unwrap());
            std::fs::write(inside.path().join("c.pbrt"), "y").unwrap();
        }

        #[test]
        fn confined_thread_has_threads_but_no_sockets_and_programs() {
            if !lists("/proc/self/status", "Seccomp:") {
                println!("this system has no seccomp");
                return;
            }
            let confined = || {
                let program = || Command::new("/bin/true").status();
                assert!(program().is_ok_and(|status| status.success()));
                restrict_calls().unwrap();
                assert!(TcpListener::bind("127.0.0.1:0").is_err());
                assert!(UnixStream::pair().is_ok(), "pairs reach nobody else");
                assert!(program().is_err());
                assert_eq!(std::thread::spawn(|| 6 * 7).join().unwrap(), 42);
                std::thread::spawn(|| assert!(TcpListener::bind("127.0.0.1:0").is_err())).join().unwrap();
            };
            std::thread::scope(|scope| scope.spawn(confined).join().unwrap());
            assert!(TcpListener::bind("127.0.0.1:0").is_ok());
        }
    }
}
