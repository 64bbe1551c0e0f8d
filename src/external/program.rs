//! A command that is asked and answers, a line each, within a time limit and with bounded memory.

use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, TryRecvError, channel, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// What a program may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// For one answer.
    pub timeout: Duration,
    /// For starting: the first answer after a start may take so much longer. Once that was not enough, it is not given again.
    pub startup: Duration,
    /// Of one answer, in bytes; and of what it writes to standard error while it is asked.
    pub bytes: usize,
    /// How often it is started again after it failed.
    pub restarts: usize,
}

impl Default for Limits {
    fn default() -> Self {
        // A minute is enough for interpreters that import large packages.
        Self { timeout: Duration::from_secs(10), startup: Duration::from_secs(60), bytes: 1 << 20, restarts: 5 }
    }
}

/// A request, and what came back (cut where it is long).
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Exchange {
    /// The line that was written.
    pub request: String,
    /// The line that was read; empty where none came.
    pub answer: String,
}

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Silence {
    /// The command cannot be started.
    #[error("the stepper cannot be started: {why}")]
    NotStarted {
        /// The system's reason.
        why: String,
    },
    /// No line within the time limit.
    #[error("no answer from the stepper within {seconds} s{}{}{}", to_start(*startup), heard(heard_so_far), errors(stderr))]
    Hung {
        /// The time limit.
        seconds: f64,
        /// How much of it was for starting.
        startup: f64,
        /// What it had written of a line, without a newline.
        heard_so_far: String,
        /// The end of its standard error.
        stderr: String,
    },
    /// It ended.
    #[error("the stepper ended ({status}){}{}", heard(heard_so_far), errors(stderr))]
    Died {
        /// How.
        status: String,
        /// What it had written of a line, without a newline.
        heard_so_far: String,
        /// The end of its standard error.
        stderr: String,
    },
    /// A line without end, or errors without end.
    #[error("the stepper writes too much to its standard {stream}: more than {bytes} bytes for one request")]
    Flooded {
        /// `output` or `error`.
        stream: &'static str,
        /// The limit.
        bytes: usize,
    },
    /// A line before it was asked.
    #[error("the stepper answers before it is asked: {line}")]
    Unasked {
        /// The line, cut where it is long.
        line: String,
    },
    /// It failed too often.
    #[error("not asked: the stepper failed {failures} times and is not started again")]
    GivenUp {
        /// How often.
        failures: usize,
    },
    /// The run was interrupted, see [`Program::interrupted_by`]. This is no failure of the program.
    #[error("the run was interrupted")]
    Interrupted,
}

fn to_start(seconds: f64) -> String {
    if seconds == 0.0 { String::new() } else { format!(" ({seconds} s of them to start)") }
}

fn heard(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("; it had written, without a newline: {text}") }
}

fn errors(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("; its standard error ends with: {text}") }
}

/// The beginning of a text, as one line without control characters.
pub(super) fn shown(bytes: &[u8], most: usize) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(4 * most)]);
    let mut line: String = text.chars().take(most).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().count() > most || bytes.len() > 4 * most {
        line.push('…');
    }
    line.trim_end().to_owned()
}

/// The most of a text that is shown.
const SHOWN: usize = 200;

/// The most of a line that is kept in an exchange.
const KEPT: usize = 20_000;

/// How much of the end of standard error is kept.
const TAIL: usize = 1000;

/// How often an interrupt is looked for while an answer is awaited.
const LOOK: Duration = Duration::from_millis(50);

enum Event {
    Line(Vec<u8>),
    TooLong,
    End(Vec<u8>),
    Errors,
}

/// Standard error, as far as it is kept.
#[derive(Default)]
struct Errors {
    tail: Mutex<VecDeque<u8>>,
    since_asked: AtomicUsize,
}

struct Running {
    child: Child,
    requests: Option<Sender<String>>,
    events: Receiver<Event>,
    errors: Arc<Errors>,
    partial: Arc<Mutex<Vec<u8>>>,
    /// Whether it has answered since it was started.
    has_answered: bool,
}

