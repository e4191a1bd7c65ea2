//! Packing of rectangles into squares.

/// Location of a rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AtlasSlot {
    /// Number of the square.
    pub page: u32,
    /// Lower left corner of the rectangle, without its border.
    pub corner: [u32; 2],
}

/// Locations of rectangles in squares of one size.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packing {
    /// Side of the squares.
    pub side: u32,
    /// Number of squares.
    pub pages: u32,
    /// Location of each rectangle, in their order.
    pub slots: Vec<AtlasSlot>,
}

/// Packs rectangles with a border of width `border` into one square, whose side is a multiple of 4, or into several if its side would exceed
/// `limit`.
///
/// Shelf packing: by decreasing height, each rectangle goes onto the first shelf with enough space. Many rectangles fill about nine
/// tenths of the square. Rectangles with their borders must not exceed `limit`.
#[must_use]
pub fn pack(sizes: &[[u32; 2]], border: u32, limit: u32) -> Packing {
    let grown: Vec<[u32; 2]> = sizes.iter().map(|size| size.map(|n| n + 2 * border)).collect();
    let area: f64 = grown.iter().map(|[w, h]| f64::from(*w) * f64::from(*h)).sum();
    let widest = grown.iter().flatten().copied().max().unwrap_or(1);
    let mut order: Vec<usize> = (0..grown.len()).collect();
    order.sort_by_key(|&i| (std::cmp::Reverse(grown[i][1]), std::cmp::Reverse(grown[i][0]), i));
    let mut side = (area.sqrt() as u32).max(widest).max(4).min(limit).next_multiple_of(4).min(limit);
    loop {
        let (pages, mut slots) = shelves(&grown, &order, side);
        if pages <= 1 || side >= limit {
            for slot in &mut slots {
                slot.corner = slot.corner.map(|n| n + border);
            }
            return Packing { side, pages: pages.max(1), slots };
        }
        side = (side + (side / 64).max(4)).next_multiple_of(4).min(limit);
    }
}

/// A row of rectangles of at most `height`.
struct Shelf {
    page: u32,
    bottom: u32,
    height: u32,
    end: u32,
}

fn shelves(sizes: &[[u32; 2]], order: &[usize], side: u32) -> (u32, Vec<AtlasSlot>) {
    let mut slots = vec![AtlasSlot { page: 0, corner: [0, 0] }; sizes.len()];
    let mut shelves: Vec<Shelf> = Vec::new();
    // Heights used on each page.
    let mut pages: Vec<u32> = Vec::new();
    for &i in order {
        let [width, height] = sizes[i];
        let fits = |shelf: &&mut Shelf| shelf.height >= height && shelf.end + width <= side;
        let shelf = match shelves.iter_mut().find(fits) {
            Some(shelf) => shelf,
            None => {
                let page = pages.iter().position(|used| used + height <= side).unwrap_or(pages.len());
                if page == pages.len() {
                    pages.push(0);
                }
                shelves.push(Shelf { page: page as u32, bottom: pages[page], height, end: 0 });
                pages[page] += height;
                let last = shelves.len() - 1;
                &mut shelves[last]
            }
        };
        slots[i] = AtlasSlot { page: shelf.page, corner: [shelf.end, shelf.bottom] };
        shelf.end += width;
    }
    (pages.len() as u32, slots)
}
