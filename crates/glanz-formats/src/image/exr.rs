//! OpenEXR: any number of named float planes.

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use ::exr::block::BlockIndex;
use ::exr::block::samples::Sample;
use ::exr::image::write::WritableImage;
use ::exr::image::write::channels::{ChannelsWriter, WritableChannels};
use ::exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image as ExrImage, Layer};
use ::exr::math::{RoundingMode, Vec2};
use ::exr::meta::attribute::{AttributeValue, ChannelDescription, ChannelList, LevelMode, SampleType, Text};
use ::exr::meta::header::{Header, LayerAttributes};
use ::exr::meta::{BlockDescription, MetaData};
use ::exr::prelude::{Compression, LineOrder, ReadChannels, ReadLayers, SmallVec, read as exr_read};
use glanz_job::{MemoryReservation, ResourceBudget};
use glanz_light::Pixels;

use super::error::{check_size, reserve};
use super::{Format, Image, ImageError, RowPicture};
use crate::budget_reader::BudgetReader;

/// Copies of a block that decompression makes.
const BLOCK_COPIES: u64 = 4;

/// Largest number of values that a byte can unpack to: zlib compresses 1032 to 1, and PXR24 stores 4 bytes in 3. Before that, the lossy DWA packs flat
/// blocks of 64 pixels into one value.
const RATIO: u64 = 2048;
const RATIO_DWA: u64 = 64 * 2048;

/// Position of the first attribute in the file.
const HEADER_START: usize = 8;

/// Number of bytes of the header that are read at a time.
const HEADER_PART: u64 = 1 << 16;

/// Reads all layers. The name of a channel is that in the file, prefixed by the layer's name and a dot if the layer has one.
/// Layers of another size than the first are named in `skipped_layers`. Integers become the nearest `f32`.
pub(super) fn read(bytes: &[u8], budget: &ResourceBudget) -> Result<(Image, MemoryReservation), ImageError> {
    let reader = BudgetReader::new(bytes, budget);
    let meta = MetaData::read_from_buffered(reader, false).map_err(reading_error)?;
    for header in &meta.headers {
        check_header(header, bytes.len(), budget)?;
    }
    let sum = |of: fn(&Header) -> u64| meta.headers.iter().map(of).fold(0, u64::saturating_add);
    let memory = reserve(Format::Exr, sum(decoder_bytes), sum(float_samples), budget)?;
    let image = decode(bytes, budget)?;
    let mut pixels: Option<Pixels> = None;
    let mut skipped_layers = Vec::new();
    let mut attributes = BTreeMap::new();
    for (index, layer) in image.layer_data.into_iter().enumerate() {
        texts(&layer.attributes, &mut attributes);
        let name = layer.attributes.layer_name.as_ref().map(text).filter(|n| !n.is_empty());
        let (width, height) = (layer.size.0 as u32, layer.size.1 as u32);
        let target = match &mut pixels {
            Some(p) if (p.width(), p.height()) != (width, height) => {
                skipped_layers.push(name.unwrap_or_else(|| format!("layer {index}")));
                continue;
            }
            Some(p) => p,
            None => pixels.insert(Pixels::try_new(width, height)?),
        };
        add_layer(target, name.as_deref(), layer.channel_data.list)?;
    }
    let pixels = pixels.ok_or_else(|| damaged("the file has no layer".to_owned()))?;
    Ok((Image { pixels, format: Format::Exr, attributes, skipped_layers }, memory))
}

type Layers = ::exr::image::Layers<AnyChannels<FlatSamples>>;

fn decode(bytes: &[u8], budget: &ResourceBudget) -> Result<ExrImage<Layers>, ImageError> {
    let decode = || {
        exr_read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .non_parallel()
            .from_buffered(BudgetReader::new(bytes, budget))
    };
    // With overflow checks on, exr 1.74.2 panics on damaged B44 blocks (compression/b44, unpack14); nothing else was
    // found in millions of damaged files. The closure owns all data that it changes.
    match std::panic::catch_unwind(std::panic::AssertUnwindSafe(decode)) {
        Ok(result) => result.map_err(reading_error),
        Err(_) => Err(damaged("the decoder gave up on damaged data".to_owned())),
    }
}

/// Sizes are checked before the decoder allocates.
fn check_header(header: &Header, bytes: usize, budget: &ResourceBudget) -> Result<(), ImageError> {
    let (width, height) = (header.layer_size.0 as u64, header.layer_size.1 as u64);
    let channels = header.channels.list.len() as u64;
    let ratio = match header.compression {
        Compression::DWAA(_) | Compression::DWAB(_) => RATIO_DWA,
        _ => RATIO,
    };
    check_size(Format::Exr, (width, height, channels), bytes, ratio, budget)
}

