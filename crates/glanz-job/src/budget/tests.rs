//! Budgets.

use std::time::Duration;

use super::*;

fn budget(change: impl FnOnce(&mut ResourceLimits)) -> ResourceBudget {
    let mut limits = ResourceLimits::default();
    change(&mut limits);
    ResourceBudget::new(limits, CancelFlag::default())
}

#[test]
fn numbers_of_resources_are_their_places() {
    for (place, resource) in Resource::ALL.into_iter().enumerate() {
        assert_eq!(resource as usize, place);
    }
}

#[test]
fn clones_share_the_budget_and_steps_after_it_do_not() {
    let first = budget(|limits| (limits.tokens, limits.memory) = (10, 20));
    first.spend(Resource::Memory, 15).unwrap();
    let clone = first.clone();
    assert_eq!((first.spend(Resource::Tokens, 6), clone.spend(Resource::Tokens, 4)), (Ok(()), Ok(())));
    let [next, other] = [first.for_next_step(), first.for_next_step()];
    let error = BudgetError::Limit(LimitError { resource: Resource::Tokens, limit: 10, needed: None });
    assert_eq!(clone.spend(Resource::Tokens, 1), Err(error));
    assert_eq!(first.check(), Err(error), "the first failure ends all users");
    assert_eq!(first.spend(Resource::Files, 1), Err(error));
    assert_eq!((next.check(), next.spend(Resource::Tokens, 1)), (Ok(()), Ok(())));
    assert!(next.spend(Resource::Memory, 6).is_err(), "the memory is still in use");
    assert_eq!(other.check(), Ok(()));
    let limits = ResourceLimits { memory: 30, ..ResourceLimits::default() };
    let wider = first.for_next_step_within(limits, CancelFlag::default());
    assert_eq!((wider.used(Resource::Memory), wider.spend(Resource::Memory, 15)), (15, Ok(())));
    assert!(wider.spend(Resource::Memory, 1).is_err());
}

#[test]
fn reservations_are_given_back_but_for_what_is_kept() {
    let budget = budget(|limits| limits.memory = 100);
    drop(budget.reserve(100).unwrap());
    let mut part = budget.reserve(90).unwrap();
    part.shrink(30);
    assert_eq!((part.bytes(), budget.used(Resource::Memory)), (30, 30));
    part.keep();
    assert_eq!(budget.used(Resource::Memory), 30);
    let held = budget.reserve(70).unwrap();
    assert_eq!((held.bytes(), budget.used(Resource::Memory)), (70, 100));
    let error = LimitError { resource: Resource::Memory, limit: 100, needed: Some(101) };
    assert_eq!(budget.reserve(1).err(), Some(BudgetError::Limit(error)));
}

#[test]
fn amounts_beyond_64_bits_do_not_wrap() {
    let budget = budget(|limits| limits.memory = u64::MAX - 1);
    assert!(budget.spend(Resource::Memory, 10).is_ok());
    assert!(budget.spend(Resource::Memory, u64::MAX).is_err());
    assert_eq!(budget.used(Resource::Memory), 10);
}

#[test]
fn time_and_flag_end_a_loop() {
    let late = budget(|limits| limits.time = Duration::ZERO);
    let rounds = (0..1000).take_while(|_| late.check().is_ok()).count();
    assert!(rounds <= CHECKS_PER_CLOCK as usize);
    assert!(matches!(late.failure(), Some(BudgetError::Limit(LimitError { resource: Resource::Time, .. }))));
    let late = budget(|limits| limits.time = Duration::ZERO);
    assert!(matches!(late.check_now(), Err(BudgetError::Limit(LimitError { resource: Resource::Time, .. }))));
    let flagged = budget(|_| {});
    assert_eq!((flagged.check(), flagged.check_now()), (Ok(()), Ok(())));
    let (next, flag) = (flagged.for_next_step(), CancelFlag::default());
    let other = next.with_cancel(flag.clone());
    flagged.cancel().cancel();
    assert_eq!(flagged.clone().check(), Err(BudgetError::Interrupted));
    assert_eq!(other.check(), Ok(()), "it has a flag of its own");
    flag.cancel();
    assert_eq!(other.check(), Err(BudgetError::Interrupted));
}

#[test]
fn values_are_sizes_counts_and_times() {
    let mut limits = ResourceLimits::default();
    for (resource, text, value) in [
        (Resource::Memory, "2G", 2 << 30),
        (Resource::Memory, "1.5 GiB", 3 << 29),
        (Resource::Bytes, "64k", 1 << 16),
        (Resource::Bytes, "100", 100),
        (Resource::Tokens, "2e9", 2_000_000_000),
        (Resource::Files, "12", 12),
        (Resource::Time, "30s", 30_000),
        (Resource::Time, "0.05", 50),
    ] {
        limits.set(resource, text).unwrap();
        assert_eq!(limits.get(resource), value, "{text}");
    }
    for (resource, text) in [
        (Resource::Memory, "0"),
        (Resource::Memory, "-1G"),
        (Resource::Memory, "infG"),
        (Resource::Memory, "much"),
        (Resource::Tokens, "0.5"),
        (Resource::Tokens, "1e30"),
        (Resource::Tokens, "2G"),
        (Resource::Time, "0s"),
        (Resource::Time, "nan"),
        (Resource::Time, "-3"),
    ] {
        let before = limits.clone();
        assert!(limits.set(resource, text).is_err(), "{text}");
        assert_eq!(limits, before);
    }
}

