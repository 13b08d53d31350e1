//! The window's own files: recent projects and parts, preferences, layout and recovery copies. Without a home
//! folder none of them is stored.

use std::fs::DirEntry;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, SystemTime};

use serde::{Deserialize, Serialize};

use crate::io::InputError;
use crate::io::hash::{FNV_START, fnv1a};
use crate::io::project_file::{EXTENSION, PartLocation, Project, read_project};
use crate::io::shop_tools::{LibraryFormat, ToolLibrary, read_library, write_toml};
use crate::io::source::{one_name_of, read_bytes};
use crate::io::write::write_atomically;

use crate::app::model::layout::Layout;
use crate::app::model::library_state::LibraryState;
use crate::app::model::mouse_preset::MousePreset;
use crate::app::model::state::RecoveryCopy;
use crate::app::model::units::DisplayUnits;

use super::lock::{HeldLock, LockTry, is_held, try_hold};

/// File of the preferences.
const HABITS: &str = "habits.json";
/// File of the layout of the panels.
const LAYOUT: &str = "layout.json";
/// Ending of copies of the tool library.
const LIBRARY_ENDING: &str = "toml";
/// What the first line of such a copy begins with, before the path of the library.
const ORIGINAL: &str = "# of ";
/// Age of a lock file that nobody holds, from which on it counts as left behind.
const LEFT_LOCK: Duration = Duration::from_secs(3600);
/// Maximum number of recent files.
const MAX_RECENTS: usize = 10;

/// User preferences that do not depend on the open project.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// Mouse preset of the camera.
    pub mouse: MousePreset,
    /// Units of lengths and feed rates.
    pub units: DisplayUnits,
    /// Whether the tour was taken or skipped.
    pub knows_tour: bool,
}

/// A tool library that a session left behind with edits that are not saved.
#[derive(Debug)]
pub struct LeftLibrary {
    /// Its file; `None` for the program's own tools.
    pub original: Option<PathBuf>,
    /// The library, edited.
    pub content: ToolLibrary,
    /// The file of the copy.
    pub copy: PathBuf,
}

/// Folder of the window's own files.
#[derive(Clone, Debug)]
pub struct Home {
    folder: PathBuf,
    /// This session's recovery copy; its name contains process number and time, so that it is unique.
    copy: PathBuf,
    /// Locked as long as this session runs; shared by the clones of this home.
    lock: Arc<OnceLock<HeldLock>>,
    /// How often the copy of the tool library was given up.
    given_up: Arc<AtomicU64>,
}

/// A copy of the tool library to be written, in the background: libraries may be large.
pub struct LibraryCopy {
    home: Home,
    /// File of the library.
    original: Option<PathBuf>,
    library: LibraryState,
    /// How often copies had been given up when it was asked for.
    given_up: u64,
}

impl LibraryCopy {
    /// Writes it, unless it is given up meanwhile.
    ///
    /// # Errors
    /// [`InputError`] when the folder or the file cannot be written.
    pub fn write(&self) -> Result<(), InputError> {
        let home = &self.home;
        let written = home.write_library_copy(self.original.as_deref(), &self.library);
        if home.given_up.load(Ordering::SeqCst) != self.given_up {
            home.remove_library_copy();
        }
        written
    }
}

impl Home {
    /// A home in `folder`, which need not exist.
    pub fn new(folder: PathBuf) -> Self {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().as_nanos();
        let copy = folder.join("recovery").join(format!("{}-{now}.{EXTENSION}", std::process::id()));
        Self { folder, copy, lock: Arc::default(), given_up: Arc::default() }
    }

    /// Path of this session's recovery copy.
    pub fn copy(&self) -> &Path {
        &self.copy
    }

    /// Writes this session's recovery copy.
    ///
    /// # Errors
    /// [`InputError`] when the folder or the file cannot be written.
    pub fn write_copy(&self, text: &str) -> Result<(), InputError> {
        if let Some(folder) = self.copy.parent() {
            // If this fails, the write below reports the error.
            let _ = std::fs::create_dir_all(folder);
        }
        self.hold_lock();
        write_atomically(&self.copy, text.as_bytes())
    }