/// Number of pixels of a layer times the number of channels that `select` chooses.
fn samples(header: &Header, select: impl Fn(SampleType) -> bool) -> u64 {
    let pixels = (header.layer_size.0 as u64).saturating_mul(header.layer_size.1 as u64);
    let channels = header.channels.list.iter().filter(|channel| select(channel.sample_type)).count();
    pixels.saturating_mul(channels as u64)
}

/// Values of the planes.
fn float_samples(header: &Header) -> u64 {
    samples(header, |_| true)
}

/// Bytes of the decoder beside the planes: values of other types than those of the planes, and blocks, of which it makes copies.
fn decoder_bytes(header: &Header) -> u64 {
    let others = samples(header, |kind| kind != SampleType::F32).saturating_mul(4);
    others.saturating_add(block_bytes(header).saturating_mul(BLOCK_COPIES))
}

/// Bytes of the largest block: a tile, of which no more than the picture holds values, or some lines.
fn block_bytes(header: &Header) -> u64 {
    let (width, height) = (header.layer_size.0 as u64, header.layer_size.1 as u64);
    let (width, height) = match header.blocks {
        BlockDescription::Tiles(tiles) => {
            (width.min(tiles.tile_size.0 as u64), height.min(tiles.tile_size.1 as u64))
        }
        BlockDescription::ScanLines => (width, height.min(header.compression.scan_lines_per_block() as u64)),
    };
    width.saturating_mul(height).saturating_mul(header.channels.bytes_per_pixel as u64)
}

/// Adds the channels of a layer under unused names.
fn add_layer(
    pixels: &mut Pixels,
    layer: Option<&str>,
    channels: SmallVec<[AnyChannel<FlatSamples>; 4]>,
) -> Result<(), ImageError> {
    for channel in channels {
        let plain = text(&channel.name);
        let name = match layer {
            Some(layer) => format!("{layer}.{plain}"),
            None => plain,
        };
        let values = match channel.sample_data {
            FlatSamples::F32(values) => values,
            other => other.values().map(Sample::to_f32).collect(),
        };
        pixels.add_channel(&name, values)?;
    }
    Ok(())
}

/// Collects the attributes that are texts; those of earlier layers take precedence.
fn texts(from: &LayerAttributes, to: &mut BTreeMap<String, String>) {
    for (name, value) in
        [("software", &from.software_name), ("comments", &from.comments), ("owner", &from.owner)]
    {
        if let Some(value) = value {
            to.entry(name.to_owned()).or_insert_with(|| text(value));
        }
    }
    for (name, value) in &from.other {
        if let AttributeValue::Text(value) = value {
            to.entry(text(name)).or_insert_with(|| text(value));
        }
    }
}

/// Channels whose rows are read when they are written.
struct ExrRows<F> {
    channels: ChannelList,
    source: Mutex<RowSource<F>>,
}

/// The source of rows, and its first error.
struct RowSource<F> {
    rows: F,
    error: Option<io::Error>,
}

