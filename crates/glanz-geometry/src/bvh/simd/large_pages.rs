//! Advice to the system about memory pages.

/// Advises the system to back the capacity of `list` by large pages, so that random access misses fewer address
/// translations. To be called before the list is filled; a system without support ignores it.
pub(crate) fn prefer_large_pages<T>(list: &mut Vec<T>) {
    #[cfg(target_os = "linux")]
    {
        use std::ffi::{c_int, c_void};
        unsafe extern "C" {
            fn madvise(address: *mut c_void, length: usize, advice: c_int) -> c_int;
        }
        const MADV_HUGEPAGE: c_int = 14;
        const LARGE: usize = 1 << 21;
        let room = list.spare_capacity_mut();
        let bytes = size_of_val(room);
        let start = room.as_mut_ptr().cast::<u8>();
        let skip = start.align_offset(LARGE);
        let length = bytes.saturating_sub(skip) / LARGE * LARGE;
        if length > 0 {
            // SAFETY: whole large pages inside an allocation that `list` owns, by their alignment whole pages of any
            // smaller size too. The advice changes neither contents nor access, only which pages back them.
            unsafe { madvise(start.add(skip).cast(), length, MADV_HUGEPAGE) };
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = list;
}