/// A command with its limits: started when it is first asked.
pub struct Program {
    command: Vec<String>,
    limits: Limits,
    interrupt: Option<Arc<AtomicBool>>,
    running: Option<Running>,
    failures: usize,
    /// Whether it once took longer than it may to start.
    hung_at_start: bool,
    last: Option<Exchange>,
    failure: Option<(Exchange, String)>,
}

impl Program {
    /// A program and its arguments. Nothing is started yet.
    pub fn new(command: &[String], limits: Limits) -> Self {
        Self {
            command: command.to_vec(),
            limits,
            interrupt: None,
            running: None,
            failures: 0,
            hung_at_start: false,
            last: None,
            failure: None,
        }
    }

    /// Stops the program, and asks it nothing more, once this is set.
    pub fn interrupted_by(mut self, interrupt: Arc<AtomicBool>) -> Self {
        self.interrupt = Some(interrupt);
        self
    }

    /// Whether it is.
    pub fn is_interrupted(&self) -> bool {
        is_set(self.interrupt.as_ref())
    }

    /// Starts it, where it is not running.
    ///
    /// # Errors
    /// [`Silence::NotStarted`].
    pub fn start(&mut self) -> Result<(), Silence> {
        if self.running.is_none() {
            self.running = Some(start(&self.command, self.limits.bytes)?);
        }
        Ok(())
    }

    /// How often it failed.
    pub fn failures(&self) -> usize {
        self.failures
    }

    /// Whether it failed too often to be started again.
    pub fn is_given_up(&self) -> bool {
        self.failures > self.limits.restarts
    }

    /// Forgets the exchanges.
    pub fn forget(&mut self) {
        (self.last, self.failure) = (None, None);
    }

    /// The first exchange that failed since they were forgotten, and why.
    pub fn failure(&self) -> Option<&(Exchange, String)> {
        self.failure.as_ref()
    }

    /// The last exchange since they were forgotten.
    pub fn last(&self) -> Option<&Exchange> {
        self.last.as_ref()
    }

    /// Writes a line, and waits for the line that answers it.
    ///
    /// # Errors
    /// See [`Silence`]; the program is then killed, and started again for the next request.
    pub fn ask(&mut self, request: &str) -> Result<Vec<u8>, Silence> {
        if self.is_given_up() {
            return Err(Silence::GivenUp { failures: self.failures });
        }
        if self.is_interrupted() {
            self.stop(Duration::ZERO);
            return Err(Silence::Interrupted);
        }
        let answer = self.exchange(request);
        if answer == Err(Silence::Interrupted) {
            self.stop(Duration::ZERO);
            return answer;
        }
        let line = match &answer {
            Ok(line) => shown(line, KEPT),
            Err(_) => String::new(),
        };
        self.last = Some(Exchange { request: request.to_owned(), answer: line });
        if let Err(silence) = &answer {
            self.failed(&silence.to_string());
        }
        answer
    }

    /// What it answered is no state: it is killed, and that counts as a failure.
    pub fn failed(&mut self, why: &str) {
        self.failures += 1;
        if let (None, Some(exchange)) = (&self.failure, &self.last) {
            self.failure = Some((exchange.clone(), why.to_owned()));
        }
        self.stop(Duration::ZERO);
    }

