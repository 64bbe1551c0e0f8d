//! A file that is written whole.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Bytes that are gathered before they are written.
const GATHERED: usize = 1 << 16;

/// A file that takes the place of what is at its path when it is whole: what was there stays until then.
///
/// It is written under its name with `.part` behind it, locked, so that no two processes write one file, and renamed at the end.
/// Whole lines are written as they are gathered: a process that is killed leaves some of them there, and the next one that writes
/// this file begins anew. A symbolic link stays one. What is no regular file (a pipe, a device, the standard output) is written as it
/// is. Dropped before [`commit`](Self::commit) or [`keep`](Self::keep), it is removed.
///
/// ```
/// use euler_poincare::file::{Kept, Output};
/// use std::fs;
/// use std::io::Write;
///
/// # let directory = std::env::temp_dir().join(format!("euler-poincare-output-{}", std::process::id()));
/// # fs::create_dir_all(&directory)?;
/// let path = directory.join("table.csv");
/// fs::write(&path, "old")?;
/// let mut output = Output::create(&path)?;
/// output.write_all(b"t\n0\n1\n2")?;
/// assert!(Output::create(&path).is_err(), "it is taken");
/// // The disk was full, say.
/// let Some(Kept { path: part, lines }) = output.keep()? else { panic!("a file") };
/// assert_eq!((lines, fs::read_to_string(part)?), (3, "t\n0\n1\n".into()));
/// assert_eq!(fs::read_to_string(&path)?, "old");
///
/// let mut output = Output::create(&path)?;
/// output.write_all(b"new")?;
/// output.commit()?;
/// assert_eq!(fs::read_to_string(&path)?, "new");
/// # fs::remove_dir_all(&directory)?;
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug)]
pub struct Output {
    /// The path in question, without links.
    target: PathBuf,
    /// Where the lines are until it is whole; `None`: they go to the target.
    part: Option<PathBuf>,
    file: File,
    gathered: Vec<u8>,
    /// Bytes in the file, those up to the last end of a line, and how many of these ends there are.
    written: u64,
    whole: u64,
    lines: u64,
}

/// What is kept of a file that was not written to its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Kept {
    /// Where it is.
    pub path: PathBuf,
    /// How many lines it has, all of them whole.
    pub lines: u64,
}

impl Output {
    /// The file at a path, which is made or replaced in the end.
    ///
    /// # Errors
    /// What the system says; [`ResourceBusy`](io::ErrorKind::ResourceBusy) where another process is writing this file.
    pub fn create(path: &Path) -> io::Result<Self> {
        if let Some(stream) = standard(path) {
            return Ok(Self::direct(stream?));
        }
        let there = match fs::metadata(path) {
            // A name with a separator behind it is that of a folder.
            Err(error) if error.kind() == io::ErrorKind::NotFound && !path.to_string_lossy().ends_with('/') => None,
            there => Some(there?),
        };
        let target = match &there {
            Some(there) => {
                // A file that must not be written is not replaced either.
                let file = OpenOptions::new().write(true).open(path)?;
                if !there.is_file() {
                    return Ok(Self::direct(file));
                }
                path.canonicalize()?
            }
            None => end_of_links(path),
        };
        let part = Self::part(&target).ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "names no file"))?;
        let file = taken(&part).map_err(|error| match error.kind() {
            io::ErrorKind::ResourceBusy | io::ErrorKind::NotFound => error,
            kind => io::Error::new(kind, format!("cannot write {}: {error}", part.display())),
        })?;
        file.set_len(0)?;
        if let Some(there) = there {
            // The owner of the directory may not be that of the file: then it has the rights of a new one.
            let _ = file.set_permissions(there.permissions());
        }
        Ok(Self { target, part: Some(part), file, gathered: Vec::new(), written: 0, whole: 0, lines: 0 })
    }

    /// The standard output of this process.
    ///
    /// # Errors
    /// What the system says.
    pub fn standard() -> io::Result<Self> {
        Ok(Self::direct(duplicate(1)?))
    }

    /// Where the lines of a file are until it is whole; `None` for a path that names no file.
    pub fn part(path: &Path) -> Option<PathBuf> {
        let mut name = path.file_name()?.to_owned();
        name.push(SUFFIX);
        Some(path.with_file_name(name))
    }

    fn direct(file: File) -> Self {
        Self { target: PathBuf::new(), part: None, file, gathered: Vec::new(), written: 0, whole: 0, lines: 0 }
    }

    /// Puts the file in its place, when all of it is on the disk.
    ///
    /// # Errors
    /// What the system says. What was there is there, then; a file that is whole and could not be renamed is kept, and its name told.
    pub fn commit(mut self) -> io::Result<()> {
        self.flush()?;
        let Some(part) = &self.part else { return Ok(()) };
        self.file.sync_all()?;
        let renamed = fs::rename(part, &self.target);
        let part = self.part.take();
        renamed.map_err(|error| {
            let part = part.unwrap_or_default();
            io::Error::new(error.kind(), format!("{error}; the new file is {}", part.display()))
        })
    }

    /// Keeps the whole lines beside what is at the path, and leaves that as it is; nothing is to be kept of what is no regular file, or
    /// where no line is whole.
    ///
    /// # Errors
    /// What the system says.
    pub fn keep(mut self) -> io::Result<Option<Kept>> {
        // As much as there is room for.
        let _ = self.flush();
        if self.lines == 0 || self.part.is_none() {
            return Ok(None);
        }
        self.file.set_len(self.whole)?;
        self.file.sync_all()?;
        Ok(self.part.take().map(|path| Kept { path, lines: self.lines }))
    }

    /// Writes the first `count` of the gathered bytes.
    fn pour(&mut self, count: usize) -> io::Result<()> {
        let mut poured = 0;
        let outcome = loop {
            let Some(left) = self.gathered.get(poured..count).filter(|left| !left.is_empty()) else { break Ok(()) };
            match self.file.write(left) {
                Ok(0) => break Err(io::ErrorKind::WriteZero.into()),
                Ok(taken) => {
                    let ends = left[..taken].iter().enumerate().filter(|(_, byte)| **byte == b'\n');
                    for (at, _) in ends {
                        self.lines += 1;
                        self.whole = self.written + at as u64 + 1;
                    }
                    self.written += taken as u64;
                    poured += taken;
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => break Err(error),
            }
        };
        self.gathered.drain(..poured);
        outcome
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.gathered.len() + bytes.len() > GATHERED {
            let end = self.gathered.iter().rposition(|byte| *byte == b'\n').map_or(self.gathered.len(), |at| at + 1);
            self.pour(end)?;
        }
        self.gathered.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.pour(self.gathered.len())
    }
}

