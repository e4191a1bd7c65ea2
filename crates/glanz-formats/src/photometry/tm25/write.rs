//! Writing ray files.

use std::io::{self, BufWriter, Seek, SeekFrom, Write};

use glanz_math::DVec3;

use super::{MAGIC, MILLIMETRE, SourceDescriptions};

/// Offset of the luminous flux in the header, after the magic number, the version and the creation method.
const FLUX_OFFSET: u64 = 12;

/// Bytes of a description.
const DESCRIPTION_BYTES: usize = 4000;

/// Writer of a ray file whose rays have a position, a direction and a luminous flux.
///
/// Rays are written as they come; the header has their number and flux only after [`RayWriter::finish`], without which the file has no rays.
#[derive(Debug)]
pub struct RayWriter<W: Write + Seek> {
    out: BufWriter<W>,
    count: u64,
    lumens: f64,
}

impl<W: Write + Seek> RayWriter<W> {
    /// Writes a header. `date`: after ISO 8601, of which 27 bytes are written. Descriptions are cut after 999 characters. Rays start where they left the
    /// source last, which the standard has no code for: the start position is stated as unknown.
    ///
    /// # Errors
    /// Those of the output.
    pub fn new(mut out: W, descriptions: &SourceDescriptions, date: &str) -> io::Result<Self> {
        // The header is completed at the end: pipes are refused before the first ray.
        out.seek(SeekFrom::Start(0))?;
        let mut header = MAGIC.to_vec();
        // The version; created by simulation; fluxes and number of rays, until they are known.
        header.extend([2013_i32, 0].map(i32::to_le_bytes).as_flattened());
        header.extend([0.0, f32::NAN].map(f32::to_le_bytes).as_flattened());
        header.extend(0_u64.to_le_bytes());
        let date = date.as_bytes();
        let date = date.get(..27).unwrap_or(date);
        header.extend(date);
        header.resize(56, 0);
        // Start position and spectral data.
        header.extend([0_i32, 0].map(i32::to_le_bytes).as_flattened());
        header.extend([f32::NAN; 3].map(f32::to_le_bytes).as_flattened());
        header.resize(256, 0);
        // Known are positions, directions and luminous flux.
        header.extend([1_i32, 1, 0, 0, 1, 0, 0, 0].map(i32::to_le_bytes).as_flattened());
        let of = descriptions;
        for text in [
            &of.name,
            &of.manufacturer,
            &of.model_creator,
            &of.file_creator,
            &of.equipment,
            &of.camera,
            &of.operation,
            &of.information,
            &of.reference,
        ] {
            let end = header.len() + DESCRIPTION_BYTES;
            let characters = text.chars().take(DESCRIPTION_BYTES / 4 - 1);
            header.extend(characters.flat_map(|character| u32::from(character).to_le_bytes()));
            header.resize(end, 0);
        }
        let mut out = BufWriter::with_capacity(1 << 16, out);
        out.write_all(&header)?;
        Ok(Self { out, count: 0, lumens: 0.0 })
    }

    /// Writes a ray. `position`: metres; `direction`: of unit length; `lumens`: its luminous flux, lm.
    ///
    /// # Errors
    /// Those of the output.
    pub fn ray(&mut self, position: DVec3, direction: DVec3, lumens: f32) -> io::Result<()> {
        let [x, y, z] = (position / MILLIMETRE).as_vec3().to_array();
        let [dx, dy, dz] = direction.as_vec3().to_array();
        self.out.write_all([x, y, z, dx, dy, dz, lumens].map(f32::to_le_bytes).as_flattened())?;
        self.count += 1;
        self.lumens += f64::from(lumens);
        Ok(())
    }

    /// Completes the header; returns the number of rays and their flux, lm.
    ///
    /// # Errors
    /// Those of the output.
    pub fn finish(mut self) -> io::Result<(u64, f64)> {
        self.out.seek(SeekFrom::Start(FLUX_OFFSET))?;
        self.out.write_all(&(self.lumens as f32).to_le_bytes())?;
        self.out.write_all(&f32::NAN.to_le_bytes())?;
        self.out.write_all(&self.count.to_le_bytes())?;
        self.out.flush()?;
        Ok((self.count, self.lumens))
    }
}
