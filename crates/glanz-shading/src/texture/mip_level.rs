//! One size of a picture with mipmap levels.

use std::ops::Range;
use std::sync::Arc;

use glanz_job::{ContentHash, ScratchFileError};
use glanz_math::DVec2;

use super::mip_map::ImageWrap;
use super::texels::{TexelFormat, TexelValues};
use super::texture_cache::TextureCache;

/// Texels along a side of a tile, at most.
const TILE: usize = 64;

/// Texels in rows from the top.
#[derive(Clone, Debug)]
pub(super) struct MipLevel {
    pub(super) width: usize,
    pub(super) height: usize,
    texels: LevelTexels,
}

#[derive(Clone, Debug)]
enum LevelTexels {
    Memory(Arc<TexelValues>),
    /// Those that were in use lately.
    Cached(CachedLevel),
}

#[derive(Clone, Debug)]
struct CachedLevel {
    cache: TextureCache,
    /// Number of the first tile in the cache.
    first: u64,
    source: TileSource,
}

/// Where tiles come from that are not in the cache.
#[derive(Clone, Debug)]
enum TileSource {
    /// From the place `start` of the file on.
    File { start: u64, format: TexelFormat },
    /// Made of the next larger level.
    Larger(Arc<MipLevel>),
}

impl MipLevel {
    /// The full size of a picture, whole in memory.
    pub(super) fn new(width: usize, height: usize, texels: TexelValues) -> Self {
        Self { width, height, texels: LevelTexels::Memory(Arc::new(texels)) }
    }

    /// Memory of the texels, bytes, without those in a cache.
    pub(super) fn memory(&self) -> u64 {
        match &self.texels {
            LevelTexels::Memory(block) => block.memory(),
            LevelTexels::Cached(CachedLevel { source: TileSource::File { format, .. }, .. }) => {
                format.memory()
            }
            LevelTexels::Cached(_) => 0,
        }
    }

    /// Values of a texel: one or three.
    pub(super) fn planes(&self) -> usize {
        match &self.texels {
            LevelTexels::Memory(block) => block.planes(),
            LevelTexels::Cached(CachedLevel { source: TileSource::File { format, .. }, .. }) => {
                format.planes()
            }
            LevelTexels::Cached(CachedLevel { source: TileSource::Larger(larger), .. }) => larger.planes(),
        }
    }

    /// The same level in the file of `cache`.
    pub(super) fn stored(&self, cache: &TextureCache) -> Result<Self, ScratchFileError> {
        let LevelTexels::Memory(block) = &self.texels else { return Ok(self.clone()) };
        let format = block.format();
        let ([across, down], texel_bytes) = (self.tile_size(), format.texel_bytes());
        let (tile_bytes, columns) = (across * down * texel_bytes, self.tile_columns());
        let tiles = columns * self.tile_rows();
        let start = cache.allocate(tile_bytes as u64 * tiles as u64)?;
        let mut bytes = Vec::with_capacity(tile_bytes);
        for (number, place) in (0..tiles).zip((start..).step_by(tile_bytes.max(1))) {
            let [left, top] = [number % columns, number / columns].map(|tile| TILE * tile);
            bytes.clear();
            // Tiles beyond the border are filled up.
            for row in top..top + down {
                let full = bytes.len() + across * texel_bytes;
                if row < self.height {
                    let row = self.width * row;
                    block.append(row + left..row + self.width.min(left + across), &mut bytes);
                }
                bytes.resize(full, 0);
            }
            cache.write(&bytes, place)?;
        }
        Ok(self.cached(cache, TileSource::File { start, format }))
    }

    /// The next smaller level in `cache`, of which each tile is made when it is read.
    pub(super) fn halved_in(self: &Arc<Self>, cache: &TextureCache) -> Self {
        let [width, height] = self.halved_size();
        let level = Self { width, height, texels: self.texels.clone() };
        level.cached(cache, TileSource::Larger(Arc::clone(self)))
    }

    fn cached(&self, cache: &TextureCache, source: TileSource) -> Self {
        let first = cache.number_tiles((self.tile_columns() * self.tile_rows()) as u64);
        let texels = LevelTexels::Cached(CachedLevel { cache: cache.clone(), first, source });
        Self { width: self.width, height: self.height, texels }
    }

