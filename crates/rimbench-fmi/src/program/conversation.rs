//! A process and the lines that go to it and come from it: one request, one reply, each within its time.
//!
//! A process that crashes, hangs, or says what it must not is ended, with all that it has started, and whoever asks it from then on is
//! told why.

use super::command_line::CommandLine;
use super::exchange_times::{ExchangeTimes, add_exchange_times};
use super::living::{Living, wait_if_over};
use super::messages::{Numbered, PROTOCOL, Reply, Request, Role, VERSION};
use crate::last_words::{LastWords, tell_once};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process_group, waitid};
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::io::{ErrorKind, Read, Write};
use std::os::fd::AsFd;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

/// How long a process may take for its first answers, if not longer: an interpreter has much to read.
const START: Duration = Duration::from_secs(60);
/// How long a process may take to end when it is told that there is nothing more to ask.
const LEAVE: Duration = Duration::from_secs(2);
/// How long a process whose output has ended may take to be gone itself.
const END: Duration = Duration::from_millis(200);
/// How much of a reply that is wrong is repeated, characters.
const REPEATED: usize = 120;
/// Longest line that is believed, bytes.
const LONGEST: usize = 1 << 28;
/// What is wrong with a reply that is JSON of another kind.
const NO_OBJECT: &str = "it is no object of JSON";
/// Bytes read at once.
const CHUNK: usize = 1 << 13;

/// A process, and what has been heard of it that is not used yet.
pub(super) struct Conversation {
    who: String,
    /// The file that names it.
    file: PathBuf,
    child: Child,
    /// None when it has ended.
    living: Option<Living>,
    /// None when there is nothing more to ask.
    stdin: Option<ChildStdin>,
    stdout: ChildStdout,
    said: LastWords,
    heard: Vec<u8>,
    line: Vec<u8>,
    /// How often it was asked, and so the number of the last request.
    asked: u64,
    answer_within: Duration,
    times: ExchangeTimes,
    /// Why it is over, if it is.
    over: Option<String>,
}

/// Why there is no reply.
enum Silence {
    Late,
    Ended,
    /// There is one, and what is wrong with it.
    Wrong(String),
    /// There is one, which says why there is no other.
    Refused(String),
}

impl From<String> for Silence {
    fn from(wrong: String) -> Self {
        Silence::Wrong(wrong)
    }
}

impl From<std::io::Error> for Silence {
    fn from(error: std::io::Error) -> Self {
        if error.kind() == ErrorKind::TimedOut { Silence::Late } else { Silence::Ended }
    }
}

