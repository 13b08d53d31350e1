//! Opens the window.
fn main() {
    if let Err(e) = vanecut::app::run(std::env::args_os().nth(1).map(Into::into)) {
        eprintln!("vanecut: {e}");
        std::process::exit(1);
    }
}
