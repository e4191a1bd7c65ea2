//! Messages queued for a page.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;

use super::tile::Tile;

/// Status of a stream.
#[derive(Clone, Debug, PartialEq)]
pub enum StreamStatus {
    /// A pass has ended.
    Progress {
        /// Per pixel.
        samples: u64,
        /// Root mean square of the standard errors of the pixels over the mean luminance; `None` while that is not known.
        noise: Option<f64>,
        /// Time that was spent rendering.
        seconds: f64,
        /// True if no more samples follow.
        done: bool,
    },
    /// It waits for a processor share.
    Waiting,
    /// It failed.
    Failed(String),
}

/// A message to send.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum OutboxMessage {
    /// The bytes of a tile.
    Tile(Vec<u8>),
    /// The status of the view with this id.
    Status(u32, StreamStatus),
}

/// Outbox of a page: the newest version of each tile, and the newest status. It holds at most one image, however slow the page is.
///
/// Tiles are sent in the order of their first arrival, the status after all tiles.
#[derive(Debug, Default)]
pub struct Outbox {
    content: Mutex<OutboxContent>,
    notify: Notify,
}

#[derive(Debug, Default)]
struct OutboxContent {
    tiles: BTreeMap<[u16; 2], Vec<u8>>,
    order: VecDeque<[u16; 2]>,
    /// Whether a denoised image was put: tiles with noise no longer replace it.
    is_denoised: bool,
    status: Option<(u32, StreamStatus)>,
}

impl OutboxContent {
    fn replace_tiles(&mut self, tiles: Vec<Tile>) {
        self.order = tiles.iter().map(|tile| tile.min).collect();
        self.tiles = tiles.into_iter().map(|tile| (tile.min, tile.bytes)).collect();
    }
}

impl Outbox {
    fn content(&self) -> MutexGuard<'_, OutboxContent> {
        // A panic elsewhere cannot leave the content inconsistent.
        self.content.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Replaces an earlier tile at the same position; without effect after a denoised image.
    pub(crate) fn put_tile(&self, tile: Tile) {
        let mut content = self.content();
        if content.is_denoised {
            return;
        }
        if content.tiles.insert(tile.min, tile.bytes).is_none() {
            content.order.push_back(tile.min);
        }
        drop(content);
        self.notify.notify_one();
    }

    /// Replaces all tiles by a whole image; without effect after a denoised image.
    pub(crate) fn put_picture(&self, tiles: Vec<Tile>) {
        let mut content = self.content();
        if !content.is_denoised {
            content.replace_tiles(tiles);
            drop(content);
            self.notify.notify_one();
        }
    }

    /// Replaces all tiles by a whole denoised image.
    pub(crate) fn put_denoised(&self, tiles: Vec<Tile>) {
        let mut content = self.content();
        content.replace_tiles(tiles);
        content.is_denoised = true;
        drop(content);
        self.notify.notify_one();
    }

    /// Replaces the status by that of the view `id`.
    pub(crate) fn put_status(&self, id: u32, status: StreamStatus) {
        self.content().status = Some((id, status));
        self.notify.notify_one();
    }

    /// Discards all queued messages.
    pub(crate) fn clear(&self) {
        *self.content() = OutboxContent::default();
    }

    fn take(&self) -> Option<OutboxMessage> {
        let mut content = self.content();
        while let Some(place) = content.order.pop_front() {
            if let Some(bytes) = content.tiles.remove(&place) {
                return Some(OutboxMessage::Tile(bytes));
            }
        }
        content.status.take().map(|(id, status)| OutboxMessage::Status(id, status))
    }

    /// Waits for the next message. One task at a time may wait.
    pub(crate) async fn next(&self) -> OutboxMessage {
        loop {
            if let Some(message) = self.take() {
                return message;
            }
            self.notify.notified().await;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tile(x: u32, samples: u64) -> Tile {
        Tile::new(1, [x, 0], [1, 1], samples, [[0.0; 3]].into_iter())
    }

    #[test]
    fn newer_tiles_take_the_place_of_older_ones_and_the_status_comes_last() {
        let outbox = Outbox::default();
        outbox.put_status(1, StreamStatus::Waiting);
        for (x, samples) in [(7, 1), (3, 1), (7, 2)] {
            outbox.put_tile(tile(x, samples));
        }
        outbox.put_status(1, StreamStatus::Failed("x".to_owned()));
        let expected = [
            Some(OutboxMessage::Tile(tile(7, 2).bytes)),
            Some(OutboxMessage::Tile(tile(3, 1).bytes)),
            Some(OutboxMessage::Status(1, StreamStatus::Failed("x".to_owned()))),
            None,
        ];
        assert_eq!([(); 4].map(|()| outbox.take()), expected);
    }

    #[test]
    fn a_picture_takes_the_place_of_all_tiles() {
        let outbox = Outbox::default();
        outbox.put_tile(tile(7, 1));
        outbox.put_picture(vec![tile(2, 5)]);
        assert_eq!(outbox.take(), Some(OutboxMessage::Tile(tile(2, 5).bytes)));
        assert_eq!(outbox.take(), None);
        outbox.put_tile(tile(7, 1));
        outbox.put_status(1, StreamStatus::Waiting);
        outbox.clear();
        assert_eq!(outbox.take(), None);
    }

    #[test]
    fn a_denoised_picture_stays_until_the_next_one_or_the_end_of_the_view() {
        let outbox = Outbox::default();
        outbox.put_tile(tile(7, 1));
        outbox.put_denoised(vec![tile(2, 4)]);
        outbox.put_tile(tile(7, 8));
        outbox.put_picture(vec![tile(3, 8)]);
        assert_eq!(outbox.take(), Some(OutboxMessage::Tile(tile(2, 4).bytes)));
        outbox.put_picture(vec![tile(3, 9)]);
        assert_eq!(outbox.take(), None);
        outbox.put_denoised(vec![tile(2, 16)]);
        assert_eq!(outbox.take(), Some(OutboxMessage::Tile(tile(2, 16).bytes)));
        outbox.clear();
        outbox.put_tile(tile(7, 1));
        assert_eq!(outbox.take(), Some(OutboxMessage::Tile(tile(7, 1).bytes)));
    }
}