    /// Locks the file beside the recovery copy that says that its session runs. The system unlocks it however
    /// the session ends.
    fn hold_lock(&self) {
        if self.lock.get().is_some() {
            return;
        }
        // Without a lock the copy counts as abandoned.
        if let LockTry::Held(lock) = try_hold(lock_of(&self.copy)) {
            // Set once: this is the only place that sets it.
            let _ = self.lock.set(lock);
        }
    }

    /// Tries to hold the lock that says that the project file at `path` is open in a window.
    pub fn hold_project(&self, path: &Path) -> LockTry {
        // One file has one lock, by whatever way it was opened.
        let file = one_name_of(path);
        let hash = fnv1a(FNV_START, file.as_os_str().as_encoded_bytes().iter().copied());
        try_hold(self.folder.join("locks").join(format!("project-{hash:016x}.lock")))
    }

    /// This session's copy of the edited tool library at `original`, to be written.
    pub fn library_copy(&self, original: Option<PathBuf>, library: LibraryState) -> LibraryCopy {
        LibraryCopy { home: self.clone(), original, library, given_up: self.given_up.load(Ordering::SeqCst) }
    }

    fn write_library_copy(&self, original: Option<&Path>, library: &ToolLibrary) -> Result<(), InputError> {
        let copy = self.copy.with_extension(LIBRARY_ENDING);
        if let Some(folder) = copy.parent() {
            // If this fails, the write below reports the error.
            let _ = std::fs::create_dir_all(folder);
        }
        self.hold_lock();
        let original = original.map_or(String::new(), |path| path.display().to_string());
        write_atomically(&copy, format!("{ORIGINAL}{original}\n{}", write_toml(library)).as_bytes())
    }

    /// Removes this session's copy of the tool library, after saving or discarding; one that is being written
    /// goes, too.
    pub fn drop_library_copy(&self) {
        self.given_up.fetch_add(1, Ordering::SeqCst);
        self.remove_library_copy();
    }

    fn remove_library_copy(&self) {
        // There may be none.
        let _ = std::fs::remove_file(self.copy.with_extension(LIBRARY_ENDING));
    }

    /// The copy of the tool library of the last session that ended without closing.
    pub fn left_library(&self) -> Option<LeftLibrary> {
        let readable = |copy: PathBuf| {
            let content = read_library(&copy, LibraryFormat::Toml).ok()?;
            let text = text_of(&copy);
            let original = text.lines().next()?.strip_prefix(ORIGINAL).filter(|path| !path.is_empty());
            Some(LeftLibrary { original: original.map(PathBuf::from), content, copy })
        };
        self.left_copies(LIBRARY_ENDING).into_iter().find_map(readable)
    }

    /// Removes this session's recovery copy, after saving or discarding.
    pub fn drop_copy(&self) {
        // A later copy of this session keeps the lock.
        let _ = std::fs::remove_file(&self.copy);
    }

    /// Recovery copies of other sessions that ended without closing, with what a user knows them by, latest
    /// first.
    pub fn recoverable(&self) -> Vec<RecoveryCopy> {
        let copies: Vec<LeftCopy> = self.recovery_copies().into_iter().map(LeftCopy::read).collect();
        let titles: Vec<String> = copies.iter().map(|copy| copy.title(Age::InWords)).collect();
        let is_one_of_several = |title: &String| titles.iter().filter(|other| *other == title).count() > 1;
        let exactness = titles.iter().map(|title| match is_one_of_several(title) {
            true => Age::ToTheSecond,
            false => Age::InWords,
        });
        copies.into_iter().zip(exactness).map(|(copy, exactness)| copy.offered(exactness)).collect()
    }

    /// Whether the session of another recovery copy runs. One that was killed runs, too, until the system has
    /// freed what it had, which takes seconds where that is much.
    pub fn has_running_session(&self) -> bool {
        self.copies_of_others(EXTENSION).any(|copy| is_held(&lock_of(&copy.path())))
    }

