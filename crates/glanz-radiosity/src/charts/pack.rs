//! Rectangles into squares.

/// Where a rectangle lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    /// Number of the square.
    pub page: u32,
    /// Its lower corner.
    pub corner: [u32; 2],
}

/// Rectangles in squares of one size.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packed {
    /// Side of the squares.
    pub side: u32,
    /// Number of squares.
    pub pages: u32,
    /// One for each rectangle, in their order.
    pub slots: Vec<Slot>,
}

/// Packs rectangles with `border` around each into one square with a multiple of 4 as its side, or several if its side would exceed `limit`.
///
/// Rows, the tallest first, each in the first row that has room: with many rectangles about nine tenths of the square are filled.
/// Rectangles with their borders must not exceed `limit`.
#[must_use]
pub fn pack(sizes: &[[u32; 2]], border: u32, limit: u32) -> Packed {
    let grown: Vec<[u32; 2]> = sizes.iter().map(|size| size.map(|n| n + 2 * border)).collect();
    let area: f64 = grown.iter().map(|[w, h]| f64::from(*w) * f64::from(*h)).sum();
    let widest = grown.iter().flatten().copied().max().unwrap_or(1);
    let mut order: Vec<usize> = (0..grown.len()).collect();
    order.sort_by_key(|&i| (std::cmp::Reverse(grown[i][1]), std::cmp::Reverse(grown[i][0]), i));
    let mut side = (area.sqrt() as u32).max(widest).clamp(4, limit).next_multiple_of(4).min(limit);
    loop {
        let (pages, mut slots) = rows(&grown, &order, side);
        if pages <= 1 || side >= limit {
            for slot in &mut slots {
                slot.corner = slot.corner.map(|n| n + border);
            }
            return Packed { side, pages: pages.max(1), slots };
        }
        side = (side + (side / 64).max(4)).next_multiple_of(4).min(limit);
    }
}

/// A row of rectangles.
struct Row {
    page: u32,
    bottom: u32,
    height: u32,
    end: u32,
}

fn rows(sizes: &[[u32; 2]], order: &[usize], side: u32) -> (u32, Vec<Slot>) {
    let mut slots = vec![Slot { page: 0, corner: [0, 0] }; sizes.len()];
    let mut rows: Vec<Row> = Vec::new();
    // Heights used on each page.
    let mut pages: Vec<u32> = Vec::new();
    for &i in order {
        let [width, height] = sizes[i];
        let fits = |row: &&mut Row| row.height >= height && row.end + width <= side;
        let row = match rows.iter_mut().find(fits) {
            Some(row) => row,
            None => {
                let page = pages.iter().position(|used| used + height <= side).unwrap_or(pages.len());
                if page == pages.len() {
                    pages.push(0);
                }
                rows.push(Row { page: page as u32, bottom: pages[page], height, end: 0 });
                pages[page] += height;
                let last = rows.len() - 1;
                &mut rows[last]
            }
        };
        slots[i] = Slot { page: row.page, corner: [row.end, row.bottom] };
        row.end += width;
    }
    (pages.len() as u32, slots)
}
