//! The `vanecut` binary.

fn main() -> std::process::ExitCode {
    vanecut::cli::main()
}
