//! Memory of pictures, and the file of those that do not fit in it.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use glanz_job::{ScratchFile, ScratchFileError};

use super::texels::TexelValues;

/// Parts of the cache with a lock each: a power of 2.
const PARTS: usize = 64;

/// Memory of the largest tile, bytes: 64 x 64 colours in floats.
const LARGEST_TILE: u64 = 64 * 64 * 12;

/// The memory for the pictures of a scene; cheap to clone.
///
/// Pictures are whole in memory as long as they take at most half of it. The others are in a temporary file, by tiles, of which those that were in use lately
/// take the other half: at least one tile for each of 64 parts with a lock of their own. Values are the same either way.
#[derive(Clone, Debug)]
pub struct TextureCache(Arc<CacheState>);

#[derive(Debug)]
struct CacheState {
    /// Bytes of the pictures that are whole in memory, and the most that they may take.
    whole: AtomicU64,
    most_whole: u64,
    parts: [Mutex<CachePart>; PARTS],
    /// Most bytes of a part.
    most_of_part: u64,
    file: OnceLock<ScratchFile>,
    /// Length of the file.
    length: Mutex<u64>,
    /// Number of tiles of all levels.
    tiles: AtomicU64,
    fault: OnceLock<ScratchFileError>,
}

/// Tiles, of which the first that was not used for a round of the hand is removed for another: nearly the one whose last use is the longest ago.
#[derive(Debug, Default)]
struct CachePart {
    tiles: Vec<CachedTile>,
    places: HashMap<u64, usize>,
    hand: usize,
    bytes: u64,
}

#[derive(Debug)]
struct CachedTile {
    number: u64,
    texels: Arc<TexelValues>,
    is_used: bool,
}

impl Default for TextureCache {
    /// Without a limit: pictures are always whole in memory.
    fn default() -> Self {
        Self::new(u64::MAX)
    }
}

impl TextureCache {
    /// A cache for pictures that may take so many bytes.
    #[must_use]
    pub fn new(memory: u64) -> Self {
        Self(Arc::new(CacheState {
            whole: AtomicU64::new(0),
            most_whole: memory / 2,
            parts: std::array::from_fn(|_| Mutex::default()),
            most_of_part: memory / 2 / PARTS as u64,
            file: OnceLock::new(),
            length: Mutex::default(),
            tiles: AtomicU64::new(0),
            fault: OnceLock::new(),
        }))
    }