#[test]
fn suggestions_lift_the_limit_and_can_be_set() {
    for resource in Resource::ALL {
        for limit in [1, 7, 1000, 99_999, 100_000, 123_456_789, 3 << 30] {
            for needed in [None, Some(limit + 1), Some(3 * limit)] {
                let mut limits = ResourceLimits::default();
                let error = LimitError { resource, limit, needed };
                limits.set(resource, &error.suggestion()).unwrap();
                assert!(
                    limits.get(resource) >= needed.unwrap_or(limit + 1),
                    "{error}: {}",
                    error.suggestion()
                );
            }
        }
    }
    let error = LimitError { resource: Resource::Memory, limit: 64 << 20, needed: Some(3_650_722_202) };
    assert_eq!(
        error.to_string(),
        "the limit of 64 MiB of memory is exceeded: at least 3.4 GiB of memory are needed"
    );
    let little = LimitError { needed: Some((64 << 20) + 1), ..error };
    assert_eq!(little.suggestion(), "128M", "what comes piece by piece needs more");
    let one = LimitError { resource: Resource::Files, limit: 1, needed: None };
    assert_eq!(one.to_string(), "the limit of 1 file is exceeded");
    assert_eq!((error.help(), error.suggestion()), ("raise ResourceLimits::memory".into(), "5G".into()));
    let tokens = LimitError { resource: Resource::Tokens, limit: 1_000_000_000, needed: None };
    assert_eq!(
        (tokens.to_string().as_str(), tokens.suggestion().as_str()),
        ("the limit of 1 000 000 000 tokens is exceeded", "2e9")
    );
}

#[test]
fn available_memory_is_that_of_the_machine() {
    let text = "MemTotal:       16000000 kB\nMemFree:         1000000 kB\nMemAvailable:    8000000 kB\n";
    assert_eq!(machine::available_in(text), Some(8_192_000_000));
    assert_eq!(machine::available_in("MemTotal: 1 kB"), None);
    assert!(ResourceLimits::default().memory > 1 << 20);
}

#[test]
fn the_least_of_the_control_groups_around_a_process_counts() {
    let rest = |own: &str, files: &[(&str, &str)]| {
        machine::group_rest(|path| {
            let text = match path.to_str() {
                Some("/proc/self/cgroup") => Some(own),
                Some(path) => files.iter().find(|(name, _)| *name == path).map(|(_, text)| *text),
                None => None,
            };
            text.map(str::to_owned)
        })
    };
    // As of a job of Slurm, whose steps have no limit of their own.
    let files = [
        ("/sys/fs/cgroup/system.slice/job_1/memory.max", "5000\n"),
        ("/sys/fs/cgroup/system.slice/job_1/memory.current", "1000\n"),
        ("/sys/fs/cgroup/system.slice/job_1/step_0/memory.max", "max\n"),
        ("/sys/fs/cgroup/system.slice/job_1/step_0/memory.current", "900\n"),
        ("/sys/fs/cgroup/system.slice/memory.max", "9000\n"),
        ("/sys/fs/cgroup/system.slice/memory.current", "6500\n"),
    ];
    assert_eq!(rest("0::/system.slice/job_1/step_0\n", &files), Some(2500));
    let files = [
        ("/sys/fs/cgroup/memory/slurm/job_1/memory.limit_in_bytes", "700\n"),
        ("/sys/fs/cgroup/memory/slurm/job_1/memory.usage_in_bytes", "300\n"),
        ("/sys/fs/cgroup/memory/slurm/job_1/memory.stat", "total_inactive_file 50\n"),
    ];
    assert_eq!(rest("9:cpu,cpuacct:/a\n4:memory:/slurm/job_1\n0::/\n", &files), Some(450));
    assert_eq!(rest("4:cpu:/slurm/job_1\n", &files), None);
    // Within a container, the paths are those outside.
    let files = [("/sys/fs/cgroup/memory.max", "80"), ("/sys/fs/cgroup/memory.current", "30")];
    assert_eq!((rest("0::/docker/a\n", &files), rest("", &files)), (Some(50), Some(50)));
}

#[test]
fn cached_files_are_no_memory_that_a_control_group_lacks() {
    let statistics =
        "anon 7000\nfile 4000\ninactive_file_x 1\ninactive_file 3000\ntotal_inactive_file 2000\n";
    assert_eq!(machine::statistic(statistics, "inactive_file"), Some(3000));
    assert_eq!(machine::statistic(statistics, "total_inactive_file"), Some(2000));
    assert_eq!(machine::statistic(statistics, "shmem"), None);
    assert_eq!(machine::rest(10_000, 9_500, 3_000), 3_500);
    assert_eq!((machine::rest(10, 4, 5), machine::rest(10, 12, 1)), (10, 0));
}

#[test]
fn options_set_the_suggestion() {
    for (resource, name) in [(Resource::Memory, "--memory "), (Resource::Objects, "--limit objects=")] {
        let error = LimitError { resource, limit: 1 << 20, needed: None };
        assert_eq!(error.option(), format!("{name}{}", error.suggestion()));
    }
}
