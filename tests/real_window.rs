//! End-to-end test: the program on a virtual X screen, driven by key and mouse events. Needs Xvfb, xdotool
//! and a Vulkan driver.

#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests make and read their own files")]

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

struct Stopped(Child);

impl Drop for Stopped {
    fn drop(&mut self) {
        // The process may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn is_there(program: &str) -> bool {
    let found = Command::new("which").arg(program).stdout(Stdio::null()).stderr(Stdio::null()).status();
    found.is_ok_and(|status| status.success())
}

/// What takes longer hangs, on however busy a machine.
const HANG: Duration = Duration::from_secs(300);

fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < HANG, "no {what}");
        std::thread::sleep(Duration::from_millis(200));
    }
}

/// A virtual screen.
struct Screen {
    display: String,
    _server: Stopped,
}

impl Screen {
    /// The server picks a free number and prints it as soon as clients may connect. Without `-noreset` it
    /// starts anew whenever its last client leaves, and refuses connections meanwhile.
    fn new() -> Self {
        for (program, package) in [("Xvfb", "xvfb"), ("xdotool", "xdotool")] {
            assert!(
                is_there(program),
                "{program} is not installed; install {package} (`scripts/setup screen` does), or leave this test \
                 out: `scripts/test -- --skip on_a_real_screen`"
            );
        }
        let mut server = Stopped(
            Command::new("Xvfb")
                .args(["-displayfd", "1", "-noreset", "-screen", "0", "1280x800x24", "-nolisten", "tcp"])
                .stdout(Stdio::piped())
                .stderr(Stdio::null())
                .spawn()
                .expect("Xvfb starts"),
        );
        let mut number = String::new();
        let printed = server.0.stdout.take().expect("the output of Xvfb");
        BufReader::new(printed).read_line(&mut number).expect("the number of the display");
        Self { display: format!(":{}", number.trim()), _server: server }
    }

    /// Starts the program with the sample pump6, its data in `folder`.
    fn start(&self, folder: &Path) -> Stopped {
        self.start_with_path(folder, &std::env::var("PATH").unwrap_or_default())
    }

    /// The same with another list of the folders of programs.
    fn start_with_path(&self, folder: &Path, path: &str) -> Stopped {
        let part = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/parts/pump6.toml");
        let program = Command::new(env!("CARGO_BIN_EXE_vanecut"))
            .arg(part)
            // What is written by a name without a folder goes there.
            .current_dir(folder)
            .env("DISPLAY", &self.display)
            .env("PATH", path)
            // No portal of the machine shows its dialogs.
            .env("DBUS_SESSION_BUS_ADDRESS", "unix:path=/no-such-bus")
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .env("XDG_DATA_HOME", folder)
            .env("XDG_RUNTIME_DIR", folder)
            .env("VANECUT_GPU", "software")
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        Stopped(program)
    }

    /// Title and id of the window of the program.
    fn title(&self) -> Option<(String, String)> {
        let window = self.xdotool(&["search", "--onlyvisible", "--name", "Vanecut"])?;
        let window = window.lines().next()?.to_owned();
        Some((self.xdotool(&["getwindowname", &window])?, window))
    }

    /// Id of the window of `program`, once it has the part.
    fn window_with_part(&self, program: &mut Stopped) -> String {
        let (_, window) = until("window with the part", || {
            if let Ok(Some(status)) = program.0.try_wait() {
                let mut errors = String::new();
                let _ = program.0.stderr.take().map(|mut pipe| pipe.read_to_string(&mut errors));
                panic!("the program ended, {status}: {errors}");
            }
            self.title().filter(|(name, _)| name.contains("pump6"))
        });
        window
    }

    fn xdotool(&self, arguments: &[&str]) -> Option<String> {
        let output = Command::new("xdotool").args(arguments).env("DISPLAY", &self.display).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    }
}

