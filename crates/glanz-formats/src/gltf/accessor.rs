//! Accessors: lists of numbers and vectors in buffers, which are checked once and then read element by element.

use super::buffers::Buffers;
use super::error::GltfError;
use super::json::{Document, JsonObject, JsonPath};

/// The type of a stored number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(object: &JsonObject<'_>) -> Result<Self, GltfError> {
        Ok(match object.required_count("componentType")? {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            other => return Err(object.error("componentType", format!("the type {other} is unknown"))),
        })
    }

    /// The type of a list of indices.
    fn of_indices(object: &JsonObject<'_>) -> Result<Self, GltfError> {
        match Self::of(object)? {
            Self::I8 | Self::I16 | Self::F32 => {
                Err(object.error("componentType", "indices are whole numbers without a sign"))
            }
            component => Ok(component),
        }
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number at the start of `bytes`.
    fn read(self, bytes: &[u8]) -> f64 {
        let one = || bytes.first().copied().unwrap_or_default();
        let two = || bytes.first_chunk().copied().unwrap_or_default();
        let four = || bytes.first_chunk().copied().unwrap_or_default();
        match self {
            Self::I8 => f64::from(one().cast_signed()),
            Self::U8 => f64::from(one()),
            Self::I16 => f64::from(i16::from_le_bytes(two())),
            Self::U16 => f64::from(u16::from_le_bytes(two())),
            Self::U32 => f64::from(u32::from_le_bytes(four())),
            Self::F32 => f64::from(f32::from_le_bytes(four())),
        }
    }

    /// The value of a normalised integer; signed ones have two representations of -1.
    fn normalized(self, value: f64) -> f64 {
        match self {
            Self::I8 => (value / 127.0).max(-1.0),
            Self::U8 => value / 255.0,
            Self::I16 => (value / 32767.0).max(-1.0),
            Self::U16 => value / 65535.0,
            Self::U32 | Self::F32 => value,
        }
    }
}

/// Elements at a constant distance in a buffer; every one lies in `bytes`.
#[derive(Clone, Copy, Debug)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
}

impl<'a> Strided<'a> {
    fn element(&self, index: usize) -> &'a [u8] {
        self.bytes.get(index * self.stride..).unwrap_or_default()
    }
}

/// Elements that replace some of a list.
#[derive(Clone, Copy, Debug)]
struct SparseElements<'a> {
    count: usize,
    /// Their numbers, ascending.
    numbers: Strided<'a>,
    number: Component,
    values: Strided<'a>,
}

/// A list in a buffer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Accessor<'a> {
    /// `None`: zeros.
    elements: Option<Strided<'a>>,
    sparse: Option<SparseElements<'a>>,
    component: Component,
    width: usize,
    normalized: bool,
    count: usize,
}

/// Which elements a use of an accessor allows.
#[derive(Clone, Copy, Debug)]
pub(super) struct ElementType {
    /// `SCALAR`, `VEC2`, ...
    pub(super) names: &'static [&'static str],
    /// Whether floats are allowed, as everywhere but in indices.
    pub(super) floats: bool,
}

impl<'a> Accessor<'a> {
    /// The accessor with this number, which the value at `from` names.
    ///
    /// All elements are in their buffers; accessors without a view have no more elements than there are bytes in all buffers.
    pub(super) fn open(
        (document, buffers): (&Document, &'a Buffers<'_>),
        index: usize,
        needed: ElementType,
        from: &JsonPath<'_>,
    ) -> Result<Self, GltfError> {
        document.element("accessors", index, from, |object| {
            let width = width(&object, needed)?;
            let component =
                if needed.floats { Component::of(&object)? } else { Component::of_indices(&object)? };
            let count = object.required_count("count")?;
            if count > u32::MAX as usize {
                return Err(object.error("count", format!("{count} elements are more than 2^32")));
            }
            let size = width * component.size();
            let elements = match object.count("bufferView")? {
                Some(view) => {
                    let offset = object.count("byteOffset")?.unwrap_or(0);
                    let view = (view, offset, "bufferView");
                    Some(strided((document, buffers), view, size, count, &object)?)
                }
                None if count > buffers.size() => {
                    let message =
                        format!("{count} zeros are more than the file can need; name a buffer view");
                    return Err(object.error("count", message));
                }
                None => None,
            };
            let sparse = object.object("sparse", |sparse| {
                sparse.map(|sparse| sparse_elements((document, buffers), &sparse, size, count)).transpose()
            })?;
            let normalized = object.boolean("normalized")? && needed.floats;
            Ok(Self { elements, sparse, component, width, normalized, count })
        })
    }

