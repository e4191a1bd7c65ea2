//! The functions of Open Image Denoise 2, called through pointers that are looked up at run time.
//!
//! All unsafe code of this crate is here. The signatures are those of `oidn.h` of version 2, whose binary interface is stable
//! within the major version.
#![allow(unsafe_code)]

use std::error::Error;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use glanz_job::CancelFlag;

use crate::DenoiseError;

/// A device or a filter of the library.
type Handle = *mut c_void;

/// `OIDN_DEVICE_TYPE_CPU`: the device that reads the memory of this process wherever it lies.
const CPU: c_int = 1;

/// `OIDN_FORMAT_FLOAT3`.
const FLOAT3: c_int = 3;

type ProgressFunction = unsafe extern "C" fn(*mut c_void, f64) -> bool;

macro_rules! functions {
    ($($field:ident: $name:literal, fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// Pointers to the functions.
        #[derive(Clone, Copy, Debug)]
        struct Functions {
            $($field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Functions {
            /// The functions of a library, or the name of the first that it lacks.
            fn of(library: &libloading::Library) -> Result<Self, &'static str> {
                // SAFETY: the types are those of the functions of these names in `oidn.h` of version 2. The pointers are used only
                // while `Library` keeps the library loaded.
                unsafe {
                    Ok(Self { $($field: *library.get($name).map_err(|_| $name)?,)* })
                }
            }
        }
    };
}

functions! {
    new_device: "oidnNewDevice", fn(c_int) -> Handle;
    commit_device: "oidnCommitDevice", fn(Handle);
    release_device: "oidnReleaseDevice", fn(Handle);
    set_device_int: "oidnSetDeviceInt", fn(Handle, *const c_char, c_int);
    device_error: "oidnGetDeviceError", fn(Handle, *mut *const c_char) -> c_int;
    new_filter: "oidnNewFilter", fn(Handle, *const c_char) -> Handle;
    release_filter: "oidnReleaseFilter", fn(Handle);
    set_image: "oidnSetSharedFilterImage", fn(Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize);
    set_bool: "oidnSetFilterBool", fn(Handle, *const c_char, bool);
    set_progress: "oidnSetFilterProgressMonitorFunction", fn(Handle, ProgressFunction, *mut c_void);
    commit_filter: "oidnCommitFilter", fn(Handle);
    execute_filter: "oidnExecuteFilter", fn(Handle);
}

/// The loaded library.
#[derive(Debug)]
pub(crate) struct Library {
    functions: Functions,
    /// Keeps the functions in memory.
    _library: libloading::Library,
}

/// Loads a library.
///
/// # Safety
/// The initialisers of the library have no preconditions.
#[cfg(not(windows))]
unsafe fn load(path: &Path) -> Result<libloading::Library, libloading::Error> {
    // SAFETY: the contract of this function.
    unsafe { libloading::Library::new(path) }
}

/// Loads a library, whose own libraries lie beside it. The current folder is not searched: it may be that of a stranger's scene.
///
/// # Safety
/// The initialisers of the library have no preconditions.
#[cfg(windows)]
unsafe fn load(path: &Path) -> Result<libloading::Library, libloading::Error> {
    use libloading::os::windows::{
        LOAD_LIBRARY_SEARCH_DEFAULT_DIRS, LOAD_LIBRARY_SEARCH_DLL_LOAD_DIR, Library,
    };
    let is_in_folder = path.components().count() > 1;
    let beside = if is_in_folder { LOAD_LIBRARY_SEARCH_DLL_LOAD_DIR } else { 0 };
    let path = match is_in_folder {
        true => std::path::absolute(path).unwrap_or_else(|_| path.to_owned()),
        false => path.to_owned(),
    };
    // SAFETY: the contract of this function.
    unsafe { Library::load_with_flags(path, beside | LOAD_LIBRARY_SEARCH_DEFAULT_DIRS) }.map(Into::into)
}

impl Library {
    /// Loads the library `path`. The inner error is the reason why it could not be loaded.
    ///
    /// # Errors
    /// [`DenoiseError::Version`] if it lacks a function.
    pub(crate) fn open(path: &Path) -> Result<Result<Self, String>, DenoiseError> {
        // SAFETY: loading runs the initialisers of the library, which the user chose by its folder or installed; those of Open Image Denoise
        // have no preconditions.
        let library = match unsafe { load(path) } {
            Ok(library) => library,
            Err(error) => {
                let (reason, name) =
                    (error.source().unwrap_or(&error).to_string(), path.display().to_string());
                // Not all systems name the file.
                return Ok(Err(if reason.contains(&name) { reason } else { format!("{name}: {reason}") }));
            }
        };
        match Functions::of(&library) {
            Ok(functions) => Ok(Ok(Self { functions, _library: library })),
            Err(function) => {
                Err(DenoiseError::Version { path: path.to_owned(), function: function.to_owned() })
            }
        }
    }

    /// A device that computes on the processor, with this number of threads; 0 for all.
    ///
    /// # Errors
    /// [`DenoiseError::Library`].
    pub(crate) fn device(&self, threads: usize) -> Result<Device<'_>, DenoiseError> {
        let functions = &self.functions;
        // SAFETY: `new_device` has no preconditions; it returns null on failure, which `error` accepts.
        let device = Device { functions, handle: unsafe { (functions.new_device)(CPU) } };
        if device.handle.is_null() {
            return Err(device
                .error()
                .err()
                .unwrap_or_else(|| DenoiseError::Library("no device".to_owned())));
        }
        // SAFETY: the handle is that of a device that is not released yet; the name ends with a zero.
        unsafe {
            if let Some(count) = c_int::try_from(threads).ok().filter(|count| *count > 0) {
                (functions.set_device_int)(device.handle, c"numThreads".as_ptr(), count);
            }
            (functions.commit_device)(device.handle);
        }
        device.error().map(|()| device)
    }
}

/// An input or the output of a filter.
pub(crate) struct FilterImage<'a> {
    /// Its name in the library.
    pub(crate) name: &'static str,
    pub(crate) pixels: &'a mut [[f32; 3]],
}