impl Conversation {
    /// Starts a process, in a group of its own: what ends this program from the terminal does not end it, and it does not outlive us by
    /// what it has started.
    pub(super) fn start(command: &CommandLine) -> Result<Self, String> {
        let who = command.to_string();
        let wrong = |error: std::io::Error| format!("`{who}` cannot be started: {error}");
        let mut child = Command::new(command.program())
            .args(&command.words[1..])
            .current_dir(&command.folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .process_group(0)
            .spawn()
            .map_err(wrong)?;
        let (Some(stdin), Some(stdout), Some(stderr)) = (child.stdin.take(), child.stdout.take(), child.stderr.take())
        else {
            unreachable!("all three are piped")
        };
        let conversation = Conversation {
            who: who.clone(),
            file: command.file.clone(),
            living: Some(Living::of(&child)),
            child,
            stdin: Some(stdin),
            stdout,
            said: LastWords::of(stderr),
            heard: Vec::new(),
            line: Vec::new(),
            asked: 0,
            answer_within: command.answer_within,
            times: ExchangeTimes::default(),
            over: None,
        };
        // Neither side of the pipes may keep us waiting for longer than is allowed.
        let not_waiting =
            |fd: std::os::fd::BorrowedFd<'_>| rustix::io::ioctl_fionbio(fd, true).map_err(|e| wrong(e.into()));
        not_waiting(conversation.stdout.as_fd())?;
        conversation.stdin.as_ref().map_or(Ok(()), |stdin| not_waiting(stdin.as_fd()))?;
        Ok(conversation)
    }

    /// Asks what the program is, and checks that it speaks this protocol.
    pub(super) fn hello<D: DeserializeOwned>(&mut self, role: Role, request: &Request<'_>) -> Result<D, String> {
        self.exchange(request, |line, id| {
            let mut reply: Value = parsed(line)?;
            let Some(fields) = reply.as_object_mut() else { return Err(NO_OBJECT.to_owned().into()) };
            if let Some(error) = fields.get("error").and_then(Value::as_str) {
                return Err(Silence::Refused(error.to_owned()));
            }
            let role = serde_json::json!(role);
            let own = [("protocol", PROTOCOL.into()), ("version", VERSION.into()), ("role", role), ("id", id.into())];
            for (key, valid) in own {
                match fields.remove(key) {
                    Some(found) if found == valid => {}
                    Some(found) => return Err(format!("`{key}` is {found}; valid: {valid}").into()),
                    None => return Err(format!("`{key}` is missing; valid: {valid}").into()),
                }
            }
            serde_json::from_value(reply).map_err(|error| error.to_string().into())
        })
    }

    /// Asks, and takes from the reply what `take` finds in it; what that misses makes the reply a wrong one.
    ///
    /// # Errors
    /// In words, how the process ended, that it does not answer, what is wrong with its reply, or what it says is wrong.
    pub(super) fn ask<T>(
        &mut self,
        request: &Request<'_>,
        take: impl FnOnce(Reply) -> Result<T, String>,
    ) -> Result<T, String> {
        self.exchange(request, |line, id| {
            // A list would be taken for the fields one after the other.
            if line.trim_ascii_start().starts_with(b"[") {
                return Err(NO_OBJECT.to_owned().into());
            }
            let mut reply: Reply = parsed(line)?;
            match (reply.error.take(), reply.id) {
                (Some(error), _) => Err(Silence::Refused(error)),
                (None, Some(found)) if found == id => Ok(take(reply)?),
                // What was said to an earlier request would be a step old, and everything behind it as well.
                (None, Some(found)) => Err(format!("`id` is {found}; valid: {id}, that of the request").into()),
                (None, None) => Err(format!("`id` is missing; valid: {id}, that of the request").into()),
            }
        })
    }

    fn exchange<T>(
        &mut self,
        request: &Request<'_>,
        take: impl FnOnce(&[u8], u64) -> Result<T, Silence>,
    ) -> Result<T, String> {
        if let Some(why) = &self.over {
            return Err(why.clone());
        }
        self.asked += 1;
        let id = self.asked;
        let began = Instant::now();
        let within = if request.is_of_the_start() { self.answer_within.max(START) } else { self.answer_within };
        let answered = self.send_and_hear(&Numbered { id, request }, began + within);
        if request.is_of_a_step() && answered.is_ok() {
            self.times.note(began.elapsed());
        }
        let taken = answered.and_then(|()| {
            let line = std::mem::take(&mut self.line);
            let taken = take(&line, id).map_err(|silence| match silence {
                Silence::Wrong(error) => Silence::Wrong(format!("{error}; it said: {}", beginning(&line))),
                other => other,
            });
            self.line = line;
            taken
        });
        taken.map_err(|silence| {
            let why = self.last_words(request.name(), within, silence);
            self.over = Some(why.clone());
            why
        })
    }

    /// Sends one line; the reply is in `line` then.
    fn send_and_hear(&mut self, request: &Numbered<'_>, until: Instant) -> Result<(), Silence> {
        let mut message = serde_json::to_vec(request).map_err(|error| Silence::Wrong(error.to_string()))?;
        message.push(b'\n');
        // What it says unasked would be taken for the reply to this.
        self.hear()?;
        if !self.heard.is_empty() {
            return Err(Silence::Wrong(format!("it said more than one line: {}", beginning(&self.heard))));
        }
        let Some(stdin) = &mut self.stdin else { return Err(Silence::Ended) };
        let mut rest = message.as_slice();
        while !rest.is_empty() {
            match stdin.write(rest) {
                Ok(count) => rest = &rest[count..],
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    wait(PollFd::new(stdin, PollFlags::OUT), until)?;
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error.into()),
            }
        }
        let mut looked_at = 0;
        loop {
            if let Some(end) = self.heard[looked_at..].iter().position(|byte| *byte == b'\n') {
                let end = looked_at + end;
                self.line.clear();
                self.line.extend(self.heard.drain(..=end));
                self.line.pop();
                return Ok(());
            }
            looked_at = self.heard.len();
            if looked_at > LONGEST {
                return Err(Silence::Wrong("a line without end".to_owned()));
            }
            if !self.hear()? {
                wait(PollFd::new(&self.stdout, PollFlags::IN), until)?;
            }
        }
    }