    fn exchange(&mut self, request: &str) -> Result<Vec<u8>, Silence> {
        let limits = self.limits;
        let running = match self.running.take() {
            Some(running) => running,
            None => start(&self.command, limits.bytes)?,
        };
        let running = self.running.insert(running);
        match running.events.try_recv() {
            Ok(event) => return running.answered(event, &limits, true),
            Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) => return Err(running.died(Vec::new())),
        }
        running.errors.since_asked.store(0, Ordering::Relaxed);
        if let Some(requests) = &running.requests {
            // Where the writer has ended the program has too: the events say so.
            let _ = requests.send(format!("{request}\n"));
        }
        let interrupted = || is_set(self.interrupt.as_ref());
        let startup = if running.has_answered || self.hung_at_start { Duration::ZERO } else { limits.startup };
        let limit = limits.timeout.saturating_add(startup);
        match running.wait(limit, interrupted) {
            None => Err(Silence::Interrupted),
            Some(Ok(event)) => running.answered(event, &limits, false),
            Some(Err(RecvTimeoutError::Disconnected)) => Err(running.died(Vec::new())),
            Some(Err(RecvTimeoutError::Timeout)) => {
                self.hung_at_start |= !running.has_answered;
                Err(Silence::Hung {
                    seconds: limit.as_secs_f64(),
                    startup: startup.as_secs_f64(),
                    heard_so_far: running.partial.lock().map(|partial| shown(&partial, SHOWN)).unwrap_or_default(),
                    stderr: running.stderr(),
                })
            }
        }
    }

    fn stop(&mut self, patience: Duration) {
        if let Some(running) = self.running.take() {
            running.end(patience);
        }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        self.stop(Duration::from_millis(200));
    }
}

/// Kills what the command has started as well: a shell's child would go on, and hold the pipes open.
fn kill_group(child: &Child) {
    #[cfg(unix)]
    if let Some(group) = i32::try_from(child.id()).ok().and_then(rustix::process::Pid::from_raw) {
        let _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
    }
    #[cfg(not(unix))]
    let _ = child;
}

impl Running {
    /// Ends the process: a while to end by itself when its input closes, then killed with its group. It is always waited for.
    fn end(mut self, patience: Duration) {
        self.requests = None;
        let deadline = Instant::now() + patience;
        while Instant::now() < deadline && matches!(self.child.try_wait(), Ok(None)) {
            thread::sleep(Duration::from_millis(2));
        }
        kill_group(&self.child);
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    /// The next event within a time; `None` where it is interrupted.
    fn wait(&self, limit: Duration, interrupted: impl Fn() -> bool) -> Option<Result<Event, RecvTimeoutError>> {
        let deadline = Instant::now() + limit;
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            match self.events.recv_timeout(left.min(LOOK)) {
                Err(RecvTimeoutError::Timeout) if interrupted() => return None,
                Err(RecvTimeoutError::Timeout) if left > LOOK => {}
                found => return Some(found),
            }
        }
    }

    fn answered(&mut self, event: Event, limits: &Limits, unasked: bool) -> Result<Vec<u8>, Silence> {
        match event {
            Event::Line(line) if unasked => Err(Silence::Unasked { line: shown(&line, SHOWN) }),
            Event::Line(line) => {
                self.has_answered = true;
                Ok(line)
            }
            Event::TooLong => Err(Silence::Flooded { stream: "output", bytes: limits.bytes }),
            Event::Errors => Err(Silence::Flooded { stream: "error", bytes: limits.bytes }),
            Event::End(partial) => Err(self.died(partial)),
        }
    }

    fn died(&mut self, partial: Vec<u8>) -> Silence {
        // Its output has ended; the process may need a moment more, or go on without output.
        let deadline = Instant::now() + Duration::from_millis(500);
        let status = loop {
            match self.child.try_wait() {
                Ok(Some(status)) => break status.to_string(),
                Ok(None) if Instant::now() < deadline => thread::sleep(Duration::from_millis(5)),
                Ok(None) => break "it closed its standard output, and is still running".into(),
                Err(error) => break error.to_string(),
            }
        };
        Silence::Died { status, heard_so_far: shown(&partial, SHOWN), stderr: self.stderr() }
    }

    fn stderr(&self) -> String {
        // What it wrote last may be on its way.
        thread::sleep(Duration::from_millis(20));
        let tail = self.errors.tail.lock();
        tail.map(|tail| shown(&tail.iter().copied().collect::<Vec<_>>(), TAIL)).unwrap_or_default()
    }
}

