# Sourced by the other scripts, with `here` set to the repository's root.
# shellcheck shell=sh

# rustup's cargo is there before a new shell has it on its PATH.
if ! command -v cargo >/dev/null 2>&1; then
    PATH="$PATH:${CARGO_HOME:-$HOME/.cargo}/bin"
fi
if ! command -v cargo >/dev/null 2>&1; then
    echo "cargo was not found; install Rust with rustup (https://rustup.rs), then run this again" >&2
    exit 1
fi

# Mesa complains on stderr when it has no runtime folder.
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM
if [ ! -d "${XDG_RUNTIME_DIR:-}" ]; then
    XDG_RUNTIME_DIR=$scratch
    export XDG_RUNTIME_DIR
fi

# Builds the release binary and sets `vanecut` to its path.
build_release() {
    "$here/scripts/setup" build
    (cd "$here" && cargo build --release --locked)
    target=${CARGO_TARGET_DIR:-$here/target}
    vanecut=$target/release/vanecut
}

# The parts that tables and pictures are made of, one a line: the samples, and the wheels from other hands.
measured_parts() {
    printf '%s\n' "$here"/assets/parts/*.toml
    measured_wheels
}
measured_wheels() {
    printf '%s\n' "$here"/tests/data/wheels/hecc.toml "$here"/tests/data/wheels/kj66_sections.toml \
        "$here"/tests/data/wheels/paraturbo.glb
}

# What a mesh file does not say itself.
mesh_options() {
    case $1 in
    *paraturbo.glb) echo --blades 9 --unit mm ;;
    esac
}

# Puts the Markdown in file $2 into page $3, between "<!-- $1 begin…" and "<!-- $1 end -->".
put_table() {
    awk -v name="$1" -v table="$2" '
        index($0, "<!-- " name " end -->") { skip = 0 }
        !skip { print }
        index($0, "<!-- " name " begin") { skip = 1; while ((getline line < table) > 0) print line }
    ' "$3" >"$scratch/page"
    cat "$scratch/page" >"$3"
}
