//! The processors of the machine, shared by all streams.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Number of concurrent renders. Their threads share the processors; more renders would only slow down all of them.
const RENDERS: usize = 4;

/// Time slice of a render while others wait, unless a pass takes longer.
pub(crate) const TIME_SLICE: Duration = Duration::from_secs(2);

/// Largest number of pixels of all films together, 120 to 290 bytes each.
const PIXELS: usize = 1 << 24;

/// Pixels per unit of the semaphore.
const UNIT: usize = 1 << 10;

/// Permits to render for a few streams at a time, granted in the order of the requests.
#[derive(Debug)]
pub struct Processors {
    threads: usize,
    permits: Arc<Semaphore>,
    films: Arc<Semaphore>,
    waiting: AtomicUsize,
}

/// The permit of one stream.
#[derive(Debug)]
pub(crate) struct ProcessorShare {
    _permit: OwnedSemaphorePermit,
}

impl Processors {
    /// `threads`: of each render; 0 means as many as the machine has.
    #[must_use]
    pub fn new(threads: usize) -> Self {
        Self {
            threads,
            permits: Arc::new(Semaphore::new(RENDERS)),
            films: Arc::new(Semaphore::new(PIXELS / UNIT)),
            waiting: AtomicUsize::new(0),
        }
    }

    /// Threads of a render, as [`glanz_transport::RenderSettings::threads`].
    pub(crate) fn threads(&self) -> usize {
        self.threads
    }

    /// True if another render waits.
    pub(crate) fn are_wanted(&self) -> bool {
        self.waiting.load(Ordering::Relaxed) > 0
    }

    /// A permit to render, if one is free.
    pub(crate) fn try_permit(&self) -> Option<ProcessorShare> {
        Arc::clone(&self.permits).try_acquire_owned().ok().map(|permit| ProcessorShare { _permit: permit })
    }

    /// Waits for a permit to render.
    pub(crate) async fn permit(&self) -> Option<ProcessorShare> {
        let _waiting = Waiting::new(&self.waiting);
        let permit = Arc::clone(&self.permits).acquire_owned().await.ok()?;
        Some(ProcessorShare { _permit: permit })
    }

    /// Memory for a film of `pixels`, if it is free.
    pub(crate) fn try_film(&self, pixels: u64) -> Option<ProcessorShare> {
        Arc::clone(&self.films)
            .try_acquire_many_owned(units(pixels))
            .ok()
            .map(|permit| ProcessorShare { _permit: permit })
    }

    /// Waits for memory for a film of `pixels`.
    pub(crate) async fn film(&self, pixels: u64) -> Option<ProcessorShare> {
        let permit = Arc::clone(&self.films).acquire_many_owned(units(pixels)).await.ok()?;
        Some(ProcessorShare { _permit: permit })
    }
}

fn units(pixels: u64) -> u32 {
    u32::try_from(pixels.div_ceil(UNIT as u64)).unwrap_or(u32::MAX)
}

/// Counts a waiting stream until it is dropped.
struct Waiting<'a>(&'a AtomicUsize);

impl<'a> Waiting<'a> {
    fn new(count: &'a AtomicUsize) -> Self {
        count.fetch_add(1, Ordering::Relaxed);
        Self(count)
    }
}

impl Drop for Waiting<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::super::request::MAX_SIDE;
    use super::*;

    #[test]
    fn places_are_few_and_come_back() {
        let processors = Processors::new(1);
        let permits: Vec<_> = std::iter::from_fn(|| processors.try_permit()).collect();
        assert_eq!(permits.len(), RENDERS);
        drop(permits);
        assert!(processors.try_permit().is_some());
    }

    #[test]
    fn memory_is_bounded_and_holds_the_largest_picture() {
        let processors = Processors::new(1);
        let largest = u64::from(MAX_SIDE) * u64::from(MAX_SIDE);
        let films: Vec<_> = std::iter::from_fn(|| processors.try_film(largest)).collect();
        assert_eq!(films.len() as u64, PIXELS as u64 / largest);
        assert!(!films.is_empty() && processors.try_film(1).is_none());
    }

    #[test]
    fn a_waiting_stream_is_counted_until_its_turn_or_its_end() {
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        runtime.block_on(async {
            let processors = Arc::new(Processors::new(1));
            let permits: Vec<_> = std::iter::from_fn(|| processors.try_permit()).collect();
            let [first, second] = [(); 2].map(|()| {
                let processors = Arc::clone(&processors);
                tokio::spawn(async move { processors.permit().await })
            });
            tokio::task::yield_now().await;
            assert_eq!(processors.waiting.load(Ordering::Relaxed), 2);
            first.abort();
            assert!(first.await.is_err());
            assert_eq!(processors.waiting.load(Ordering::Relaxed), 1);
            drop(permits);
            assert!(second.await.unwrap().is_some());
            assert!(!processors.are_wanted());
        });
    }
}