fn is_set(interrupt: Option<&Arc<AtomicBool>>) -> bool {
    interrupt.is_some_and(|interrupt| interrupt.load(Ordering::Relaxed))
}

fn start(command: &[String], bytes: usize) -> Result<Running, Silence> {
    let not_started = |why: String| Silence::NotStarted { why };
    let (name, arguments) = command.split_first().ok_or_else(|| not_started("there is no command".into()))?;
    let mut process = Command::new(name);
    process.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut process, 0);
    let mut child = process.spawn().map_err(|error| not_started(format!("{name}: {error}")))?;
    let (Some(input), Some(output), Some(stderr)) = (child.stdin.take(), child.stdout.take(), child.stderr.take())
    else {
        return Err(not_started(format!("{name}: it has no pipes")));
    };
    let (requests, lines) = channel();
    // Bounded: who floods waits.
    let (events, received) = sync_channel(4);
    let (errors, partial) = (Arc::new(Errors::default()), Arc::new(Mutex::new(Vec::new())));
    let spawned = [
        spawn(move || write_requests(input, &lines)),
        spawn({
            let (events, partial) = (events.clone(), partial.clone());
            move || read_answers(output, bytes, &events, &partial)
        }),
        spawn({
            let errors = errors.clone();
            move || read_errors(stderr, bytes, &events, &errors)
        }),
    ];
    let running = Running { child, requests: Some(requests), events: received, errors, partial, has_answered: false };
    if let Some(error) = spawned.into_iter().find_map(Result::err) {
        running.end(Duration::ZERO);
        return Err(not_started(format!("no thread for it: {error}")));
    }
    Ok(running)
}

fn spawn(body: impl FnOnce() + Send + 'static) -> std::io::Result<()> {
    thread::Builder::new().name("stepper".into()).spawn(body).map(drop)
}

/// Until the program or the other end of the channel is gone.
fn write_requests(mut input: ChildStdin, lines: &Receiver<String>) {
    while let Ok(line) = lines.recv() {
        if input.write_all(line.as_bytes()).and_then(|()| input.flush()).is_err() {
            return;
        }
    }
}

fn read_answers(output: impl Read, most: usize, events: &SyncSender<Event>, partial: &Mutex<Vec<u8>>) {
    let mut output = BufReader::new(output);
    loop {
        let bytes = match output.fill_buf() {
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => continue,
            read => read.unwrap_or_default(),
        };
        let Ok(mut line) = partial.lock() else { return };
        let end = bytes.iter().position(|byte| *byte == b'\n');
        line.extend_from_slice(&bytes[..end.unwrap_or(bytes.len())]);
        let event = match end {
            _ if line.len() + usize::from(end.is_some()) > most => Some(Event::TooLong),
            Some(_) => Some(Event::Line(std::mem::take(&mut *line))),
            None if bytes.is_empty() => Some(Event::End(std::mem::take(&mut *line))),
            None => None,
        };
        drop(line);
        let read = end.map_or(bytes.len(), |end| end + 1);
        output.consume(read);
        if let Some(event) = event {
            let last = !matches!(event, Event::Line(_));
            if events.send(event).is_err() || last {
                return;
            }
        }
    }
}

fn read_errors(mut stderr: impl Read, most: usize, events: &SyncSender<Event>, errors: &Errors) {
    let mut chunk = [0; 8192];
    loop {
        let read = match stderr.read(&mut chunk) {
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => continue,
            read => read.unwrap_or(0),
        };
        if read == 0 {
            return;
        }
        if let Ok(mut tail) = errors.tail.lock() {
            tail.extend(&chunk[..read]);
            let excess = tail.len().saturating_sub(TAIL);
            tail.drain(..excess);
        }
        if errors.since_asked.fetch_add(read, Ordering::Relaxed) + read > most {
            let _ = events.send(Event::Errors);
            return;
        }
    }
}