    /// Takes in what has been said, if anything has.
    fn hear(&mut self) -> std::io::Result<bool> {
        let before = self.heard.len();
        self.heard.resize(before + CHUNK, 0);
        let read = self.stdout.read(&mut self.heard[before..]);
        self.heard.truncate(before + read.as_ref().map_or(0, |count| *count));
        match read {
            Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
            Ok(_) => Ok(true),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Why there is no reply to go on with; the process has ended then.
    fn last_words(&mut self, asked: &str, within: Duration, silence: Silence) -> String {
        wait_if_over();
        if matches!(silence, Silence::Ended) {
            self.wait_for(END);
        }
        let alone = self.has_ended();
        let ended = self.end();
        // What it printed may name folders of this machine: that is for the person here, and no part of what is recorded.
        self.said.show(&self.who);
        let who = &self.who;
        match silence {
            Silence::Late => format!("`{who}`: no answer to `{asked}` within {} s", within.as_secs_f64()),
            Silence::Wrong(what) => format!("`{who}`: its answer to `{asked}` is wrong: {what}"),
            Silence::Refused(why) => format!("`{who}` refuses `{asked}`: {}", one_line(&why)),
            Silence::Ended if alone => format!("`{who}`: its process ended at `{asked}` ({ended})"),
            Silence::Ended => format!("`{who}`: its process no longer answers `{asked}` and was ended"),
        }
    }

    /// Whether the process has ended; it is not taken leave of yet, so that its number still means it.
    fn has_ended(&self) -> bool {
        let Some(pid) = Pid::from_raw(self.child.id() as i32) else { return true };
        let look = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        !matches!(waitid(WaitId::Pid(pid), look), Ok(None))
    }

    fn wait_for(&self, longest: Duration) {
        let began = Instant::now();
        while began.elapsed() < longest && !self.has_ended() {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Ends the process and all of its group, and says how it ended.
    fn end(&mut self) -> String {
        self.stdin = None;
        // Until it has been waited for nobody else has its number, nor that of its group.
        if let Some(group) = Pid::from_raw(self.child.id() as i32) {
            let _ = kill_process_group(group, Signal::KILL);
        }
        self.living = None;
        self.child.wait().map_or_else(|error| error.to_string(), |status| status.to_string())
    }
}

impl Drop for Conversation {
    fn drop(&mut self) {
        add_exchange_times(&self.who, &self.file, &self.times);
        if self.over.is_some() {
            return;
        }
        // The end of its input is the end of the conversation.
        self.stdin = None;
        self.wait_for(LEAVE);
        self.end();
        // Every reply that was used had its number; what came behind the last is a fault of the program that has changed nothing.
        let _ = self.hear();
        if !self.heard.is_empty() {
            tell_once(&format!("`{}` said more than it was asked: {}\n", self.who, beginning(&self.heard)));
        }
    }
}

/// Waits until there is something to read or room to write.
fn wait(what: PollFd<'_>, until: Instant) -> std::io::Result<()> {
    let mut all = [what];
    loop {
        let rest = until.saturating_duration_since(Instant::now());
        if rest.is_zero() {
            return Err(ErrorKind::TimedOut.into());
        }
        let rest = Timespec { tv_sec: rest.as_secs() as i64, tv_nsec: i64::from(rest.subsec_nanos()) };
        match poll(&mut all, Some(&rest)) {
            Ok(0) | Err(Errno::INTR) => {}
            Ok(_) => return Ok(()),
            Err(error) => return Err(error.into()),
        }
    }
}

fn parsed<T: DeserializeOwned>(line: &[u8]) -> Result<T, String> {
    serde_json::from_slice(line).map_err(|error| {
        let text = String::from_utf8_lossy(line);
        let not_finite = ["NaN", "Infinity", "nan", "inf"].iter().any(|word| text.contains(word));
        let hint = if error.is_syntax() && not_finite { ": JSON has finite numbers only" } else { "" };
        let what = if error.is_data() { "" } else { "no line of JSON: " };
        format!("{what}{error}{hint}")
    })
}

fn one_line(text: &str) -> String {
    text.trim().chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// The beginning of a line, on one line.
fn beginning(line: &[u8]) -> String {
    let text = String::from_utf8_lossy(&line[..line.len().min(4 * REPEATED)]);
    let shown: String = one_line(&text).chars().take(REPEATED).collect();
    if shown.len() < line.len() { format!("{shown}…") } else { shown }
}
