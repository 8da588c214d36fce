//! The log of FMI 2.0, which has printf's arguments behind its text.
//!
//! Rust cannot define a function of C with an open number of arguments. Where we know how they are handed over, a few
//! instructions collect them as a C compiler would (`va_list` of the System V ABI for x86-64, section 3.5.7), and the C
//! library writes the text. Elsewhere the text stays as it is, with its placeholders. Functions with an open number of
//! arguments (`c_variadic`, issue 44930 of rust-lang/rust) will replace this once they are stable.

use super::note;
use std::ffi::{c_char, c_int, c_void};

#[cfg(all(target_arch = "x86_64", unix))]
pub(super) use collected::log;
#[cfg(not(all(target_arch = "x86_64", unix)))]
pub(super) use plain::log;

#[cfg(all(target_arch = "x86_64", unix))]
mod collected {
    use super::{asks_for_arguments, c_char, c_int, c_void, note};
    use std::ffi::CStr;

    /// How much of a text is written, bytes.
    const LONGEST: usize = 4096;

    unsafe extern "C" {
        fn vsnprintf(room: *mut c_char, size: usize, format: *const c_char, arguments: *mut c_void) -> c_int;
    }

    /// What the library calls.
    ///
    /// ```text
    /// rsp + 0    the six registers of whole numbers, five of which hold the arguments before the open ones
    ///     + 48   eight registers of numbers with a point, where rax says that there are any
    ///     + 176  va_list: places of the next of each in the above (40, 48), where further arguments and the above are
    /// ```
    #[unsafe(naked)]
    pub(in super::super) unsafe extern "C" fn log(
        _environment: *mut c_void,
        _name: *const c_char,
        _status: c_int,
        _category: *const c_char,
        _message: *const c_char,
    ) {
        std::arch::naked_asm!(
            "push rbp",
            "mov rbp, rsp",
            "sub rsp, 208",
            "mov [rsp], rdi",
            "mov [rsp + 8], rsi",
            "mov [rsp + 16], rdx",
            "mov [rsp + 24], rcx",
            "mov [rsp + 32], r8",
            "mov [rsp + 40], r9",
            "test al, al",
            "je 2f",
            "movaps [rsp + 48], xmm0",
            "movaps [rsp + 64], xmm1",
            "movaps [rsp + 80], xmm2",
            "movaps [rsp + 96], xmm3",
            "movaps [rsp + 112], xmm4",
            "movaps [rsp + 128], xmm5",
            "movaps [rsp + 144], xmm6",
            "movaps [rsp + 160], xmm7",
            "2:",
            "mov dword ptr [rsp + 176], 40",
            "mov dword ptr [rsp + 180], 48",
            "lea rax, [rbp + 16]",
            "mov [rsp + 184], rax",
            "mov [rsp + 192], rsp",
            "lea r9, [rsp + 176]",
            "call {written}",
            "leave",
            "ret",
            written = sym written,
        )
    }

    /// # Safety
    /// `environment` is what the library was given, `message` a text that ends in zero or null, and `arguments` those
    /// that it asks for.
    unsafe extern "C" fn written(
        environment: *mut c_void,
        _name: *const c_char,
        status: c_int,
        _category: *const c_char,
        message: *const c_char,
        arguments: *mut c_void,
    ) {
        // SAFETY: as the caller says.
        let text = if message.is_null() { c"" } else { unsafe { CStr::from_ptr(message) } };
        if !asks_for_arguments(text.to_bytes()) {
            // SAFETY: as the caller says.
            unsafe { note(environment, status, message) };
            return;
        }
        let mut room: [c_char; LONGEST] = [0; LONGEST];
        // SAFETY: there is room for as many bytes as it is told, and it ends what it writes in zero.
        let done = unsafe {
            let count = vsnprintf(room.as_mut_ptr(), room.len(), message, arguments);
            if count < 0 { message } else { room.as_ptr() }
        };
        // SAFETY: both end in zero.
        unsafe { note(environment, status, done) };
    }
}

/// Whether a text has placeholders, none of which writes to where its argument points.
#[cfg(all(target_arch = "x86_64", unix))]
fn asks_for_arguments(text: &[u8]) -> bool {
    let mut parts = text.split(|byte| *byte == b'%').skip(1).peekable();
    let kind = |part: &[u8]| part.iter().copied().find(|byte| !b"0123456789.-+ #*'$hlLqjzt".contains(byte));
    parts.peek().is_some() && parts.all(|part| kind(part) != Some(b'n'))
}

#[cfg(not(all(target_arch = "x86_64", unix)))]
mod plain {
    use super::{c_char, c_int, c_void, note};

    pub(in super::super) unsafe extern "C" fn log(
        environment: *mut c_void,
        _name: *const c_char,
        status: c_int,
        _category: *const c_char,
        message: *const c_char,
    ) {
        // SAFETY: the library hands on the environment that it was given, which is a `Said`, and a text, as the
        // standard has it.
        unsafe { note(environment, status, message) };
    }
}
