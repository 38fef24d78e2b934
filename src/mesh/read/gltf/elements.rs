//! Accessors (§3.6.2): rows of numbers in a buffer, of which every range is checked before one is read.
//!
//! Sparse accessors, and those without a buffer, which are zeros, are written out; how much that may take in all is limited, since a few
//! letters of JSON can ask for it again and again.

use std::borrow::Cow;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::sync::Arc;

use ::gltf::json::Root;
use ::gltf::json::accessor::{Accessor, ComponentType, Type};
use ::gltf::json::validation::Checked;

use super::super::{Stop, Task, with_room};
use super::buffers::Buffers;
use super::document::{compressed, compression};

/// A type of numbers in a buffer, little-endian.
pub(super) trait Number: 'static {
    const BYTES: usize;
    /// What stands for 1 where numbers are parts of one.
    const ONE: f64;
    /// The number at the start of these bytes.
    fn of(bytes: &[u8]) -> f64;
}

macro_rules! numbers {
    ($($number:ty: $one:expr),*) => {$(
        impl Number for $number {
            const BYTES: usize = size_of::<Self>();
            const ONE: f64 = $one;
            #[inline]
            fn of(bytes: &[u8]) -> f64 {
                Self::from_le_bytes(bytes.first_chunk().copied().unwrap_or_default()).into()
            }
        }
    )*};
}
numbers!(i8: 127.0, u8: 255.0, i16: 32_767.0, u16: 65_535.0, u32: 4_294_967_295.0, f32: 1.0);

/// A type of numbers that may count vertices.
pub(super) trait Counting: 'static {
    /// The number at the start of these bytes.
    fn of(bytes: &[u8]) -> u32;
}

macro_rules! counting {
    ($($number:ty),*) => {$(
        impl Counting for $number {
            #[inline]
            fn of(bytes: &[u8]) -> u32 {
                Self::from_le_bytes(bytes.first_chunk().copied().unwrap_or_default()).into()
            }
        }
    )*};
}
counting!(u8, u16, u32);

/// Calls a function for the type of numbers that a [`ComponentType`] is.
macro_rules! by_number {
    ($kind:expr, $function:ident::<_ $(, $more:tt)*>($($argument:expr),*)) => {
        match $kind {
            ComponentType::I8 => $function::<i8 $(, $more)*>($($argument),*),
            ComponentType::U8 => $function::<u8 $(, $more)*>($($argument),*),
            ComponentType::I16 => $function::<i16 $(, $more)*>($($argument),*),
            ComponentType::U16 => $function::<u16 $(, $more)*>($($argument),*),
            ComponentType::U32 => $function::<u32 $(, $more)*>($($argument),*),
            ComponentType::F32 => $function::<f32 $(, $more)*>($($argument),*),
        }
    };
}
pub(super) use by_number;

/// What an accessor announces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub(super) kind: ComponentType,
    /// Numbers in a row, from 1 to 16.
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Whether whole numbers are parts of one.
    is_normalized: bool,
}

/// What the accessor of a number announces.
pub(super) fn layout(root: &Root, number: usize) -> Result<Layout, Stop> {
    let accessor = accessor(root, number)?;
    let (Checked::Valid(kind), Checked::Valid(columns)) = (accessor.component_type, accessor.type_)
    else {
        let problem = "has a type that glTF does not have: save the file again";
        return Err(Stop::item("accessor", number, problem));
    };
    Ok(Layout {
        kind: kind.0,
        // Columns of matrices of bytes and shorts begin at multiples of four; such matrices are asked for by nobody.
        columns: match columns {
            Type::Scalar => 1,
            Type::Vec2 => 2,
            Type::Vec3 => 3,
            Type::Vec4 | Type::Mat2 => 4,
            Type::Mat3 => 9,
            Type::Mat4 => 16,
        },
        rows: usize::try_from(accessor.count.0).unwrap_or(usize::MAX),
        is_normalized: accessor.normalized && kind.0 != ComponentType::F32,
    })
}

fn accessor(root: &Root, number: usize) -> Result<&Accessor, Stop> {
    root.accessors.get(number).ok_or_else(|| {
        let problem = format!(
            "is not there, there are {}: save the file again",
            root.accessors.len()
        );
        Stop::item("accessor", number, problem)
    })
}

/// Rows of numbers that are all there.
pub(super) struct Elements<'a> {
    /// From the first row's first byte to the last row's last.
    bytes: Cow<'a, [u8]>,
    stride: usize,
    pub(super) layout: Layout,
}

