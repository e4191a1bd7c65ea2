//! The picture of a film.

use std::ops::Range;

use glanz_light::Pixels;

use super::{Film, FilmError};
use crate::channels::{channel_names, channel_values};
use crate::edges::EdgeLayer;
use crate::pixel::PixelValue;
use crate::splat::SplatSums;

impl Film {
    /// The share of the samples of each pixel that hit a surface, row by row; 0 without channels of the first hit.
    ///
    /// # Errors
    /// [`FilmError::File`] if a film in a file cannot be read.
    pub fn hit_shares(&self) -> Result<Vec<f32>, FilmError> {
        let width = self.format.crop.size[0] as usize;
        let mut shares = vec![0.0; self.format.crop.len() as usize];
        for strip in self.strips() {
            let words = self.sums.get(strip.words.clone())?;
            for (tile, [x, y], sums) in self.pixels_of(&strip, &words) {
                let samples = self.samples_of_tile(tile).max(1);
                shares[y as usize * width + x as usize] = sums.hits() as f32 / samples as f32;
            }
        }
        Ok(shares)
    }

    /// Splatted light of the pixel in that row and column of the crop window.
    fn splatted(&self, row: usize, column: usize) -> Option<[PixelValue; 3]> {
        let stride = self.format.splat_layout().words();
        let start = (row * self.format.crop.size[0] as usize + column) * stride;
        let words = self.splatted_words().get(start..start + stride)?;
        Some(SplatSums::read(words).values(self.samples.total(), self.format.crop.len()))
    }

    /// The picture of the crop window: `R G B` and the extra channels.
    ///
    /// The values are those of [`PixelSums::radiance`](crate::pixel::PixelSums::radiance), with the splatted light, and [`PixelSums::first_hit`](crate::pixel::PixelSums::first_hit), rounded to `f32`. Where no
    /// sample hit a surface, geometry and albedo are 0 and `id` is -1. A film without samples is black. Edges lie over `R G B` alone.
    ///
    /// # Errors
    /// [`FilmError::Pixels`] as [`Pixels::try_new`] and [`Pixels::add_channel`], [`FilmError::File`] if a film in a file cannot be read.
    pub fn to_pixels(&self) -> Result<Pixels, FilmError> {
        self.to_pixels_of(0..self.format.crop.size[1], self.edges.as_ref())
    }

    /// As [`Film::to_pixels`], of some rows of the crop window. Rows from a multiple of 16 to another are read once.
    ///
    /// # Errors
    /// As [`Film::to_pixels`].
    pub fn rows_to_pixels(&self, rows: Range<u32>) -> Result<Pixels, FilmError> {
        self.to_pixels_of(rows, self.edges.as_ref())
    }

    /// As [`Film::to_pixels`], without the lines.
    ///
    /// # Errors
    /// As [`Film::to_pixels`].
    pub fn to_pixels_without_edges(&self) -> Result<Pixels, FilmError> {
        self.to_pixels_of(0..self.format.crop.size[1], None)
    }

    fn to_pixels_of(&self, rows: Range<u32>, edges: Option<&EdgeLayer>) -> Result<Pixels, FilmError> {
        let [width, height] = self.format.crop.size;
        let rows = rows.start..rows.end.min(height);
        let mut pixels = Pixels::try_new(width, rows.end.saturating_sub(rows.start))?;
        let names = channel_names(self.format.aovs);
        let mut planes: Vec<Vec<f32>> = names.iter().map(|_| vec![0.0; pixels.len()]).collect();
        let blend = self.blend();
        for strip in self.strips_of(&rows) {
            let words = self.sums.get(strip.words.clone())?;
            for (tile, [x, y], sums) in
                self.pixels_of(&strip, &words).filter(|(_, [_, y], _)| rows.contains(y))
            {
                let at = y as usize * width as usize + x as usize;
                let mut radiance = match self.format.noise {
                    Some(_) => sums.radiance(self.samples_of_tile(tile)),
                    None => sums.blended(&blend),
                };
                // Splats and the pixel's own samples are independent: their variances add up.
                for (own, splatted) in
                    radiance.iter_mut().zip(self.splatted(y as usize, x as usize).into_iter().flatten())
                {
                    own.mean += splatted.mean;
                    own.variance += splatted.variance;
                }
                if let Some(edges) = edges {
                    let [r, g, b] = edges.over(at, radiance.map(|band| band.mean));
                    [radiance[0].mean, radiance[1].mean, radiance[2].mean] = [r, g, b];
                }
                let values = channel_values(self.format.aovs, &radiance, sums.first_hit().as_ref());
                let at = at - rows.start as usize * width as usize;
                for (plane, value) in planes.iter_mut().zip(values) {
                    plane[at] = value;
                }
            }
        }
        for (name, plane) in names.iter().zip(planes) {
            pixels.add_channel(name, plane)?;
        }
        Ok(pixels)
    }
}