    /// Bytes of the temporary file.
    #[must_use]
    pub fn file_size(&self) -> u64 {
        *self.0.length.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Most memory of the tiles, bytes: each part keeps one at least.
    #[must_use]
    pub fn tile_memory(&self) -> u64 {
        self.0.most_of_part.max(LARGEST_TILE).saturating_mul(PARTS as u64)
    }

    /// The first error of the temporary file. After one, texels are black that could not be read.
    ///
    /// # Errors
    /// [`ScratchFileError`].
    pub fn check(&self) -> Result<(), ScratchFileError> {
        self.0.fault.get().cloned().map_or(Ok(()), Err)
    }

    /// Keeps an error of the temporary file for [`TextureCache::check`], unless there was one before.
    pub fn fail(&self, error: ScratchFileError) {
        let _ = self.0.fault.set(error);
    }

    /// Whether both are one, or clones of it.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// Whether a picture of so many bytes is to be whole in memory; if so, they are taken for good.
    pub(super) fn take(&self, bytes: u64) -> bool {
        let fits = |taken: u64| taken.checked_add(bytes).filter(|sum| *sum <= self.0.most_whole);
        self.0.whole.fetch_update(Ordering::Relaxed, Ordering::Relaxed, fits).is_ok()
    }

    /// Numbers for so many tiles, the first of them.
    pub(super) fn number_tiles(&self, count: u64) -> u64 {
        self.0.tiles.fetch_add(count, Ordering::Relaxed)
    }

    /// Adds room for so many bytes to the file; its place.
    pub(super) fn allocate(&self, bytes: u64) -> Result<u64, ScratchFileError> {
        let mut length = self.0.length.lock().unwrap_or_else(PoisonError::into_inner);
        if self.0.file.get().is_none() {
            // Nobody else can have set it: they hold the lock.
            let _ = self.0.file.set(ScratchFile::try_new(bytes)?);
        }
        let start = *length;
        if let Some(file) = self.0.file.get() {
            file.resize(start.saturating_add(bytes))?;
        }
        *length = start.saturating_add(bytes);
        Ok(start)
    }

    /// Writes into room that was allocated.
    pub(super) fn write(&self, bytes: &[u8], start: u64) -> Result<(), ScratchFileError> {
        self.0.file.get().map_or(Ok(()), |file| file.write(bytes, start))
    }

    /// Reads what was written; zeros after an error, which [`TextureCache::check`] returns.
    pub(super) fn read(&self, length: usize, start: u64) -> Vec<u8> {
        let mut bytes = vec![0; length];
        if let Some(Err(error)) = self.0.file.get().map(|file| file.read(&mut bytes, start)) {
            self.fail(error);
            bytes.fill(0);
        }
        bytes
    }

    /// The tile with this number, which `make` makes if it is not in memory.
    pub(super) fn tile(&self, number: u64, make: impl FnOnce() -> TexelValues) -> Arc<TexelValues> {
        if let Some(texels) = self.part(number).find(number) {
            return texels;
        }
        // Without the lock: a tile may be made of others. Two threads may make the same.
        let made = Arc::new(make());
        self.part(number).insert(number, &made, self.0.most_of_part);
        made
    }

    fn part(&self, number: u64) -> MutexGuard<'_, CachePart> {
        self.0.parts[part_of(number)].lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The part of a tile. By Fibonacci hashing: the tiles of a column of a picture, whose numbers differ by a power of 2 in many pictures, are in different parts.
fn part_of(number: u64) -> usize {
    (number.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> (u64::BITS - PARTS.ilog2())) as usize
}

impl CachePart {
    fn find(&mut self, number: u64) -> Option<Arc<TexelValues>> {
        let tile = self.tiles.get_mut(*self.places.get(&number)?)?;
        tile.is_used = true;
        Some(Arc::clone(&tile.texels))
    }

    fn insert(&mut self, number: u64, texels: &Arc<TexelValues>, most: u64) {
        if self.places.contains_key(&number) {
            return;
        }
        self.bytes += texels.memory();
        while self.bytes > most && self.remove_one() {}
        self.places.insert(number, self.tiles.len());
        self.tiles.push(CachedTile { number, texels: Arc::clone(texels), is_used: false });
    }

    /// Removes a tile that was not used lately; whether there was one.
    fn remove_one(&mut self) -> bool {
        loop {
            if self.hand >= self.tiles.len() {
                self.hand = 0;
            }
            let Some(tile) = self.tiles.get_mut(self.hand) else { return false };
            if !std::mem::take(&mut tile.is_used) {
                break;
            }
            self.hand += 1;
        }
        let removed = self.tiles.swap_remove(self.hand);
        self.bytes -= removed.texels.memory();
        self.places.remove(&removed.number);
        if let Some(moved) = self.tiles.get(self.hand) {
            self.places.insert(moved.number, self.hand);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tile(value: u64) -> TexelValues {
        TexelValues::Floats { values: vec![value as f32; 25], planes: 1 }
    }

    #[test]
    fn tiles_in_use_stay_and_the_others_make_room() {
        // Ten tiles of 100 bytes for each part.
        let cache = TextureCache::new(2 * 1000 * PARTS as u64);
        let numbers = || (0..).filter(|number| part_of(*number) == 0).take(40);
        for number in numbers() {
            assert_eq!(cache.tile(number, || tile(number)).texel(3)[0], number as f32);
            // The first is used between all others.
            assert_eq!(cache.tile(0, || tile(7)).texel(0)[0], 0.0);
            let part = cache.part(0);
            assert!(part.bytes <= 1000 && part.tiles.len() == part.places.len());
            assert!(part.tiles.iter().enumerate().all(|(i, tile)| part.places[&tile.number] == i));
        }
        let made = numbers().filter(|&number| {
            let mut is_made = false;
            cache.tile(number, || {
                is_made = true;
                tile(number)
            });
            is_made
        });
        assert!(made.count() >= 30);
    }

    #[test]
    fn whole_pictures_take_half_of_the_memory() {
        let cache = TextureCache::new(1000);
        assert_eq!([300, 300, 200, 1].map(|bytes| cache.take(bytes)), [true, false, true, false]);
        assert!(TextureCache::default().take(1 << 60));
    }

    #[test]
    fn errors_of_the_file_are_kept() {
        let cache = TextureCache::new(0);
        let start = cache.allocate(10).unwrap();
        cache.write(&[1; 10], start).unwrap();
        assert_eq!((cache.read(10, start), cache.check()), (vec![1; 10], Ok(())));
        assert_eq!(cache.read(10, start + 1), vec![0; 10]);
        assert!(cache.check().is_err());
        assert_eq!(cache.file_size(), 10);
    }
}