impl Elements<'_> {
    /// The first numbers of a row; zeros beyond the last row.
    #[inline]
    pub(super) fn row<N: Number, const COLUMNS: usize>(&self, row: usize) -> [f64; COLUMNS] {
        let from = row * self.stride;
        let bytes = self.bytes.get(from..from + COLUMNS * N::BYTES);
        let bytes = bytes.unwrap_or_default();
        let mut values = [0.0; COLUMNS];
        for (column, value) in values.iter_mut().enumerate() {
            *value = N::of(bytes.get(column * N::BYTES..).unwrap_or_default());
            if self.layout.is_normalized {
                *value = (*value / N::ONE).max(-1.0);
            }
        }
        values
    }

    /// The first numbers of a row, whichever type they have; zeros for what it has not.
    pub(super) fn any_row<const COLUMNS: usize>(&self, row: usize) -> [f64; COLUMNS] {
        fn read<N: Number, const COLUMNS: usize>(
            elements: &Elements<'_>,
            row: usize,
        ) -> [f64; COLUMNS] {
            elements.row::<N, COLUMNS>(row)
        }
        by_number!(self.layout.kind, read::<_, COLUMNS>(self, row))
    }

    /// The bytes of all rows, where they are so many numbers of a type with nothing between them.
    pub(super) fn packed(&self, kind: ComponentType, columns: usize) -> Option<&[u8]> {
        let layout = &self.layout;
        let is_so = layout.kind == kind && layout.columns == columns;
        (is_so && self.stride == columns * kind.size()).then_some(&*self.bytes)
    }

    /// The first number of a row, as one that counts; 0 beyond the last row.
    #[inline]
    pub(super) fn count<C: Counting>(&self, row: usize) -> u32 {
        C::of(self.bytes.get(row * self.stride..).unwrap_or_default())
    }
}

/// All accessors, each checked when it is first asked for.
pub(super) struct Accessors<'a> {
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    had: RefCell<BTreeMap<usize, Arc<Elements<'a>>>>,
    /// Rows that may still be written out.
    left: Cell<usize>,
}

impl<'a> Accessors<'a> {
    pub(super) fn new(root: &'a Root, buffers: &'a Buffers<'a>, task: &Task<'_>) -> Self {
        Self {
            root,
            buffers,
            had: RefCell::default(),
            left: Cell::new(task.limits.vertices),
        }
    }