    /// Columns and rows of a tile: no more than there are.
    fn tile_size(&self) -> [usize; 2] {
        [self.width.min(TILE), self.height.min(TILE)]
    }

    fn tile_columns(&self) -> usize {
        self.width.div_ceil(TILE)
    }

    fn tile_rows(&self) -> usize {
        self.height.div_ceil(TILE)
    }

    /// All texels, from the top left.
    pub(super) fn to_rgb(&self) -> Vec<[f32; 3]> {
        let mut all = vec![[0.0; 3]; self.width * self.height];
        self.for_each(|column, row, rgb| all[row * self.width + column] = rgb);
        all
    }

    /// Adds all values, wherever they are, to a hash.
    pub(super) fn add_to(&self, hash: &mut ContentHash) {
        self.for_each(|_, _, rgb| rgb.iter().for_each(|x| hash.add(&x.to_bits().to_le_bytes())));
    }

    /// Calls `each` with column, row and value of all texels, tile after tile, each of which is read once.
    fn for_each(&self, mut each: impl FnMut(usize, usize, [f32; 3])) {
        let mut reader = TexelReader::new(self);
        for tile_row in 0..self.tile_rows() {
            for tile in 0..self.tile_columns() {
                for row in TILE * tile_row..self.height.min(TILE * (tile_row + 1)) {
                    for column in TILE * tile..self.width.min(TILE * (tile + 1)) {
                        each(column, row, reader.texel(column, row));
                    }
                }
            }
        }
    }

    /// Position in columns and rows from the top left corner, with fractions.
    fn place(&self, st: DVec2, wrap: ImageWrap) -> DVec2 {
        // The fraction is taken first, to keep its digits where the coordinates are large.
        let st = if wrap == ImageWrap::Repeat { st - st.floor() } else { st };
        DVec2::new(st.x * self.width as f64, (1.0 - st.y) * self.height as f64)
    }

    pub(super) fn point(&self, st: DVec2, wrap: ImageWrap) -> [f32; 3] {
        let p = self.place(st, wrap);
        // Rows count downwards: a value on the border between two belongs to the upper one, as columns do to
        // the right.
        TexelReader::new(self).wrapped(p.x.floor() as i64, (p.y.ceil() as i64).saturating_sub(1), wrap)
    }

    pub(super) fn bilinear(&self, st: DVec2, wrap: ImageWrap) -> [f32; 3] {
        let p = self.place(st, wrap) - 0.5;
        let corner = p.floor();
        let (column, row) = (corner.x as i64, corner.y as i64);
        let (fx, fy) = ((p.x - corner.x) as f32, (p.y - corner.y) as f32);
        let mut reader = TexelReader::new(self);
        let mut at =
            |dc: i64, dr: i64| reader.wrapped(column.saturating_add(dc), row.saturating_add(dr), wrap);
        let (a, c, b, d) = (at(0, 0), at(0, 1), at(1, 0), at(1, 1));
        std::array::from_fn(|i| {
            let (top, bottom) = (a[i] + fx * (b[i] - a[i]), c[i] + fx * (d[i] - c[i]));
            top + fy * (bottom - top)
        })
    }

    /// The next smaller level in memory; `None` after one pixel.
    pub(super) fn next(&self) -> Option<Self> {
        (self.width.max(self.height) > 1).then(|| {
            let [width, height] = self.halved_size();
            Self::new(width, height, self.halved(0..width, 0..height))
        })
    }

    fn halved_size(&self) -> [usize; 2] {
        [self.width, self.height].map(|side| (side / 2).max(1))
    }

    /// Texels of the next smaller level, each the mean of this one over its area.
    fn halved(&self, columns: Range<usize>, rows: Range<usize>) -> TexelValues {
        let [width, height] = self.halved_size();
        let columns: Vec<_> = columns.map(|i| overlaps(i, self.width, width)).collect();
        let (mut reader, planes) = (TexelReader::new(self), self.planes());
        let mut values = Vec::with_capacity(planes * columns.len() * rows.len());
        for row in rows {
            let row = overlaps(row, self.height, height);
            for column in &columns {
                let mut sum = [0.0_f64; 3];
                for &(r, wr) in &row {
                    for &(c, wc) in column {
                        for (s, t) in sum.iter_mut().zip(reader.texel(c, r)) {
                            *s += wr * wc * f64::from(t);
                        }
                    }
                }
                values.extend(sum.iter().take(planes).map(|s| *s as f32));
            }
        }
        TexelValues::Floats { values, planes }
    }
}