/// A device of the library.
pub(crate) struct Device<'a> {
    functions: &'a Functions,
    handle: Handle,
}

impl Device<'_> {
    /// Runs a filter for ray-traced pictures on images of `size`. `flags`: settings that are on.
    ///
    /// # Errors
    /// [`DenoiseError::Size`] for an image of another size, [`DenoiseError::Library`], also if it was cancelled.
    pub(crate) fn filter(
        &self,
        size: [u32; 2],
        images: &mut [FilterImage<'_>],
        flags: &[&'static str],
        monitor: &FilterMonitor<'_>,
    ) -> Result<(), DenoiseError> {
        let [width, height] = size.map(|x| x as usize);
        if let Some(image) = images.iter().find(|image| image.pixels.len() != width * height) {
            let (layer, found) = (image.name, image.pixels.len());
            return Err(DenoiseError::Size { layer, found, expected: width * height });
        }
        let functions = self.functions;
        let name = |text: &str| CString::new(text).unwrap_or_default();
        // SAFETY: the handle of the device is live, and that of the filter until `release_filter` below. Strings end with a zero and outlive
        // their call. Each image has width * height pixels of three floats without gaps, as was checked above, and is borrowed mutably until
        // the filter has run and is released. `on_progress` gets the pointer to `monitor`, which it only reads and which may be shared between
        // threads, while this function runs.
        unsafe {
            let filter = (functions.new_filter)(self.handle, name("RT").as_ptr());
            if filter.is_null() {
                let unknown = || DenoiseError::Library("no filter".to_owned());
                return Err(self.error().err().unwrap_or_else(unknown));
            }
            for image in images {
                let pixels = image.pixels.as_mut_ptr().cast();
                (functions.set_image)(
                    filter,
                    name(image.name).as_ptr(),
                    pixels,
                    FLOAT3,
                    width,
                    height,
                    0,
                    0,
                    0,
                );
            }
            for flag in flags {
                (functions.set_bool)(filter, name(flag).as_ptr(), true);
            }
            (functions.set_progress)(filter, on_progress, (&raw const *monitor).cast_mut().cast());
            (functions.commit_filter)(filter);
            (functions.execute_filter)(filter);
            (functions.release_filter)(filter);
        }
        self.error()
    }

    /// The first error since the last call.
    fn error(&self) -> Result<(), DenoiseError> {
        let mut message: *const c_char = std::ptr::null();
        // SAFETY: the handle is null or live; the message, if there is one, ends with a zero and lives until the next call, before which it
        // is copied.
        unsafe {
            if (self.functions.device_error)(self.handle, &raw mut message) == 0 {
                return Ok(());
            }
            let text = if message.is_null() {
                "unknown error".into()
            } else {
                CStr::from_ptr(message).to_string_lossy()
            };
            Err(DenoiseError::Library(text.into_owned()))
        }
    }
}

impl Drop for Device<'_> {
    fn drop(&mut self) {
        if !self.handle.is_null() {
            // SAFETY: the handle is live and not used again.
            unsafe { (self.functions.release_device)(self.handle) };
        }
    }
}

/// Progress of a filter and its end, shared with the threads of the library.
pub(crate) struct FilterMonitor<'a> {
    pub(crate) cancel: &'a CancelFlag,
    /// Share of the work that is done, as the bits of an `f64`.
    pub(crate) done: AtomicU64,
}

/// Records progress; returns whether to continue.
///
/// # Safety
/// `user` points to a live [`FilterMonitor`].
unsafe extern "C" fn on_progress(user: *mut c_void, done: f64) -> bool {
    // SAFETY: the contract of this function.
    let monitor = unsafe { &*user.cast::<FilterMonitor<'_>>() };
    monitor.done.store(done.to_bits(), Ordering::Relaxed);
    !monitor.cancel.is_cancelled()
}
