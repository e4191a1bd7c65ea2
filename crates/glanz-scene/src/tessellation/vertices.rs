//! The vertices of the edges of a group.

use glanz_math::DVec3;

/// Points, of which several may be one vertex.
#[derive(Clone, Debug, Default)]
pub(super) struct Vertices {
    /// Metres.
    pub(super) positions: Vec<DVec3>,
    /// Each refers to another that is the same, or to itself.
    joined: Vec<u32>,
}

impl Vertices {
    /// Adds a vertex.
    pub(super) fn add(&mut self, position: DVec3) -> u32 {
        let number = self.positions.len() as u32;
        self.positions.push(position);
        self.joined.push(number);
        number
    }

    /// The vertex that stands for one and all that are the same.
    pub(super) fn representative(&mut self, vertex: u32) -> u32 {
        let parent = |joined: &[u32], i: u32| joined.get(i as usize).copied().unwrap_or(i);
        let mut at = vertex;
        while parent(&self.joined, at) != at {
            let above = parent(&self.joined, parent(&self.joined, at));
            self.joined[at as usize] = above;
            at = above;
        }
        at
    }

    /// Makes two vertices the same.
    pub(super) fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.representative(a), self.representative(b));
        let (low, high) = (a.min(b), a.max(b));
        if let Some(parent) = self.joined.get_mut(high as usize) {
            *parent = low;
        }
    }
}