#[test]
fn keys_and_mouse_reach_the_program_on_a_real_screen() {
    let folder = tempfile::tempdir().expect("a folder");
    let screen = Screen::new();
    let mut program = screen.start(folder.path());
    let window = screen.window_with_part(&mut program);
    // Edit something to mark the project unsaved: Ctrl+D saves a variant.
    screen.xdotool(&["windowfocus", &window]);
    screen.xdotool(&["mousemove", "640", "400"]);
    until("mark of something unsaved", || {
        screen.xdotool(&["key", "--window", &window, "ctrl+d"]);
        std::thread::sleep(Duration::from_millis(500));
        screen.title().filter(|(name, _)| name.contains('•'))
    });
    // A drag rotates the wheel, and the program keeps running.
    for arguments in [
        &["mousedown", "1"][..],
        &["mousemove", "720", "430"],
        &["mousemove", "760", "440"],
        &["mouseup", "1"],
    ] {
        screen.xdotool(arguments);
    }
    if is_there("import") {
        let picture = folder.path().join("window.png");
        let taken = Command::new("import")
            .args(["-window", "root"])
            .arg(&picture)
            .env("DISPLAY", &screen.display)
            .status()
            .is_ok_and(|status| status.success());
        assert!(
            taken && std::fs::metadata(&picture).is_ok_and(|data| data.len() > 20_000),
            "a picture of the window"
        );
        if let Some(keep) = std::env::var_os("VANECUT_SCREENSHOT") {
            std::fs::copy(&picture, keep).expect("the picture is kept");
        }
    }
    assert!(matches!(program.0.try_wait(), Ok(None)), "the program still runs");
    // An idle program uses less than a tenth of one core.
    until("rest", || {
        let before = ticks(program.0.id())?;
        std::thread::sleep(Duration::from_secs(3));
        let used = ticks(program.0.id())? - before;
        (used < 30).then_some(())
    });
}

/// A dialog of the system that is slow to come takes no keys yet, and the window no more.
#[test]
fn keys_before_a_file_dialog_comes_change_nothing_on_a_real_screen() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a folder");
    let zenity = folder.path().join("zenity");
    // It ends with the test, or after a minute.
    let script = "#!/bin/sh\ntouch asked\nn=0\nwhile [ $n -lt 600 ] && [ ! -e go ]; do sleep 0.1; n=$((n + 1)); done\nexit 1\n";
    std::fs::write(&zenity, script).expect("writes");
    std::fs::set_permissions(&zenity, std::fs::Permissions::from_mode(0o755)).expect("a program");
    let path = format!("{}:{}", folder.path().display(), std::env::var("PATH").unwrap_or_default());
    let screen = Screen::new();
    let mut program = screen.start_with_path(folder.path(), &path);
    let window = screen.window_with_part(&mut program);
    let key = |keys: &str| screen.xdotool(&["key", "--window", &window, keys]);
    screen.xdotool(&["windowfocus", &window]);
    screen.xdotool(&["mousemove", "640", "400"]);
    until("dialog", || {
        key("ctrl+o");
        std::thread::sleep(Duration::from_millis(500));
        folder.path().join("asked").exists().then_some(())
    });
    std::thread::sleep(Duration::from_millis(1500));
    key("ctrl+d");
    std::thread::sleep(Duration::from_secs(2));
    let (title, _) = screen.title().expect("a title");
    assert!(!title.contains('•'), "no variant is saved while the dialog is awaited: {title}");
    // Given up, the keys are those of the window.
    until("mark of something unsaved", || {
        key("Escape");
        key("ctrl+d");
        std::thread::sleep(Duration::from_millis(500));
        screen.title().filter(|(name, _)| name.contains('•'))
    });
    std::fs::write(folder.path().join("go"), "").expect("writes");
}

/// CPU time of a process so far, in hundredths of a second.
fn ticks(process: u32) -> Option<u64> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
    Some(fields.get(11)?.parse::<u64>().ok()? + fields.get(12)?.parse::<u64>().ok()?)
}

/// Kills the program at random moments while someone edits, as `kill -9` does: every edit older than two
/// seconds is in its recovery copy. `KILL_MOMENTS` and `KILL_SEED` set how often, and when.
#[test]
#[ignore = "takes fifteen seconds a moment; scripts/nightly runs it"]
fn edits_survive_a_kill_on_a_real_screen() {
    let (moments, seed) = (number("KILL_MOMENTS", 20), number("KILL_SEED", 1));
    let mut random = Random(seed);
    let screen = Screen::new();
    let mut lost = Vec::new();
    for moment in 0..moments {
        let folder = tempfile::tempdir().expect("a folder");
        let mut program = screen.start(folder.path());
        let window = screen.window_with_part(&mut program);
        screen.xdotool(&["windowfocus", &window]);
        // An edit of one key, which cannot go half astray: each saves the setup as another variant.
        let edit = || screen.xdotool(&["key", "ctrl+d"]);
        until("mark of something unsaved", || {
            edit();
            std::thread::sleep(Duration::from_millis(500));
            screen.title().filter(|(name, _)| name.contains('•'))
        });
        // The first plan ends, which takes all cores.
        screen.xdotool(&["key", "Escape", "Escape"]);
        std::thread::sleep(Duration::from_secs(3));
        let first = variants(folder.path()).expect("a copy of what was edited three seconds ago");
        let began = Instant::now();
        let life = Duration::from_millis(1500 + random.below(8000));
        // When the key of each edit was sent.
        let mut edits: Vec<Duration> = Vec::new();
        while began.elapsed() < life {
            edit();
            edits.push(began.elapsed());
            // Two in a frame would be one.
            std::thread::sleep(Duration::from_millis(700 + random.below(700)));
        }
        program.0.kill().expect("it runs");
        let killed = began.elapsed();
        program.0.wait().expect("it ends");
        let due = edits.iter().filter(|at| killed - **at > Duration::from_secs(2)).count();
        let kept = variants(folder.path()).unwrap_or_default().saturating_sub(first);
        let count = edits.len();
        let line =
            format!("moment {moment}: killed at {killed:.1?} after {count} edits; {due} due, {kept} kept");
        println!("{line}");
        if kept < due {
            lost.push(line);
        }
    }
    assert!(lost.is_empty(), "seed {seed}: {lost:#?}");
}

