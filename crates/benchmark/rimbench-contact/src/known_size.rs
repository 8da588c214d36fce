//! Sizes that the compiler knows.

/// Matches a size. The first arm has it as a constant, where the compiler is to know it and the condition holds.
///
/// Loops over a known size are straight-line code on registers, for half the instructions. The list of these sizes is
/// here: up to eight rows, and three, four and six contacts in space. The arm calls a function that is not inlined: in
/// one large frame for all sizes the saving is lost.
#[doc(hidden)]
#[macro_export]
macro_rules! known_size {
    ($size:expr, $n:ident if $given:expr => $few:expr, $($other:pat => $many:expr),+ $(,)?) => {
        $crate::known_size!(@ 1 2 3 4 5 6 7 8 9 12 18; $size, $n if $given => $few, { $($other => $many,)+ })
    };
    (@ $($known:literal)+; $size:expr, $n:ident if $given:expr => $few:expr, $others:tt) => {
        $crate::known_size!(@@ $size, $([$known, $n if $given => $few])+ $others)
    };
    (@@ $size:expr, $([$known:literal, $n:ident if $given:expr => $few:expr])+ { $($other:pat => $many:expr,)+ }) => {
        match $size {
            $($known if const { const $n: usize = $known; $given } => { const $n: usize = $known; $few })+
            $($other => $many,)+
        }
    };
}