impl<'a, F: FnMut(Range<u32>) -> io::Result<Pixels> + Send + 'a> WritableChannels<'a> for ExrRows<F> {
    type Writer = &'a Self;

    fn infer_channel_list(&self) -> ChannelList {
        self.channels.clone()
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_writer(&'a self, _: &Header) -> &'a Self {
        self
    }
}

impl<F: FnMut(Range<u32>) -> io::Result<Pixels> + Send> ChannelsWriter for &ExrRows<F> {
    /// The lines of the block, each with its channels one after the other; zeros after an error.
    fn extract_uncompressed_block(&self, _: &Header, block: BlockIndex) -> Vec<u8> {
        let (Vec2(width, height), first) = (block.pixel_size, block.pixel_position.y() as u32);
        let channels = &self.channels.list;
        let mut source = self.source.lock().unwrap_or_else(PoisonError::into_inner);
        let read = match source.error {
            None => (source.rows)(first..first + height as u32),
            Some(_) => return vec![0; width * height * channels.len() * 4],
        };
        let lines = read.and_then(|pixels| {
            let planes = channels.iter().map(|channel| pixels.channel(&text(&channel.name)));
            let planes = planes.collect::<Option<Vec<&[f32]>>>().filter(|_| pixels.len() == width * height);
            let planes = planes.ok_or_else(|| io::Error::other("rows of another picture"))?;
            let rows = |plane: &[f32], row: usize| plane[row * width..(row + 1) * width].to_vec();
            let values = (0..height).flat_map(|row| planes.iter().flat_map(move |plane| rows(plane, row)));
            Ok(values.flat_map(f32::to_ne_bytes).collect())
        });
        lines.unwrap_or_else(|error| {
            source.error = Some(error);
            vec![0; width * height * channels.len() * 4]
        })
    }
}

/// Writes a single layer of 32 bit floats, ZIP compressed, with channels sorted by name.
pub(super) fn write(
    picture: &RowPicture<'_>,
    out: &mut (impl Read + Write + Seek),
    rows: impl FnMut(Range<u32>) -> io::Result<Pixels> + Send,
) -> Result<(), ImageError> {
    let mut list = SmallVec::new();
    for channel in picture.channels {
        list.push(ChannelDescription::named(checked_name(channel)?, SampleType::F32));
    }
    if list.is_empty() {
        return Err(not_writable("a picture without channels cannot be stored".to_owned()));
    }
    list.sort_by(|a: &ChannelDescription, b| a.name.cmp(&b.name));
    let mut layer_attributes = LayerAttributes::default();
    for (name, value) in picture.attributes {
        let value = Text::from_slice_unchecked(value.as_bytes());
        match name.as_str() {
            "software" => layer_attributes.software_name = Some(value),
            "comments" => layer_attributes.comments = Some(value),
            "owner" => layer_attributes.owner = Some(value),
            _ => {
                layer_attributes.other.insert(checked_name(name)?, AttributeValue::Text(value));
            }
        }
    }
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: ::exr::image::Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = picture.size.map(|side| side as usize);
    let source = Mutex::new(RowSource { rows, error: None });
    let channels = ExrRows { channels: ChannelList::new(list), source };
    let image = ExrImage::from_layer(Layer::new((size[0], size[1]), layer_attributes, encoding, channels));
    let written = image.write().non_parallel().to_buffered(BufWriter::new(&mut *out));
    let source = image.layer_data.channel_data.source.into_inner().unwrap_or_else(PoisonError::into_inner);
    if let Some(error) = source.error {
        return Err(error.into());
    }
    written.map_err(|error| match error {
        ::exr::error::Error::Io(error) => ImageError::Write(error),
        other => not_writable(other.to_string()),
    })?;
    sort_attributes(out)
}

/// Sorts the attributes of a single-layer header by name. The library writes them in the order
/// of a hash map, which differs from run to run; the same picture must give the same bytes.
fn sort_attributes(file: &mut (impl Read + Write + Seek)) -> Result<(), ImageError> {
    let mut header = Vec::new();
    let mut sorted = None;
    file.rewind()?;
    // The header ends in the first part of the file, whose length is not known.
    while sorted.is_none() {
        if file.take(HEADER_PART).read_to_end(&mut header)? == 0 {
            return Err(not_writable("the header is broken".to_owned()));
        }
        sorted = sorted_attributes(&header);
    }
    file.seek(SeekFrom::Start(HEADER_START as u64))?;
    Ok(file.write_all(&sorted.unwrap_or_default())?)
}

/// The attributes of a header, sorted; `None` if the file goes on.
fn sorted_attributes(file: &[u8]) -> Option<Vec<u8>> {
    let mut entries: Vec<(Vec<u8>, Vec<u8>)> = Vec::new();
    let mut at = HEADER_START;
    while *file.get(at)? != 0 {
        let name = at + file.get(at..)?.iter().position(|&b| b == 0)?;
        let kind = name + 1 + file.get(name + 1..)?.iter().position(|&b| b == 0)?;
        let size = <[u8; 4]>::try_from(file.get(kind + 1..kind + 5)?).ok()?;
        let end = (kind + 5).checked_add(u32::from_le_bytes(size) as usize)?;
        entries.push((file.get(at..name)?.to_vec(), file.get(at..end)?.to_vec()));
        at = end;
    }
    entries.sort();
    Some(entries.into_iter().flat_map(|(_, bytes)| bytes).collect())
}

/// The name as stored. Refuses names that the format cannot store: stored names end with a zero byte and have at most 255 bytes.
fn checked_name(name: &str) -> Result<Text, ImageError> {
    if name.is_empty() || name.len() > 255 || name.contains('\0') {
        return Err(not_writable(format!("\"{name}\" cannot be the name of a channel or an attribute")));
    }
    Ok(Text::from_slice_unchecked(name.as_bytes()))
}

fn text(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

fn reading_error(error: ::exr::error::Error) -> ImageError {
    match error {
        ::exr::error::Error::NotSupported(message) => {
            ImageError::Unsupported { format: Format::Exr, message: message.into_owned() }
        }
        other => damaged(other.to_string()),
    }
}

fn damaged(message: String) -> ImageError {
    ImageError::Damaged { format: Format::Exr, offset: None, message }
}

fn not_writable(message: String) -> ImageError {
    ImageError::NotWritable { format: Format::Exr, message }
}
