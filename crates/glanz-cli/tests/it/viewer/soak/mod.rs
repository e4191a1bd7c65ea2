//! Load test with many simultaneous clients, valid and misbehaving: threads and memory are released afterwards.
//!
//! `GLANZ_SOAK_PAGES` sets the number of clients, `GLANZ_SOAK_SECONDS` the duration and `GLANZ_SOAK_UPLOADS` the number of hostile uploads; `cargo xtask soak`
//! uses 100, 300 and 300.

mod hostile_uploads;
mod mischief;
pub(crate) mod process;
pub(crate) mod visitor;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::viewer::server::{entries, serve_in, temporary_folder};
use process::Usage;
use visitor::{Fault, Visitor};

/// Time limit for threads, files and processes to end after the last client has left. Idle worker threads end after ten seconds, a process that
/// nobody ended when its minute of reading is over.
const PATIENCE: Duration = Duration::from_secs(20);

/// Share of memory, and MiB, by which a round may leave more behind than the round before it: allocators keep what they may
/// need again, and every page more that is there at one time adds to that. A picture of the smallest view that were left behind with
/// each visit would come to more.
const GROWTH: [f64; 2] = [0.1, 16.0];

/// Totals over all visits.
#[derive(Default)]
struct Tally {
    visits: u64,
    tiles: u64,
    picks: u64,
    saves: u64,
    /// Times until rendering had stopped.
    stops: Vec<Duration>,
    refusals: BTreeMap<&'static str, u64>,
    uploads: u64,
    /// Uploads that the server has begun to serve.
    admitted: u64,
    /// Longest time until a refusal.
    slowest: (Duration, &'static str),
    faults: Vec<Fault>,
}

impl Tally {
    fn add(&mut self, other: Self) {
        self.visits += other.visits;
        self.tiles += other.tiles;
        self.picks += other.picks;
        self.saves += other.saves;
        self.stops.extend(other.stops);
        self.uploads += other.uploads;
        self.admitted += other.admitted;
        for (kind, count) in other.refusals {
            *self.refusals.entry(kind).or_default() += count;
        }
        self.slowest = self.slowest.max(other.slowest);
        self.faults.extend(other.faults);
    }

    /// Misuses the server in the next way, and then visits it.
    fn misuse(&mut self, host: &str, kind: &mut usize, dice: &mut Dice) {
        let (name, does) = mischief::ALL[*kind % mischief::ALL.len()];
        *kind += 1;
        let start = Instant::now();
        let met = does(host).map_err(|fault| format!("{name}: {fault}"));
        *self.refusals.entry(name).or_default() += 1;
        self.slowest = self.slowest.max((start.elapsed(), name));
        if let Err(fault) = met.and_then(|()| visit(host, dice, self)) {
            self.faults.push(fault);
        }
    }

    /// The totals as one line of text.
    fn summary(&mut self) -> String {
        self.stops.sort_unstable();
        let at = |share: f64| {
            let i = (share * self.stops.len() as f64) as usize;
            self.stops.get(i.min(self.stops.len().saturating_sub(1))).map_or(0.0, |d| 1e3 * d.as_secs_f64())
        };
        let refused: u64 = self.refusals.values().sum();
        format!(
            "{} visits, {} tiles, {} picks, {} pictures saved, {} stops (half within {:.0} ms, 95 % within {:.0} ms), {} hostile uploads, {} of them admitted, \
             {refused} times mischief (longest {:.1} s: {})",
            self.visits,
            self.tiles,
            self.picks,
            self.saves,
            self.stops.len(),
            at(0.5),
            at(0.95),
            self.uploads,
            self.admitted,
            self.slowest.0.as_secs_f64(),
            self.slowest.1
        )
    }
}

/// A pseudo-random number generator: a Weyl sequence whose bits are mixed.
struct Dice(u64);

impl Dice {
    fn throw(&mut self, below: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (x ^ (x >> 31)) % below
    }
}

/// The value of an environment variable, or this default.
fn setting(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |text| text.parse().expect("a number"))
}

