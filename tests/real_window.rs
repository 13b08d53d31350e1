//! End-to-end test: the program on a virtual X screen, driven by key and mouse events. Needs Xvfb, xdotool
//! and a Vulkan driver.

#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests make and read their own files")]

use std::io::{BufRead, BufReader, Read};
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

fn xdotool(display: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new("xdotool").args(arguments).env("DISPLAY", display).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
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

#[test]
fn keys_and_mouse_reach_the_program_on_a_real_screen() {
    for (program, package) in [("Xvfb", "xvfb"), ("xdotool", "xdotool")] {
        assert!(
            is_there(program),
            "{program} is not installed; install {package} (`scripts/setup screen` does), or leave this test \
             out: `scripts/test -- --skip on_a_real_screen`"
        );
    }
    let folder = tempfile::tempdir().expect("a folder");
    // The server picks a free number and prints it as soon as clients may connect. Without `-noreset` it starts
    // anew whenever its last client leaves, and refuses connections meanwhile.
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
    let display = format!(":{}", number.trim());
    let part = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/parts/pump6.toml");
    let program = Command::new(env!("CARGO_BIN_EXE_vanecut"))
        .arg(part)
        .env("DISPLAY", &display)
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .env("XDG_DATA_HOME", folder.path())
        .env("XDG_RUNTIME_DIR", folder.path())
        .env("VANECUT_GPU", "software")
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut program = Stopped(program);
    let title = |display: &str| {
        let window = xdotool(display, &["search", "--onlyvisible", "--name", "Vanecut"])?;
        let window = window.lines().next()?.to_owned();
        Some((xdotool(display, &["getwindowname", &window])?, window))
    };
    let (_, window) = until("window with the part", || {
        if let Ok(Some(status)) = program.0.try_wait() {
            let mut errors = String::new();
            let _ = program.0.stderr.take().map(|mut pipe| pipe.read_to_string(&mut errors));
            panic!("the program ended, {status}: {errors}");
        }
        title(&display).filter(|(name, _)| name.contains("pump6"))
    });
    // Edit something to mark the project unsaved: Ctrl+D saves a variant.
    xdotool(&display, &["windowfocus", &window]);
    xdotool(&display, &["mousemove", "640", "400"]);
    until("mark of something unsaved", || {
        xdotool(&display, &["key", "--window", &window, "ctrl+d"]);
        std::thread::sleep(Duration::from_millis(500));
        title(&display).filter(|(name, _)| name.contains('•'))
    });
    // A drag rotates the wheel, and the program keeps running.
    for arguments in [
        &["mousedown", "1"][..],
        &["mousemove", "720", "430"],
        &["mousemove", "760", "440"],
        &["mouseup", "1"],
    ] {
        xdotool(&display, arguments);
    }
    if is_there("import") {
        let picture = folder.path().join("window.png");
        let taken = Command::new("import")
            .args(["-window", "root"])
            .arg(&picture)
            .env("DISPLAY", &display)
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

/// CPU time of a process so far, in hundredths of a second.
fn ticks(process: u32) -> Option<u64> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
    Some(fields.get(11)?.parse::<u64>().ok()? + fields.get(12)?.parse::<u64>().ok()?)
}