    /// Number of elements.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Whether it has a buffer view.
    pub(super) fn is_stored(&self) -> bool {
        self.elements.is_some()
    }

    /// Number of elements that replace others.
    pub(super) fn replaced(&self) -> usize {
        self.sparse.map_or(0, |sparse| sparse.count)
    }

    /// Element `index` below the count; components that it does not have are those of `default`.
    pub(super) fn vector<const N: usize>(&self, index: usize, default: [f64; N]) -> [f64; N] {
        let replaced = self.sparse.and_then(|sparse| sparse.find(index));
        let Some(bytes) = replaced.or_else(|| self.elements.map(|elements| elements.element(index))) else {
            let mut zeros = default;
            zeros.iter_mut().take(self.width).for_each(|x| *x = 0.0);
            return zeros;
        };
        let mut vector = default;
        for (i, x) in vector.iter_mut().take(self.width).enumerate() {
            let value = self.component.read(bytes.get(i * self.component.size()..).unwrap_or_default());
            *x = if self.normalized { self.component.normalized(value) } else { value };
        }
        vector
    }

    /// Element `index` below the count of a list of indices.
    pub(super) fn number(&self, index: usize) -> u32 {
        self.vector(index, [0.0; 1])[0] as u32
    }
}

impl<'a> SparseElements<'a> {
    fn number(&self, position: usize) -> usize {
        self.number.read(self.numbers.element(position)) as usize
    }

    fn find(&self, index: usize) -> Option<&'a [u8]> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = low + (high - low) / 2;
            match self.number(middle).cmp(&index) {
                std::cmp::Ordering::Equal => return Some(self.values.element(middle)),
                std::cmp::Ordering::Less => low = middle + 1,
                std::cmp::Ordering::Greater => high = middle,
            }
        }
        None
    }
}

/// Number of components of the elements.
fn width(object: &JsonObject<'_>, needed: ElementType) -> Result<usize, GltfError> {
    let name = object.text("type")?.unwrap_or_default();
    if !needed.names.contains(&name) {
        let message = format!("the type is {name:?}; {} is needed here", needed.names.join(" or "));
        return Err(object.error("type", message));
    }
    Ok(match name {
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => 1,
    })
}

/// `count` elements of `size` bytes in a view, from an offset on.
fn strided<'a>(
    (document, buffers): (&Document, &'a Buffers<'_>),
    (view, offset, name): (usize, usize, &str),
    size: usize,
    count: usize,
    object: &JsonObject<'_>,
) -> Result<Strided<'a>, GltfError> {
    let view = buffers.view(document, view, &object.path().name(name))?;
    let stride = view.stride.unwrap_or(size);
    let last = count.checked_sub(1).and_then(|steps| steps.checked_mul(stride)?.checked_add(size));
    let end = if count == 0 { Some(offset) } else { last.and_then(|length| length.checked_add(offset)) };
    let fits = end.is_some_and(|end| end <= view.bytes.len());
    match view.bytes.get(offset..) {
        Some(bytes) if fits && stride >= size => Ok(Strided { bytes, stride }),
        _ => {
            let found = view.bytes.len();
            Err(object.fault(format!(
                "{count} elements of {size} bytes, every {stride} bytes from {offset} on, do not fit in the {found} bytes of the buffer view"
            )))
        }
    }
}

fn sparse_elements<'a>(
    data: (&Document, &'a Buffers<'_>),
    object: &JsonObject<'_>,
    size: usize,
    total: usize,
) -> Result<SparseElements<'a>, GltfError> {
    let count = object.required_count("count")?;
    let part = |part: JsonObject<'_>, size: usize| {
        let (view, offset) = (part.required_count("bufferView")?, part.count("byteOffset")?.unwrap_or(0));
        strided(data, (view, offset, "bufferView"), size, count, &part)
    };
    let (numbers, number) = object.object_or_empty("indices", |indices| {
        let number = Component::of_indices(&indices)?;
        Ok((part(indices, number.size())?, number))
    })?;
    let values = object.object_or_empty("values", |values| part(values, size))?;
    let sparse = SparseElements { count, numbers, number, values };
    let mut least = 0;
    for position in 0..count {
        let found = sparse.number(position);
        if found < least || found >= total {
            let message = format!(
                "index {found} at position {position} does not ascend, or is not below the {total} elements"
            );
            return Err(object.error("indices", message));
        }
        least = found + 1;
    }
    Ok(sparse)
}