    /// Removes the lock files of sessions that ended without closing and left no copy.
    pub fn sweep_locks(&self) {
        let files = std::fs::read_dir(self.folder.join("locks")).into_iter().flatten().flatten();
        for path in files.map(|entry| entry.path()) {
            let stem = path.file_stem().unwrap_or_default();
            let copy = self.copy.with_file_name(stem);
            let has_copy =
                [EXTENSION, LIBRARY_ENDING].iter().any(|ending| copy.with_extension(ending).exists());
            // A file that is not held yet may be one that another session is about to lock.
            if !has_copy && is_older(&path, LEFT_LOCK) && !is_held(&path) {
                // The file is empty: it does no harm where it cannot be removed.
                let _ = std::fs::remove_file(&path);
            }
        }
    }

    /// Recovery copies of other sessions that ended without closing, latest first.
    fn recovery_copies(&self) -> Vec<PathBuf> {
        self.left_copies(EXTENSION)
    }

    /// The same of copies with this ending.
    fn left_copies(&self, ending: &str) -> Vec<PathBuf> {
        let mut found: Vec<(SystemTime, PathBuf)> = self
            .copies_of_others(ending)
            .filter_map(|copy| {
                let changed = copy.metadata().and_then(|data| data.modified()).ok()?;
                let path = copy.path();
                (!is_held(&lock_of(&path))).then_some((changed, path))
            })
            .collect();
        found.sort_by(|a, b| b.cmp(a));
        found.into_iter().map(|(_, path)| path).collect()
    }

    /// Copies with this ending of all other sessions, those that run too.
    fn copies_of_others(&self, ending: &str) -> impl Iterator<Item = DirEntry> {
        let files = self.copy.parent().and_then(|folder| std::fs::read_dir(folder).ok());
        files.into_iter().flatten().flatten().filter(move |entry| {
            let path = entry.path();
            is_copy_name(&path, ending) && path.file_stem() != self.copy.file_stem()
        })
    }

    /// Recent projects and parts that still exist, latest first.
    pub fn recents(&self) -> Vec<PathBuf> {
        let text = text_of(&self.list());
        let paths: Vec<PathBuf> = serde_json::from_str(&text).unwrap_or_default();
        paths.into_iter().filter(|path| path.is_file()).take(MAX_RECENTS).collect()
    }

    /// Moves a project or part to the front of the recent files; returns the list.
    pub fn note_recent(&self, path: &Path) -> Vec<PathBuf> {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let mut recents = self.recents();
        recents.retain(|known| *known != path);
        recents.insert(0, path);
        recents.truncate(MAX_RECENTS);
        let text = serde_json::to_string_pretty(&recents).unwrap_or_default();
        let _ = std::fs::create_dir_all(&self.folder);
        // A failure is ignored: the list is a convenience.
        let _ = write_atomically(&self.list(), text.as_bytes());
        recents
    }

    /// Stored preferences; the defaults where there are none or they cannot be read.
    pub fn preferences(&self) -> Preferences {
        let text = text_of(&self.folder.join(HABITS));
        serde_json::from_str(&text).unwrap_or_default()
    }

    /// Stores the preferences.
    pub fn store_preferences(&self, habits: &Preferences) {
        let text = serde_json::to_string_pretty(habits).unwrap_or_default();
        let _ = std::fs::create_dir_all(&self.folder);
        // On failure the preferences last until the window closes.
        let _ = write_atomically(&self.folder.join(HABITS), text.as_bytes());
    }

    /// Stored layout of the panels; `None` where there is none that can be read.
    pub fn layout(&self) -> Option<Layout> {
        Layout::read(&text_of(&self.folder.join(LAYOUT)))
    }

    /// Stores the layout of the panels.
    pub fn store_layout(&self, layout: &Layout) {
        let _ = std::fs::create_dir_all(&self.folder);
        // On failure the layout lasts until the window closes.
        let _ = write_atomically(&self.folder.join(LAYOUT), layout.write().as_bytes());
    }

