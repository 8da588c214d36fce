//! What an FMU in our process may change of it, and that is set back after each call: working folder, standard output,
//! locale, and how the processor rounds and traps. Folder and locale are those of all threads, which may see them until
//! the call is over.

use super::super::archive::remove_unpacked;
use super::system;
use std::cell::Cell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::fs::File;
use std::io::{Result, Write};
use std::os::fd::{AsRawFd, FromRawFd, OwnedFd};
use std::path::Path;
use std::ptr;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, Once, PoisonError};

/// All categories of a locale.
const LC_ALL: c_int = if cfg!(target_vendor = "apple") { 0 } else { 6 };

unsafe extern "C" {
    fn fchdir(folder: c_int) -> c_int;
    fn dup(of: c_int) -> c_int;
    fn fflush(stream: *mut c_void) -> c_int;
    fn setlocale(category: c_int, locale: *const c_char) -> *const c_char;
    fn atexit(call: extern "C" fn()) -> c_int;
    fn getpid() -> c_int;
    #[cfg(target_os = "linux")]
    fn gettid() -> c_int;
    #[cfg(target_os = "linux")]
    fn at_quick_exit(call: extern "C" fn()) -> c_int;
}

/// What is printed to the standard output while FMUs are here goes to the standard error; how many are here, and ours,
/// put aside.
static OUTPUT: Mutex<(usize, Option<OwnedFd>)> = Mutex::new((0, None));

/// Our own standard output, where an FMU in this process has the usual one.
pub(super) fn standard_output() -> Option<File> {
    let output = OUTPUT.lock().unwrap_or_else(PoisonError::into_inner);
    output.1.as_ref().and_then(|ours| ours.try_clone().ok()).map(File::from)
}

thread_local! {
    /// The FMU whose code is at work in this thread: its file, and which side it is. What has no destructor is there to
    /// the last.
    static AT_WORK: Cell<Option<(*const Path, *const str)>> = const { Cell::new(None) };
}

/// Says which FMU is at work in this thread, until this is dropped.
pub(super) struct AtWork(Option<(*const Path, *const str)>);

/// How many are here, how many of them are at work in all threads, and whether the program ends, of its own accord or
/// by one of them.
static HERE: AtomicUsize = AtomicUsize::new(0);
static WORKING: AtomicUsize = AtomicUsize::new(0);
static LEAVING: AtomicBool = AtomicBool::new(false);
static ENDING: AtomicBool = AtomicBool::new(false);

/// Threads that may call `exit` at once: each takes away one of the calls that are made at the end.
const MOST_AT_ONCE: usize = 1024;

/// Ends the program, whatever FMUs are at.
pub(super) fn leave(code: u8) -> ! {
    LEAVING.store(true, Ordering::Relaxed);
    remove_unpacked();
    std::process::exit(code.into())
}

/// Whether this is the thread with which the program began, which comes to an `exit` of its own.
fn is_first_thread() -> bool {
    // SAFETY: both take nothing and cannot fail.
    #[cfg(target_os = "linux")]
    return unsafe { gettid() == getpid() };
    #[cfg(not(target_os = "linux"))]
    true
}

impl AtWork {
    /// What it is given lives longer than it: a plan, which an instance has as long as it is called.
    pub(super) fn on(file: &Path, side: &str) -> AtWork {
        WORKING.fetch_add(1, Ordering::Relaxed);
        AtWork(AT_WORK.replace(Some((file, side))))
    }
}

impl Drop for AtWork {
    fn drop(&mut self) {
        AT_WORK.set(self.0);
        WORKING.fetch_sub(1, Ordering::Relaxed);
    }
}

/// What an FMU comes to that calls `exit`: with its code the program would seem to have done what it was asked for.
extern "C" fn at_exit() {
    // SAFETY: while an FMU is at work in this thread, what its `AtWork` was given is there.
    let at_work = AT_WORK.get().map(|(file, side)| unsafe { (&*file, &*side) });
    let is_ours = || {
        let any = if is_first_thread() { &WORKING } else { &HERE };
        any.load(Ordering::Relaxed) == 0
    };
    let who = match at_work {
        Some((file, side)) => format!("{}: the FMU of the {side}", file.display()),
        None if LEAVING.load(Ordering::Relaxed) || (is_ours() && !ENDING.load(Ordering::Relaxed)) => return,
        // In a thread that it has begun; or it is ending the program already.
        None => "an FMU".to_owned(),
    };
    // Another thread is about to say so and to end the program; with this one it would end at once.
    while ENDING.swap(true, Ordering::Relaxed) {
        std::thread::sleep(std::time::Duration::from_secs(1));
    }
    remove_unpacked();
    let line = format!(
        "error: {who} ended this program by itself (exit); what is stored is kept, and the same command goes on from there; valid: \
         process = \"own\", with which that is the end of one run\n"
    );
    let _ = std::io::stderr().write_all(line.as_bytes());
    super::leave_at_once()
}

