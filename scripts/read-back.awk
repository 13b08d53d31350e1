# Compares what `vanecut verify --json` says of an APT program (first file) and of the NC program posted from it (second
# file), and the latter's time with that of `vanecut post --json` (third file). Prints what differs; ends with 1 then.
# -v output=… is the output of the post.

# Reads the scalars of an object into values[number, key], and counts the kinds of its faults in kinds[number, kind].
function read_object(text, number,    depth, place, character, key, word, in_faults, is_value, kind) {
    depth = 0; word = ""; is_value = 0; in_faults = 0
    for (place = 1; place <= length(text); place++) {
        character = substr(text, place, 1)
        if (character == "\"") {
            word = ""
            while (++place <= length(text) && (character = substr(text, place, 1)) != "\"") {
                if (character == "\\") character = substr(text, ++place, 1)
                word = word character
            }
        } else if (character == "{" || character == "[") {
            if (depth == 1 && key == "faults") in_faults = 1
            depth++; is_value = 0; word = ""
        } else if (character == ":") {
            key = word; word = ""; is_value = 1
        } else if (character == "," || character == "}" || character == "]") {
            if (is_value && depth == 1) values[number, key] = word
            if (is_value && in_faults && depth == 3 && key == "kind") { kinds[number, word]++; known[word] = 1 }
            is_value = 0; word = ""
            if (character != ",") { depth--; if (depth == 1) in_faults = 0 }
        } else if (character !~ /[ \n]/) word = word character
    }
}

function report(text) { print text; bad = 1 }

# Reports a figure that differs by more than `limit`.
function compare(key, limit,    a, b) {
    a = values[1, key]; b = values[2, key]
    if (a == b) return
    if (a == "null" || b == "null" || a - b > limit || b - a > limit) report(key " " a " -> " b)
}

function size(key) { return values[1, key] < 0 ? -values[1, key] : values[1, key] + 0 }

{ read_object($0, FILENAME == ARGV[1] ? 1 : FILENAME == ARGV[2] ? 2 : 3) }

END {
    curves = values[1, "kind"] != "plunge"
    for (kind in known) {
        if (kinds[1, kind] + 0 != kinds[2, kind] + 0) report(kind " " kinds[1, kind] + 0 " -> " kinds[2, kind] + 0)
    }
    compare("channels", 0)
    compare("residual_mean", 1e-3)
    compare("residual_p95", curves ? 5e-3 : 1e-3)
    compare("uncut_share", 1e-3)
    compare("unreachable_share", 1e-3)
    compare("uncovered_share", 1e-3)
    compare("min_hub_clearance", curves ? 2e-3 : 2e-4)
    compare("min_blade_clearance", curves ? 2e-3 : 2e-4)
    compare("cut_length", (curves ? 1e-4 : 1e-5) * size("cut_length"))
    if (curves) {
        compare("max_overcut", 1e-3)
        compare("max_undercut", 5e-3)
        compare("unmilled_wall_share", 1e-3)
        if (output != "joints") compare("feed_time", 1e-3 * size("feed_time"))
    } else {
        compare("positions", 0)
        compare("interferential", 0)
        compare("max_contact_depth", 2e-3)
        compare("residual_max", 8e-3)
        compare("max_axis_change", 1e-3)
        compare("feed_time", 1e-3 * size("feed_time"))
    }
    # Links that leave the part go further from it.
    if (values[2, "min_retract_clearance"] < values[1, "min_retract_clearance"] - (curves ? 0.05 : 1e-3)) {
        compare("min_retract_clearance", 0)
    }
    if (output == "tcp-angles" || output == "joints") {
        time = values[3, "time"]; read = values[2, "machine_time"]
        limit = (curves && output == "joints" ? 5e-3 : 1e-3) * time
        if (!(read - time <= limit && time - read <= limit)) report("time of post " time ", read back " read)
    }
    exit bad
}