    fn list(&self) -> PathBuf {
        self.folder.join("recent.json")
    }
}

/// Whether a file is named as recovery copies are: what a user saved among them is none.
fn is_copy_name(path: &Path, ending: &str) -> bool {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let numbers = stem.split_once('-').is_some_and(|(process, time)| {
        [process, time].iter().all(|part| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit()))
    });
    numbers && path.extension().is_some_and(|extension| extension == ending)
}

/// How exactly the age of a recovery copy is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Age {
    InWords,
    /// Of several copies with the same name and age.
    ToTheSecond,
}

/// What is read of a recovery copy.
struct LeftCopy {
    path: PathBuf,
    /// Of its project, or else its part.
    name: String,
    /// Time since it was written.
    age: Duration,
    /// File of its project, if that has one.
    project: Option<PathBuf>,
    /// File of its part; `None` for samples.
    part: Option<PathBuf>,
}

impl LeftCopy {
    /// Reads the copy at `path`; one that cannot be read is known by its own name.
    fn read(path: PathBuf) -> Self {
        let stem = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let age = std::fs::metadata(&path).ok().and_then(|data| data.modified().ok()?.elapsed().ok());
        let (name, project, part) = match read_project(&path) {
            Err(_) => (stem(&path), None, None),
            Ok(Project { original, part, .. }) => {
                let (part_name, part) = match part {
                    PartLocation::Sample(name) => (name, None),
                    PartLocation::File(file) | PartLocation::Mesh { file, .. } => (stem(&file), Some(file)),
                };
                (original.as_deref().map_or(part_name, stem), original, part)
            }
        };
        Self { path, name, age: age.unwrap_or_default(), project, part }
    }

    /// What a user knows it by.
    fn title(&self, exactness: Age) -> String {
        format!("{}, {}", self.name, age_in_words(self.age, exactness))
    }

    fn offered(self, exactness: Age) -> RecoveryCopy {
        let title = self.title(exactness);
        RecoveryCopy { path: self.path, name: self.name, title, project: self.project, part: self.part }
    }
}

fn age_in_words(age: Duration, exactness: Age) -> String {
    const HOUR_S: u64 = 3600;
    match age.as_secs() {
        s if exactness == Age::ToTheSecond && s < 60 => format!("{s} s ago"),
        s if exactness == Age::ToTheSecond && s < 48 * HOUR_S => {
            format!("{} h {} min {} s ago", s / HOUR_S, s / 60 % 60, s % 60)
        }
        s if s < 60 => "just now".to_owned(),
        s if s < 2 * HOUR_S => format!("{} min ago", s / 60),
        s if s < 48 * HOUR_S => format!("{} h ago", s / HOUR_S),
        s => format!("{} days ago", s / (24 * HOUR_S)),
    }
}

/// Whether a file was written longer ago than `age`.
fn is_older(path: &Path, age: Duration) -> bool {
    let written = std::fs::metadata(path).and_then(|data| data.modified()).ok();
    written.and_then(|time| time.elapsed().ok()).is_some_and(|elapsed| elapsed > age)
}

/// Removes the recovery copy at `path` of another session, with its lock.
pub fn remove_copy(path: &Path) {
    // Either may be gone already.
    let _ = std::fs::remove_file(path);
    let _ = std::fs::remove_file(lock_of(path));
}

/// The file that is locked while the session of the recovery copy `copy` runs.
fn lock_of(copy: &Path) -> PathBuf {
    let home = copy.parent().and_then(Path::parent).unwrap_or(Path::new(""));
    home.join("locks").join(copy.file_stem().unwrap_or_default()).with_extension("lock")
}

/// The text of a small file of our own; empty where it cannot be read.
fn text_of(path: &Path) -> String {
    let text = read_bytes(path).ok().and_then(|bytes| String::from_utf8(bytes).ok());
    text.unwrap_or_default()
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "tests make their own files")]
mod tests {
    use super::*;