#[test]
fn pages_that_come_and_go_leave_nothing_behind() {
    let (pages, seconds) = (setting("GLANZ_SOAK_PAGES", 4), setting("GLANZ_SOAK_SECONDS", 6));
    let uploads = setting("GLANZ_SOAK_UPLOADS", hostile_uploads::ALL.len() as u64);
    let folder = temporary_folder();
    let mut served = serve_in(&folder);
    // One visit, so that everything allocated once is allocated.
    let mut warm = Tally::default();
    visit(&served.host, &mut Dice(0), &mut warm).unwrap_or_else(|fault| panic!("{fault}\n{}", served.said()));
    let before = Usage::of(served.id()).expect("the server runs");
    println!("before: {before}");
    let half = Duration::from_secs_f64(0.5 * seconds as f64);
    let next_upload = AtomicU64::new(0);
    let [first, second] = [1, 2].map(|number| {
        let mut tally = round(&served.host, pages, half, number, (&next_upload, number * uploads / 2));
        println!("round {number}: {pages} pages for {} s: {}", half.as_secs(), tally.summary());
        assert!(served.is_alive(), "the server died\n{}", served.said());
        let faults = &tally.faults;
        assert!(faults.is_empty(), "{} faults, first {:?}\n{}", faults.len(), faults.first(), served.said());
        assert!(tally.admitted >= tally.uploads / 2, "{} of {} uploads", tally.admitted, tally.uploads);
        let left = Usage::settled(served.id(), before, PATIENCE).expect("the server runs");
        let entries = entries(&folder);
        println!("after round {number}: {left}, {entries} temporary files");
        assert_eq!(entries, 0, "temporary files stay");
        left
    });
    let more = second.threads.saturating_sub(before.threads);
    assert_eq!(more, 0, "{more} threads stay of {pages} pages");
    assert!(second.files <= before.files && second.children == 0, "{before} {second}");
    let most = first.memory * (1.0 + GROWTH[0]) + GROWTH[1];
    assert!(second.memory <= most, "memory grows from {:.1} to {:.1} MiB", first.memory, second.memory);
    visit(&served.host, &mut Dice(1), &mut warm).unwrap_or_else(|fault| panic!("{fault}\n{}", served.said()));
    drop(served);
    assert_eq!(entries(&folder), 0, "temporary files stay");
}

/// Runs `pages` simultaneous clients that connect and disconnect for some time, and until the hostile uploads up to a number are done.
fn round(
    host: &str,
    pages: u64,
    time: Duration,
    number: u64,
    (next_upload, uploads): (&AtomicU64, u64),
) -> Tally {
    let end = Instant::now() + time;
    let take = |next: u64| (next < uploads).then_some(next + 1);
    let run = |page: u64| {
        let mut dice = Dice(number << 32 | page << 16);
        let mut tally = Tally::default();
        // Each client starts with a different kind of misuse, so that every kind occurs.
        let mut kind = page as usize;
        while tally.faults.is_empty() {
            let upload = next_upload.fetch_update(Ordering::Relaxed, Ordering::Relaxed, take).ok();
            if let Some(upload) = upload {
                tally.uploads += 1;
                let uploaded = hostile_uploads::upload(host, upload as usize, &mut dice);
                match uploaded {
                    Ok(is_admitted) => tally.admitted += u64::from(is_admitted),
                    Err(fault) => tally.faults.push(fault),
                }
            }
            if Instant::now() < end {
                tally.misuse(host, &mut kind, &mut dice);
            } else if upload.is_none() {
                break;
            }
        }
        tally
    };
    std::thread::scope(|scope| {
        let run = &run;
        let pages: Vec<_> = (0..pages).map(|page| scope.spawn(move || run(page))).collect();
        let mut sum = Tally::default();
        for page in pages {
            sum.add(page.join().expect("a page that does not panic"));
        }
        sum
    })
}

/// A valid client: it connects, turns the camera, renders, picks, and disconnects in one of several ways.
fn visit(host: &str, dice: &mut Dice, tally: &mut Tally) -> Result<(), Fault> {
    let mut visitor = Visitor::try_new(host)?;
    for step in 0..1 + dice.throw(4) {
        let size = [48 + dice.throw(80) as u32, 32 + dice.throw(60) as u32];
        let view = visitor.view(size, 0.1 * step as f64)?;
        visitor.await_tile(view)?;
        if dice.throw(2) == 0 {
            tally.picks += u64::from(visitor.pick()?);
        }
        if dice.throw(4) == 0 {
            let file = visitor.save(view)?;
            if !file.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
                return Err(format!("{} bytes that are no OpenEXR", file.len()));
            }
            tally.saves += 1;
        }
        // Often the camera moves without stopping the last view.
        if dice.throw(2) == 0 {
            tally.stops.push(visitor.stop(view)?);
        }
    }
    tally.visits += 1;
    tally.tiles += visitor.tiles;
    // Some close the WebSocket properly, others drop the connection, possibly during a picture.
    if dice.throw(2) == 0 {
        let _ = visitor.socket.close(None);
        let _ = visitor.socket.flush();
    }
    Ok(())
}