impl CachedLevel {
    /// The tile with this number of the level, of which `columns` lie beside each other.
    fn tile(&self, number: usize, columns: usize, level: &MipLevel) -> Arc<TexelValues> {
        self.cache.tile(self.first + number as u64, || match &self.source {
            TileSource::File { start, format } => {
                let bytes = level.tile_size().iter().product::<usize>() * format.texel_bytes();
                format.texels(self.cache.read(bytes, start + number as u64 * bytes as u64))
            }
            TileSource::Larger(larger) => {
                let corner = [number % columns, number / columns].map(|tile| TILE * tile);
                let size = [level.width - corner[0], level.height - corner[1]].map(|side| side.min(TILE));
                let [across, down] = [0, 1].map(|i| corner[i]..corner[i] + size[i]);
                larger.halved(across, down).with_row_length(size[0], level.tile_size()[0])
            }
        })
    }
}

/// Reads the texels of a level; those near the one before are found at once.
struct TexelReader<'a> {
    level: &'a MipLevel,
    tile: Option<(usize, Arc<TexelValues>)>,
}

impl<'a> TexelReader<'a> {
    fn new(level: &'a MipLevel) -> Self {
        Self { level, tile: None }
    }

    /// A texel within the level.
    #[inline]
    fn texel(&mut self, column: usize, row: usize) -> [f32; 3] {
        match &self.level.texels {
            LevelTexels::Memory(block) => block.texel(row * self.level.width + column),
            LevelTexels::Cached(cached) => self.cached_texel(cached, column, row),
        }
    }

    fn cached_texel(&mut self, cached: &CachedLevel, column: usize, row: usize) -> [f32; 3] {
        let columns = self.level.tile_columns();
        let number = (row / TILE) * columns + column / TILE;
        let tile = match &mut self.tile {
            Some((known, tile)) if *known == number => tile,
            slot => &mut slot.insert((number, cached.tile(number, columns, self.level))).1,
        };
        tile.texel((row % TILE) * self.level.tile_size()[0] + column % TILE)
    }

    /// A texel at any place.
    #[inline]
    fn wrapped(&mut self, column: i64, row: i64, wrap: ImageWrap) -> [f32; 3] {
        let (width, height) = (self.level.width as i64, self.level.height as i64);
        let (column, row) = match wrap {
            ImageWrap::Repeat => (column.rem_euclid(width), row.rem_euclid(height)),
            ImageWrap::Clamp => (column.clamp(0, width - 1), row.clamp(0, height - 1)),
            ImageWrap::Black if (0..width).contains(&column) && (0..height).contains(&row) => (column, row),
            ImageWrap::Black => return [0.0; 3],
            ImageWrap::OctahedralSphere => {
                let is_beyond = |i: i64, count: i64| i.div_euclid(count) & 1 != 0;
                let (across, along) = (is_beyond(column, width), is_beyond(row, height));
                // Over a border both coordinates are mirrored; the one across it continues in itself.
                let mirrored = |i: i64, count: i64| {
                    if across != along { count - 1 - i.rem_euclid(count) } else { i.rem_euclid(count) }
                };
                (mirrored(column, width), mirrored(row, height))
            }
        };
        self.texel(column as usize, row as usize)
    }
}

/// The indices of the `from` equal intervals that overlap the interval `i` of `to` equal ones, with their fractions of it.
fn overlaps(i: usize, from: usize, to: usize) -> Vec<(usize, f64)> {
    // In units of 1 / (from * to) everything is an integer.
    let (low, high) = (i * from, (i + 1) * from);
    (low / to..high.div_ceil(to))
        .map(|j| {
            let shared = high.min((j + 1) * to) - low.max(j * to);
            (j, shared as f64 / from as f64)
        })
        .collect()
}