    #[test]
    fn copies_of_sessions_that_ended_badly_are_found_and_no_others() {
        let folder = tempfile::tempdir().expect("a folder");
        let home = Home::new(folder.path().to_owned());
        home.write_copy("mine").expect("writes");
        assert!(home.recovery_copies().is_empty(), "its own is in use");
        let recovery = folder.path().join("recovery");
        std::fs::write(recovery.join("4194304999-1.vanecut"), "crashed").expect("writes");
        let other = Home::new(folder.path().to_owned());
        other.write_copy("of another session, which runs").expect("writes");
        std::fs::write(recovery.join("notes.txt"), "of somebody").expect("writes");
        std::fs::write(recovery.join("wheel-2.vanecut"), "a project saved here").expect("writes");
        assert_eq!(home.recovery_copies(), [recovery.join("4194304999-1.vanecut")]);
        // Killed: the lock goes with the session, whatever its file.
        let killed = other.copy().to_owned();
        drop(other);
        assert!(home.recovery_copies().contains(&killed), "offered at once");
        remove_copy(&killed);
        assert!(!killed.exists());
        home.drop_copy();
        assert!(!home.copy().exists());
    }

    #[test]
    fn locks_that_a_killed_session_left_are_removed_and_no_others() {
        let folder = tempfile::tempdir().expect("a folder");
        let home = Home::new(folder.path().to_owned());
        home.write_copy("mine").expect("writes");
        let locks = folder.path().join("locks");
        let lock = |name: &str, is_old: bool| {
            let path = locks.join(name);
            let file = std::fs::File::create(&path).expect("makes");
            let age = if is_old { 2 * LEFT_LOCK } else { Duration::ZERO };
            file.set_modified(SystemTime::now() - age).expect("dates");
            path
        };
        let (left, new) = (lock("7-1.lock", true), lock("project-7.lock", false));
        let (recoverable, held) = (lock("7-2.lock", true), lock("project-8.lock", true));
        std::fs::write(folder.path().join("recovery/7-2.vanecut"), "crashed").expect("writes");
        let file = std::fs::File::open(&held).expect("opens");
        file.try_lock().expect("locks");
        home.sweep_locks();
        assert!(!left.exists(), "of a session without a copy");
        assert!(new.exists() && recoverable.exists() && held.exists() && lock_of(home.copy()).exists());
    }

    #[test]
    fn a_project_is_held_by_one_window_at_a_time() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.vanecut");
        std::fs::write(&path, "x").expect("writes");
        let home = || Home::new(folder.path().join("home"));
        let held = home().hold_project(&path);
        assert!(matches!(held, LockTry::Held(_)), "{held:?}");
        let same = folder.path().join("home/../a.vanecut");
        assert!(matches!(home().hold_project(&same), LockTry::HeldElsewhere), "the same file by another way");
        let other = home().hold_project(&folder.path().join("b.vanecut"));
        assert!(matches!(other, LockTry::Held(_)), "{other:?}");
        drop(held);
        assert!(matches!(home().hold_project(&path), LockTry::Held(_)), "closed there, free here");
    }

    #[test]
    fn ages_are_in_the_unit_that_is_read_best() {
        for (seconds, words) in [
            (5, "just now"),
            (90, "1 min ago"),
            (7_199, "119 min ago"),
            (7_200, "2 h ago"),
            (200_000, "2 days ago"),
        ] {
            assert_eq!(age_in_words(Duration::from_secs(seconds), Age::InWords), words);
        }
    }

    #[test]
    fn recents_are_in_order_without_doubles_and_without_those_that_are_gone() {
        let folder = tempfile::tempdir().expect("a folder");
        let home = Home::new(folder.path().join("home"));
        let file = |name: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, "x").expect("writes");
            path
        };
        let (a, b) = (file("a.vanecut"), file("b.vanecut"));
        home.note_recent(&a);
        home.note_recent(&b);
        assert_eq!(home.note_recent(&a), [a.clone(), b.clone()]);
        std::fs::remove_file(&b).expect("removes");
        assert_eq!(home.recents(), [a]);
    }
}
