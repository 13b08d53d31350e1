//! What the words of a program mean for the path of its cutter.

/// What a statement is to the reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// It says nothing of the path.
    Aside,
    /// It moves the cutter, or all that comes after it, in a way that is not followed; with what to do.
    Moves(&'static str),
    /// It sends the cutter to a place that the program does not give.
    Away,
    /// It is not known.
    Unknown,
}

const ARC: &str = "export the path as straight moves, GOTO alone";
const CYCLE: &str = "export drilling cycles as single moves";
const REPEAT: &str = "export the program with all repetitions written out";
const FRAME: &str = "export all positions in the coordinates of the part";
const CONTOUR: &str = "process the program first: only cutter locations are read";

/// The meaning of a word that the reader does not act upon; `list` are the words after its `/`.
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