/// How it was before an FMU came.
pub(super) struct House {
    folder: Option<File>,
    locale: CString,
    arithmetic: Arithmetic,
}

impl House {
    pub(super) fn enter() -> Result<House> {
        static GUARDED: Once = Once::new();
        // SAFETY: what is called at the end takes nothing and is there to the end.
        GUARDED.call_once(|| unsafe {
            for _ in 0..MOST_AT_ONCE {
                atexit(at_exit);
                #[cfg(target_os = "linux")]
                at_quick_exit(at_exit);
            }
        });
        HERE.fetch_add(1, Ordering::Relaxed);
        let mut output = OUTPUT.lock().unwrap_or_else(PoisonError::into_inner);
        if output.0 == 0 {
            let _ = std::io::stdout().flush();
            // SAFETY: it takes a number; what it gives is ours alone.
            let ours = unsafe { dup(1) };
            if ours >= 0 {
                // SAFETY: a descriptor that was made just now. 2 is the standard error.
                output.1 = Some(unsafe { OwnedFd::from_raw_fd(ours) });
                // SAFETY: it takes numbers.
                unsafe { system::dup2(2, 1) };
            }
        }
        output.0 += 1;
        Ok(House { folder: File::open(".").ok(), locale: locale(), arithmetic: Arithmetic::present() })
    }

    /// Sets back everything.
    pub(super) fn tidy(&self) {
        self.arithmetic.set();
        // SAFETY: it asks for a text that lives until the locale is changed, and is not kept.
        let changed = unsafe { name(setlocale(LC_ALL, ptr::null())) } != Some(self.locale.as_c_str());
        if changed {
            // SAFETY: the text ends in zero and outlives the call.
            unsafe { setlocale(LC_ALL, self.locale.as_ptr()) };
        }
        if let Some(folder) = &self.folder {
            // SAFETY: the descriptor is open.
            unsafe { fchdir(folder.as_raw_fd()) };
        }
    }
}

impl Drop for House {
    fn drop(&mut self) {
        self.tidy();
        HERE.fetch_sub(1, Ordering::Relaxed);
        let mut output = OUTPUT.lock().unwrap_or_else(PoisonError::into_inner);
        output.0 -= 1;
        if output.0 == 0
            && let Some(ours) = output.1.take()
        {
            // What C has not written yet was not meant for us.
            // SAFETY: null stands for all streams; both descriptors are open.
            unsafe {
                fflush(ptr::null_mut());
                system::dup2(ours.as_raw_fd(), 1);
            }
        }
    }
}

/// # Safety
/// The text ends in zero, or is null, and lives as long as what is made of it.
unsafe fn name<'a>(text: *const c_char) -> Option<&'a CStr> {
    // SAFETY: as the caller says.
    (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) })
}

fn locale() -> CString {
    // SAFETY: it asks for a text that lives until the locale is changed, and is copied at once.
    unsafe { name(setlocale(LC_ALL, ptr::null())) }.unwrap_or(c"C").to_owned()
}

/// Control words of the processor: rounding, traps, and whether the smallest numbers are taken for 0.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Arithmetic {
    #[cfg(target_arch = "x86_64")]
    vector: u32,
    #[cfg(target_arch = "x86_64")]
    stack: u16,
    #[cfg(target_arch = "aarch64")]
    control: u64,
}

impl Arithmetic {
    #[cfg(target_arch = "x86_64")]
    fn present() -> Self {
        let (mut vector, mut stack) = (0_u32, 0_u16);
        // SAFETY: both write a control word to a place that is large enough.
        unsafe {
            std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut vector, options(nostack, preserves_flags));
            std::arch::asm!("fnstcw [{}]", in(reg) &raw mut stack, options(nostack, preserves_flags));
        }
        // Without the flags of exceptions that have occurred.
        Arithmetic { vector: vector & !0x3f, stack }
    }

    #[cfg(target_arch = "x86_64")]
    fn set(self) {
        // SAFETY: control words that the processor had before. What has happened is forgotten first, so that nothing
        // traps.
        unsafe {
            std::arch::asm!("fnclex", "fldcw [{}]", in(reg) &raw const self.stack, options(nostack));
            std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const self.vector, options(nostack, preserves_flags));
        }
    }

    #[cfg(target_arch = "aarch64")]
    fn present() -> Self {
        let control: u64;
        // SAFETY: it reads a control word.
        unsafe { std::arch::asm!("mrs {}, fpcr", out(reg) control, options(nomem, nostack, preserves_flags)) };
        Arithmetic { control }
    }

    #[cfg(target_arch = "aarch64")]
    fn set(self) {
        // SAFETY: a control word that the processor had before.
        unsafe { std::arch::asm!("msr fpcr, {}", in(reg) self.control, options(nomem, nostack, preserves_flags)) };
    }

    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    fn present() -> Self {
        Arithmetic {}
    }

    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    fn set(self) {}
}
