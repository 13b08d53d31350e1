//! Classification of APT words by their effect on the path of the cutter.

/// Effect of a statement that the reader does not apply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// It does not affect the path.
    Aside,
    /// It moves the cutter or transforms what follows, and is not supported; with what to do.
    Moves(&'static str),
    /// It moves the cutter to a position that the program does not give.
    Away,
    /// The word is unknown.
    Unknown,
}

const ARC: &str = "export the path as straight moves, GOTO alone";
const CYCLE: &str = "export drilling cycles as single moves";
const REPEAT: &str = "export the program with all repetitions written out";
const FRAME: &str = "export all positions in the coordinates of the part";
const CONTOUR: &str = "process the program first: only cutter locations are read";

/// Classifies a word that the reader does not apply; `list` has the words after its `/`.
pub(super) fn meaning(word: &str, list: &[String]) -> Meaning {
    let has = |name: &str| list.iter().any(|w| w == name);
    let off = has("OFF") || has("NOMORE");
    match word {
        "" | "MULTAX" | "COOLNT" | "TOOL PATH" | "MACHIN" | "INTOL" | "OUTTOL" | "TOLER" | "CLPRNT"
        | "NOPOST" | "STOP" | "OPSTOP" | "END" | "LOAD" | "SELECT" | "UNLOAD" | "DELAY" | "SEQNO"
        | "CHECK" | "DISPLY" | "PAINT" | "PRINT" | "AUTOPS" | "CLAMP" | "LEADER" | "REWIND" | "TITLES"
        | "CUTTER" | "PPFUN" | "SYN" | "CLEARP" | "MSYS" => Meaning::Aside,
        "CIRCLE" | "MOVARC" | "ARCSLP" | "ARCMOV" | "THREAD" | "SPLINE" | "NURBS" => Meaning::Moves(ARC),
        "CYCLE" if off => Meaning::Aside,
        "CYCLE" | "POCKET" | "DRILL" => Meaning::Moves(CYCLE),
        "COPY" | "INDEX" | "LOOPST" | "LOOPND" | "JUMPTO" | "CALL" | "MACRO" | "TERMAC" | "PATERN" => {
            Meaning::Moves(REPEAT)
        }
        "CUTCOM" if off => Meaning::Aside,
        "MODE" | "SET" if !has("INCR") => Meaning::Aside,
        "REFSYS" | "MIRROR" | "SCALE" | "ROTABL" | "ROTATE" | "ROTHED" | "ORIGIN" | "CUTCOM" | "MODE"
        | "SET" => Meaning::Moves(FRAME),
        "GO" | "GOFWD" | "GOBACK" | "GOLFT" | "GORGT" | "GOUP" | "GODOWN" | "INDIRV" | "INDIRP" | "PSIS"
        | "TLON" | "TLLFT" | "TLRGT" => Meaning::Moves(CONTOUR),
        "GOHOME" | "RETRCT" => Meaning::Away,
        _ => Meaning::Unknown,
    }
}
