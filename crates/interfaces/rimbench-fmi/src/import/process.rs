//! An FMU in a process of its own: when it crashes or hangs, that is the end of one run.
//!
//! The program starts itself as a worker. The worker's standard input is a socket, and everything that the FMU prints
//! goes elsewhere.
//!
//! ```text
//! first     length u64, plan as JSON              → status u8; 1: length u64, message
//! then      what u8, copy u32, n u64, n numbers   → status u8, n u64, n numbers; 1: length u64, message
//! ```
//! Integers and f64 in little-endian order. Five zeros take leave of the worker. An end of the socket without them
//! means that the program has been killed, and is the end of the worker as well.

use super::host::{Ask, Host, Plan};
use super::library::{self, Loaded};
use crate::last_words::LastWords;
use rimbench_core::error::{Error, Result};
use std::io::{BufReader, Read, Write};
use std::os::unix::net::UnixStream as Socket;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The hidden command by which the program is a worker.
pub const WORKER: &str = "fmu-worker";
/// What takes leave of a worker.
const LEAVE_TAKING: [u8; 5] = [0; 5];
/// How long a worker may take to end.
const LEAVE: Duration = Duration::from_secs(2);
/// How long a worker whose socket has ended may take to be gone itself.
const END: Duration = Duration::from_millis(100);
/// How often a worker looks whether the program that started it is still there.
const LOOK: Duration = Duration::from_millis(200);
/// Longest message that is believed, bytes.
const LONGEST: u64 = 1 << 32;

/// How long who waits for the other side looks whether it has answered before it sleeps. An answer takes a few µs mostly; to wake a
/// processor that has gone to sleep takes tens of them, twice for each.
const AWAKE: Duration = Duration::from_micros(50);

/// A socket whose reader stays awake for a while.
struct Awake(Socket);

impl Awake {
    /// Reads what is there by then; none: nothing is.
    fn look(&mut self, bytes: &mut [u8]) -> Option<std::io::Result<usize>> {
        let began = Instant::now();
        loop {
            match self.0.read(bytes) {
                Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => {}
                read => return Some(read),
            }
            if began.elapsed() > AWAKE {
                return None;
            }
            // Where all processors are taken the other side may need this one.
            std::thread::yield_now();
        }
    }
}

impl Read for Awake {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        self.0.set_nonblocking(true)?;
        let read = self.look(bytes);
        self.0.set_nonblocking(false)?;
        read.unwrap_or_else(|| self.0.read(bytes))
    }
}

/// The other end of the socket.
pub(super) struct Remote {
    socket: BufReader<Awake>,
    child: Child,
    file: String,
    printed: LastWords,
    bytes: Vec<u8>,
    answer_within: Duration,
}

fn put_numbers(bytes: &mut Vec<u8>, numbers: &[f64]) {
    bytes.extend((numbers.len() as u64).to_le_bytes());
    numbers.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
}

fn read_u64(from: &mut impl Read) -> std::io::Result<u64> {
    let mut bytes = [0; 8];
    from.read_exact(&mut bytes)?;
    let number = u64::from_le_bytes(bytes);
    if number > LONGEST { Err(std::io::Error::other("a message without end")) } else { Ok(number) }
}

fn read_bytes(from: &mut impl Read, room: &mut Vec<u8>, count: u64) -> std::io::Result<()> {
    room.clear();
    room.resize(count as usize, 0);
    from.read_exact(room)
}

fn read_numbers(from: &mut impl Read, room: &mut Vec<u8>, numbers: &mut Vec<f64>) -> std::io::Result<()> {
    let count = read_u64(from)?;
    read_bytes(from, room, 8 * count)?;
    numbers.clear();
    numbers.extend(room.chunks_exact(8).map(|chunk| f64::from_le_bytes(chunk.try_into().unwrap_or_default())));
    Ok(())
}

impl Remote {
    /// Starts a worker for an FMU.
    pub(super) fn start(plan: &Plan, worker: &[PathBuf], answer_within: Duration) -> Result<Self, String> {
        let text = serde_json::to_vec(plan).map_err(|error| error.to_string())?;
        Self::started(&text, &plan.file.display().to_string(), worker, answer_within, plan.log)
    }