/// A number of the environment.
fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).map_or(default, |text| text.parse().expect("a whole number"))
}

/// Random clicks, drags, turns of the wheel and keys: the program may be closed by them, but it does not end
/// by itself. `EVENT_COUNT` and `EVENT_SEED` set how many, and which.
#[test]
#[ignore = "takes minutes; scripts/nightly runs it"]
fn random_events_end_in_no_panic_on_a_real_screen() {
    let (count, seed) = (number("EVENT_COUNT", 3000), number("EVENT_SEED", 1));
    let mut random = Random(seed);
    let screen = Screen::new();
    let folder = tempfile::tempdir().expect("a folder");
    let (mut sent, mut starts) = (0, 0);
    while sent < count {
        let mut program = screen.start(folder.path());
        starts += 1;
        let window = screen.window_with_part(&mut program);
        screen.xdotool(&["windowfocus", &window]);
        while sent < count {
            let mut arguments = Vec::new();
            for _ in 0..10 {
                random_event(&mut random, &mut arguments);
                sent += 1;
            }
            let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            screen.xdotool(&arguments);
            if let Ok(Some(status)) = program.0.try_wait() {
                let mut errors = String::new();
                let _ = program.0.stderr.take().map(|mut pipe| pipe.read_to_string(&mut errors));
                assert!(status.success(), "seed {seed}, after {sent} events: {status}: {errors}");
                break;
            }
        }
        // It still draws: the title is answered, and a window that hangs would not take a key.
        if matches!(program.0.try_wait(), Ok(None)) {
            until("answer of the window", || screen.title());
        }
        println!("{sent} events, start {starts}");
    }
}

/// Adds the arguments of an event for xdotool.
fn random_event(random: &mut Random, arguments: &mut Vec<String>) {
    const KEYS: [&str; 34] = [
        "Tab",
        "Return",
        "Escape",
        "space",
        "BackSpace",
        "Left",
        "Right",
        "Up",
        "Down",
        "F1",
        "F5",
        "F6",
        "F7",
        "b",
        "n",
        "k",
        "g",
        "a",
        "m",
        "p",
        "1",
        "4",
        "7",
        "period",
        "minus",
        "ctrl+z",
        "ctrl+y",
        "ctrl+d",
        "ctrl+k",
        "ctrl+plus",
        "ctrl+minus",
        "ctrl+0",
        "ctrl+a",
        "Delete",
    ];
    let place = [random.below(1280).to_string(), random.below(800).to_string()];
    let mut push = |words: &[&str]| arguments.extend(words.iter().map(|word| (*word).to_owned()));
    push(&["mousemove", &place[0], &place[1]]);
    match random.below(10) {
        0..4 => push(&["click", "1"]),
        4 => push(&["click", "3"]),
        5 => push(&["click", "--repeat", "3", if random.below(2) == 0 { "4" } else { "5" }]),
        6 => {
            let to = [random.below(1280).to_string(), random.below(800).to_string()];
            push(&["mousedown", "1", "mousemove", &to[0], &to[1], "mouseup", "1"]);
        }
        _ => push(&["key", KEYS[random.below(KEYS.len() as u64) as usize]]),
    }
}

/// Number of variants in the recovery copy below `folder`.
fn variants(folder: &Path) -> Option<usize> {
    let copies = std::fs::read_dir(folder.join("vanecut/recovery")).ok()?;
    let mut copies = copies.flatten().map(|entry| entry.path());
    let copy = copies.find(|path| path.extension().is_some_and(|ending| ending == "vanecut"))?;
    Some(vanecut::io::project_file::read_project(&copy).expect("the copy opens").sets.len())
}

/// Random numbers (SplitMix64): the same in each run with one seed.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (x ^ (x >> 31)) % limit
    }
}
