//! The numbers for the graphics card, and their layout in the file.

use std::collections::BTreeMap;

use super::head::BlockRange;

/// Magic number of a model.
const MAGIC: &[u8; 8] = b"GLANZVW1";

/// Blocks start at multiples of this, bytes.
const ALIGNMENT: usize = 16;

/// The blocks, row by row.
#[derive(Clone, Debug, Default)]
pub(super) struct Blocks {
    pub(super) patches: Vec<[u32; 16]>,
    pub(super) points: Vec<[f32; 4]>,
    pub(super) region_cells: Vec<[u32; 4]>,
    pub(super) region_entries: Vec<[f32; 4]>,
    pub(super) region_steps: Vec<[f32; 2]>,
    pub(super) region_parts: Vec<[f32; 8]>,
    pub(super) region_points: Vec<[f32; 4]>,
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) indices: Vec<[u32; 3]>,
    pub(super) edge_points: Vec<[f32; 3]>,
    /// Illuminance and area of each cell of the lux maps.
    pub(super) lux_cells: Vec<[f32; 2]>,
    /// Values of each map, by rows.
    pub(super) maps: Vec<Vec<f32>>,
}

/// A number as the file has it.
trait Word: Copy {
    fn bytes(self) -> [u8; 4];
}

impl Word for u32 {
    fn bytes(self) -> [u8; 4] {
        self.to_le_bytes()
    }
}

impl Word for f32 {
    fn bytes(self) -> [u8; 4] {
        self.to_le_bytes()
    }
}

/// Bytes of the blocks added so far, with their ranges.
#[derive(Default)]
struct BlockLayout {
    ranges: BTreeMap<String, BlockRange>,
    bytes: Vec<u8>,
}

impl BlockLayout {
    fn add<W: Word, const N: usize>(&mut self, name: &str, rows: &[[W; N]]) {
        self.add_words(name.to_owned(), rows.as_flattened());
    }

    fn add_words<W: Word>(&mut self, name: String, words: &[W]) {
        let offset = self.bytes.len();
        self.bytes.extend(words.iter().flat_map(|word| word.bytes()));
        self.ranges.insert(name, BlockRange { offset, length: self.bytes.len() - offset });
        pad(&mut self.bytes);
    }
}

fn pad(bytes: &mut Vec<u8>) {
    bytes.resize(bytes.len().next_multiple_of(ALIGNMENT), 0);
}

impl Blocks {
    /// The range of each block, and the bytes of all.
    pub(super) fn layout(&self) -> (BTreeMap<String, BlockRange>, Vec<u8>) {
        let mut layout = BlockLayout::default();
        layout.add("patches", &self.patches);
        layout.add("points", &self.points);
        layout.add("regionCells", &self.region_cells);
        layout.add("regionEntries", &self.region_entries);
        layout.add("regionSteps", &self.region_steps);
        layout.add("regionParts", &self.region_parts);
        layout.add("regionPoints", &self.region_points);
        layout.add("positions", &self.positions);
        layout.add("normals", &self.normals);
        layout.add("indices", &self.indices);
        layout.add("edgePoints", &self.edge_points);
        layout.add("luxCells", &self.lux_cells);
        for (number, map) in self.maps.iter().enumerate() {
            layout.add_words(format!("map{number}"), map);
        }
        (layout.ranges, layout.bytes)
    }
}

/// The file of a text and blocks.
pub(super) fn file(text: &str, blocks: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(2 * ALIGNMENT + text.len() + blocks.len());
    bytes.extend(MAGIC);
    // A text of 4 GiB is out of reach: the number of objects is bounded.
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(0_u32.to_le_bytes());
    bytes.extend(text.as_bytes());
    pad(&mut bytes);
    bytes.extend(blocks);
    bytes
}