    /// Starts a worker by its command, and hands it its plan; what it logs is shown as it comes.
    pub(super) fn started(
        plan: &[u8],
        file: &str,
        worker: &[PathBuf],
        answer_within: Duration,
        log: bool,
    ) -> Result<Self, String> {
        let file = file.to_owned();
        let wrong = |error: std::io::Error| format!("{file}: its process cannot be started: {error}");
        let (own, theirs) = Socket::pair().map_err(wrong)?;
        let (output, said) = std::io::pipe().map_err(wrong)?;
        let [program, arguments @ ..] = worker else {
            return Err(format!("{file}: there is no command for its process"));
        };
        // A log that is wanted is shown as it comes.
        let errors = if log { Stdio::inherit() } else { Stdio::from(said.try_clone().map_err(wrong)?) };
        let child = Command::new(program)
            .args(arguments)
            .stdin(Stdio::from(std::os::fd::OwnedFd::from(theirs)))
            .stdout(said)
            .stderr(errors)
            // Ctrl-C in a terminal is for this program, which ends its runs as it should; the worker follows it.
            .process_group(0)
            .spawn()
            .map_err(wrong)?;
        own.set_read_timeout(Some(answer_within)).map_err(wrong)?;
        let printed = LastWords::of(output);
        let mut remote =
            Remote { socket: BufReader::new(Awake(own)), child, file, printed, bytes: Vec::new(), answer_within };
        let mut message = (plan.len() as u64).to_le_bytes().to_vec();
        message.extend(plan);
        let sent = remote.socket.get_mut().0.write_all(&message);
        match sent.and_then(|()| remote.status()) {
            Ok(answer) => answer.map(|()| remote),
            Err(error) => Err(remote.last_words(&error)),
        }
    }

    /// Changes after how long without an answer it is ended.
    pub(super) fn answers_within(mut self, answer_within: Duration) -> Result<Self, String> {
        self.answer_within = answer_within;
        let set = self.socket.get_ref().0.set_read_timeout(Some(answer_within));
        set.map(|()| self).map_err(|error| format!("its socket has no limit of time: {error}"))
    }

    /// The status of an answer, with the message of a refusal.
    fn status(&mut self) -> std::io::Result<Result<(), String>> {
        let mut status = [0];
        self.socket.read_exact(&mut status)?;
        if status == [0] {
            return Ok(Ok(()));
        }
        let length = read_u64(&mut self.socket)?;
        read_bytes(&mut self.socket, &mut self.bytes, length)?;
        Ok(Err(String::from_utf8_lossy(&self.bytes).into_owned()))
    }

    /// Why there is no answer.
    fn last_words(&mut self, error: &std::io::Error) -> String {
        let hangs = matches!(error.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut);
        // One that has ended by itself says how; one that has not is ended, whatever it has done to the socket.
        let began = Instant::now();
        while !hangs && began.elapsed() < END && matches!(self.child.try_wait(), Ok(None)) {
            std::thread::sleep(Duration::from_millis(1));
        }
        let alone = !matches!(self.child.try_wait(), Ok(None));
        let _ = self.child.kill();
        let ended = self.child.wait().map_or_else(|error| error.to_string(), |status| status.to_string());
        // What it printed may name folders of this machine: that is for the person here, and no part of what is
        // recorded.
        self.printed.show(&self.file);
        if hangs {
            format!("{}: no answer within {} s", self.file, self.answer_within.as_secs_f64())
        } else if alone {
            format!("{}: its process ended ({ended})", self.file)
        } else {
            format!("{}: its process no longer answers ({error}) and was ended", self.file)
        }
    }
}

impl Host for Remote {
    fn ask(&mut self, ask: Ask, id: u32, input: &[f64], output: &mut Vec<f64>) -> Result<(), String> {
        self.bytes.clear();
        self.bytes.push(ask as u8);
        self.bytes.extend(id.to_le_bytes());
        put_numbers(&mut self.bytes, input);
        let answered =
            self.socket.get_mut().0.write_all(&self.bytes).and_then(|()| self.status()).and_then(
                |status| match status {
                    Ok(()) => read_numbers(&mut self.socket, &mut self.bytes, output).map(Ok),
                    refused => Ok(refused),
                },
            );
        answered.unwrap_or_else(|error| Err(self.last_words(&error)))
    }
}