impl Drop for Output {
    fn drop(&mut self) {
        if let Some(part) = &self.part {
            // Before the lock goes. No caller can be told.
            let _ = fs::remove_file(part);
        }
    }
}

/// Writes a file whole: see [`Output`].
///
/// # Errors
/// What the system says.
pub fn write(path: &Path, bytes: impl AsRef<[u8]>) -> io::Result<()> {
    let mut output = Output::create(path)?;
    output.write_all(bytes.as_ref())?;
    output.commit()
}

/// Behind the name of a file that is not whole.
const SUFFIX: &str = ".part";

/// The file for this process alone.
fn taken(part: &Path) -> io::Result<File> {
    loop {
        if fs::symlink_metadata(part).is_ok_and(|there| !there.is_file()) {
            return Err(io::Error::new(io::ErrorKind::AlreadyExists, "it is there, and no regular file"));
        }
        let file = OpenOptions::new().write(true).create(true).truncate(false).open(part)?;
        lock(&file)?;
        // Who held the lock a moment ago may have renamed or removed the file.
        if is_at(&file, part)? {
            return Ok(file);
        }
    }
}

/// Locks the file for this process; it does not wait.
pub(crate) fn lock(file: &File) -> io::Result<()> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => {
            Err(io::Error::new(io::ErrorKind::ResourceBusy, "another run is writing there"))
        }
        // Some network file systems know no locks: there no run is kept out.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    let own = file.metadata()?;
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        there => there.map(|there| (there.dev(), there.ino()) == (own.dev(), own.ino())),
    }
}

#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> io::Result<bool> {
    path.try_exists()
}

/// The path that a chain of symbolic links leads to, where nothing is there yet.
fn end_of_links(path: &Path) -> PathBuf {
    match fs::read_link(path) {
        // What is not there is no loop: the chain ends.
        Ok(next) => end_of_links(&path.parent().unwrap_or(Path::new("")).join(next)),
        Err(_) => path.to_owned(),
    }
}

/// A stream of this process, if the path names one. Opened by its name, a file behind it would have a second position.
fn standard(path: &Path) -> Option<io::Result<File>> {
    match path.to_str()? {
        "/dev/stdout" | "/dev/fd/1" | "/proc/self/fd/1" => Some(duplicate(1)),
        "/dev/stderr" | "/dev/fd/2" | "/proc/self/fd/2" => Some(duplicate(2)),
        _ => None,
    }
}

#[cfg(unix)]
fn duplicate(stream: u8) -> io::Result<File> {
    use std::os::fd::AsFd;
    let owned =
        if stream == 1 { io::stdout().as_fd().try_clone_to_owned() } else { io::stderr().as_fd().try_clone_to_owned() };
    Ok(File::from(owned?))
}

#[cfg(windows)]
fn duplicate(stream: u8) -> io::Result<File> {
    use std::os::windows::io::AsHandle;
    let owned = if stream == 1 {
        io::stdout().as_handle().try_clone_to_owned()
    } else {
        io::stderr().as_handle().try_clone_to_owned()
    };
    Ok(File::from(owned?))
}