    /// The rows of the accessor of a number.
    pub(super) fn get(&self, number: usize) -> Result<Arc<Elements<'a>>, Stop> {
        if let Some(elements) = self.had.borrow().get(&number) {
            return Ok(elements.clone());
        }
        let elements = Arc::new(self.elements(number)?);
        self.had.borrow_mut().insert(number, elements.clone());
        Ok(elements)
    }

    fn elements(&self, number: usize) -> Result<Elements<'a>, Stop> {
        let layout = layout(self.root, number)?;
        let accessor = accessor(self.root, number)?;
        let row = layout.columns * layout.kind.size();
        let place = |view: usize, offset: u64, row: usize, rows: usize| {
            self.range(number, view, offset, row, rows)
        };
        let viewed = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.unwrap_or_default().0;
                Some(place(view.value(), offset, row, layout.rows)?)
            }
            None => None,
        };
        if let (Some((bytes, stride)), None) = (viewed, &accessor.sparse) {
            return Ok(Elements {
                bytes: Cow::Borrowed(bytes),
                stride,
                layout,
            });
        }
        let most = self.buffers.file_bytes;
        if viewed.is_none() && layout.rows > most {
            let problem = format!(
                "announces {} elements and no buffer view that holds them: save the file again",
                layout.rows
            );
            return Err(Stop::item("accessor", number, problem));
        }
        let Some(left) = self.left.get().checked_sub(layout.rows) else {
            let problem = "is one sparse accessor too many, together they are larger than what is read: save the model without sparse accessors";
            return Err(Stop::item("accessor", number, problem));
        };
        self.left.set(left);
        let mut bytes: Vec<u8> = with_room(layout.rows * row)?;
        match viewed {
            Some((from, stride)) => {
                let rows = from.chunks(stride).take(layout.rows);
                rows.for_each(|one| bytes.extend(one.get(..row).unwrap_or_default()));
            }
            None => bytes.resize(layout.rows * row, 0),
        }
        if let Some(sparse) = &accessor.sparse {
            let count = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
            let Checked::Valid(kind) = sparse.indices.component_type else {
                let problem =
                    "has sparse indices of a type that glTF does not have: save the file again";
                return Err(Stop::item("accessor", number, problem));
            };
            let size = kind.0.size();
            let indices = sparse.indices.buffer_view.value();
            let (indices, step) = place(indices, sparse.indices.byte_offset.0, size, count)?;
            let values = sparse.values.buffer_view.value();
            let (values, stride) = place(values, sparse.values.byte_offset.0, row, count)?;
            for (index, value) in indices.chunks(step).zip(values.chunks(stride)) {
                let index = whole(kind.0, index);
                let to = index
                    .checked_mul(row)
                    .and_then(|at| bytes.get_mut(at..at + row));
                let (Some(to), Some(value)) = (to, value.get(..row)) else {
                    let problem = format!(
                        "has a sparse value for element {index}, but there are {}: save the file again",
                        layout.rows
                    );
                    return Err(Stop::item("accessor", number, problem));
                };
                to.copy_from_slice(value);
            }
        }
        Ok(Elements {
            bytes: Cow::Owned(bytes),
            stride: row,
            layout,
        })
    }

    /// The bytes of so many rows in a buffer view, and from one row to the next.
    fn range(
        &self,
        number: usize,
        view: usize,
        offset: u64,
        row: usize,
        rows: usize,
    ) -> Result<(&'a [u8], usize), Stop> {
        let (bytes, stride) = view_bytes(self.root, self.buffers, view)?;
        let stride = stride.unwrap_or(row);
        let fault = |problem: String| Stop::item("accessor", number, problem);
        if stride < row {
            return Err(fault(format!(
                "has elements of {row} bytes, one begun {stride} bytes behind the other: save the file again"
            )));
        }
        if rows == 0 {
            return Ok((&[], stride));
        }
        let from = usize::try_from(offset).ok();
        let length = (rows - 1)
            .checked_mul(stride)
            .and_then(|to| to.checked_add(row));
        let range = from
            .zip(length)
            .and_then(|(from, length)| bytes.get(from..from.checked_add(length)?));
        let range = range.ok_or_else(|| {
            fault(format!(
                "announces {rows} elements of {row} bytes from byte {offset} of buffer view {view} on, which has {} bytes: the file is damaged, save it again",
                bytes.len()
            ))
        })?;
        Ok((range, stride))
    }
}

/// The whole number of these bytes.
fn whole(kind: ComponentType, bytes: &[u8]) -> usize {
    let mut word = [0; 4];
    let size = kind.size().min(bytes.len());
    word[..size].copy_from_slice(&bytes[..size]);
    usize::try_from(u32::from_le_bytes(word)).unwrap_or(usize::MAX)
}

/// The bytes of a buffer view, and the step between rows that it prescribes.
pub(super) fn view_bytes<'a>(
    root: &Root,
    buffers: &'a Buffers<'_>,
    number: usize,
) -> Result<(&'a [u8], Option<usize>), Stop> {
    let fault = |problem: String| Stop::item("buffer view", number, problem);
    let Some(view) = root.buffer_views.get(number) else {
        return Err(fault(format!(
            "is not there, there are {}: save the file again",
            root.buffer_views.len()
        )));
    };
    let bytes = buffers.bytes(view.buffer.value()).map_err(|stop| {
        // The buffer of a compressed view may be one that is there only for programs that cannot undo it, and often is not.
        let extensions = view.extensions.iter().flat_map(|all| all.others.keys());
        match (compression(extensions), stop) {
            (_, Stop::Cancelled) => Stop::Cancelled,
            (Some(name), _) => compressed(name),
            (None, stop) => stop,
        }
    })?;
    let from = usize::try_from(view.byte_offset.unwrap_or_default().0).ok();
    let length = usize::try_from(view.byte_length.0).ok();
    let range = from
        .zip(length)
        .and_then(|(from, length)| bytes.get(from..from.checked_add(length)?));
    let range = range.ok_or_else(|| {
        fault(format!(
            "announces {} bytes from byte {} of buffer {} on, which has {}: the file is damaged, save it again",
            view.byte_length.0,
            view.byte_offset.unwrap_or_default().0,
            view.buffer.value(),
            bytes.len()
        ))
    })?;
    let stride = view.byte_stride.map(|stride| stride.0);
    Ok((range, stride.filter(|&stride| stride > 0)))
}