impl Drop for Remote {
    fn drop(&mut self) {
        let _ = self.socket.get_mut().0.write_all(&LEAVE_TAKING);
        let _ = self.socket.get_ref().0.shutdown(std::net::Shutdown::Both);
        let began = Instant::now();
        while began.elapsed() < LEAVE {
            if !matches!(self.child.try_wait(), Ok(None)) {
                return;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Is the worker: drives the FMU that the standard input, a socket, asks for until that ends.
///
/// # Errors
/// A standard input that is none.
pub fn serve() -> Result<()> {
    use std::os::fd::AsFd;
    let wrong = |error: std::io::Error| {
        let words = format!("`{WORKER}` is for the program itself: its standard input is a socket ({error})");
        Error::Incompatible(words)
    };
    let started_by = std::os::unix::process::parent_id();
    let socket = Socket::from(std::io::stdin().as_fd().try_clone_to_owned().map_err(wrong)?);
    let mut socket = BufReader::new(Awake(socket));
    // The copy is closed in what an FMU starts; the standard input itself would not be.
    library::leave_standard_input().map_err(wrong)?;
    let mut bytes = Vec::new();
    let length = read_u64(&mut socket).map_err(wrong)?;
    read_bytes(&mut socket, &mut bytes, length).map_err(wrong)?;
    let plan: Result<Plan, _> = serde_json::from_slice(&bytes).map_err(|error| error.to_string());
    let folder = plan.as_ref().ok().and_then(|plan| plan.resources.parent()).map(Path::to_owned);
    let of_thread = folder.clone();
    std::thread::spawn(move || outlive_nobody(started_by, of_thread.as_deref()));
    let loaded = plan.and_then(Loaded::new);
    let mut loaded = match loaded {
        Ok(loaded) => loaded,
        Err(message) => {
            let _ = socket.get_mut().0.write_all(&refusal(&message));
            return Ok(());
        }
    };
    if socket.get_mut().0.write_all(&[0]).is_err() {
        return Ok(());
    }
    let (mut input, mut output, mut answer) = (Vec::new(), Vec::new(), Vec::new());
    loop {
        let mut head = [0; 5];
        let heard = socket.read_exact(&mut head);
        if heard.is_ok() && head == LEAVE_TAKING {
            return Ok(());
        }
        // The asking process ended without closing the socket.
        if heard.and_then(|()| read_numbers(&mut socket, &mut bytes, &mut input)).is_err() {
            outlive_nobody(started_by, folder.as_deref());
        }
        let [what, id @ ..] = head;
        let asked = Ask::of(what).ok_or_else(|| "asked for what there is not".to_owned());
        match asked.and_then(|ask| loaded.ask(ask, u32::from_le_bytes(id), &input, &mut output)) {
            Ok(()) => {
                answer.clear();
                answer.push(0);
                put_numbers(&mut answer, &output);
            }
            Err(message) => answer = refusal(&message),
        }
        if socket.get_mut().0.write_all(&answer).is_err() {
            outlive_nobody(started_by, folder.as_deref());
        }
    }
}

/// Ends this process when the program that started it has gone, wherever the FMU is by then, and removes the folder
/// that the FMU was unpacked to, which nobody else would do.
fn outlive_nobody(started_by: u32, folder: Option<&Path>) -> ! {
    while std::os::unix::process::parent_id() == started_by {
        std::thread::sleep(LOOK);
    }
    if let Some(folder) = folder {
        let _ = std::fs::remove_dir_all(folder);
    }
    library::leave_at_once()
}

fn refusal(message: &str) -> Vec<u8> {
    let mut bytes = vec![1];
    bytes.extend((message.len() as u64).to_le_bytes());
    bytes.extend(message.as_bytes());
    bytes
}
