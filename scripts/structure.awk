# Draws the graph that scripts/structure finds as SVG: rows of boxes, each above all it uses.
# Rows by the longest path to the bottom, order in a row by barycentres (Sugiyama), arrows that follow from others
# left out. A long arrow runs through a point in each row between its ends.

BEGIN {
    WIDTH = 196; HEIGHT = 66; LANE = 26; GAP = 22; ROW = 112; MARGIN = 20; LINE = 34
}

$1 == "module" {
    name[++count] = $2; number[$2] = count
    $1 = $2 = ""; sub(/^ +/, ""); sub(/[:;(].*/, ""); sub(/,? *$/, "")
    purpose[count] = $0
}
$1 == "uses" && $2 != $3 { from[++uses] = $2; to[uses] = $3 }

END {
    for (k = 1; k <= uses; k++)
        if (from[k] in number && to[k] in number) edge[number[from[k]], number[to[k]]] = 1
    reduce(); set_rows(); add_lanes(); order(); place(); draw()
}

# Leaves out each arrow whose end is reached by another way.
function reduce(   i, j, k) {
    for (i = 1; i <= count; i++) for (j = 1; j <= count; j++) reach[i, j] = (i, j) in edge
    for (k = 1; k <= count; k++) for (i = 1; i <= count; i++) if (reach[i, k])
        for (j = 1; j <= count; j++) if (reach[k, j]) reach[i, j] = 1
    for (i = 1; i <= count; i++) for (j = 1; j <= count; j++) if ((i, j) in edge)
        for (k = 1; k <= count; k++) if (k != j && ((i, k) in edge) && reach[k, j]) { cut[i, j] = 1; break }
    for (k in cut) delete edge[k]
}

# Row 0 is the bottom. Modules come in an order in which each uses only those before it.
function set_rows(   i, j, least) {
    for (i = 1; i <= count; i++) {
        row[i] = 0
        for (j = 1; j < i; j++) if ((i, j) in edge && row[j] >= row[i]) row[i] = row[j] + 1
        if (row[i] > top) top = row[i]
    }
    # What uses nothing stands just below the first that uses it.
    for (i = 1; i <= count; i++) {
        least = top + 1
        for (j = 1; j <= count; j++) {
            if ((i, j) in edge) break
            if ((j, i) in edge && row[j] < least) least = row[j]
        }
        if (j > count && least <= top) row[i] = least - 1
    }
}

# Nodes above `count` are the points of long arrows.
function add_lanes(   i, j, r, last) {
    nodes = count
    for (i = count; i >= 1; i--) for (j = count; j >= 1; j--) if ((i, j) in edge) {
        last = i
        for (r = row[i] - 1; r > row[j]; r--) { row[++nodes] = r; link(last, nodes); last = nodes }
        link(last, j); first_of[i, j] = 1
    }
    for (i = 1; i <= nodes; i++) { member[row[i], size[row[i]]++] = i }
}
function link(upper, lower) {
    down[upper, ++downs[upper]] = lower; up[lower, ++ups[lower]] = upper
}

function barycentre(node, upwards,   k, n, sum) {
    n = upwards ? ups[node] : downs[node]
    for (k = 1; k <= n; k++) sum += position[upwards ? up[node, k] : down[node, k]]
    return n ? sum / n : position[node]
}

function number_row(r,   k) { for (k = 0; k < size[r]; k++) position[member[r, k]] = (k + 0.5) / size[r] }

function sort_row(r, upwards,   k, l, node, key) {
    for (k = 0; k < size[r]; k++) key[member[r, k]] = barycentre(member[r, k], upwards)
    for (k = 1; k < size[r]; k++) {
        node = member[r, k]
        for (l = k - 1; l >= 0 && key[member[r, l]] > key[node]; l--) member[r, l + 1] = member[r, l]
        member[r, l + 1] = node
    }
    number_row(r)
}

function crossings(   r, i, j, a, b, k, l, total) {
    for (r = 1; r <= top; r++) for (i = 0; i < size[r]; i++) for (j = i + 1; j < size[r]; j++) {
        a = member[r, i]; b = member[r, j]
        for (k = 1; k <= downs[a]; k++) for (l = 1; l <= downs[b]; l++)
            if (position[down[a, k]] > position[down[b, l]]) total++
    }
    return total + 0
}

function order(   sweep, r, k, now, best) {
    for (r = 0; r <= top; r++) number_row(r)
    best = crossings()
    for (sweep = 0; sweep < 24; sweep++) {
        if (sweep % 2) for (r = 1; r <= top; r++) sort_row(r, 0)
        else for (r = top - 1; r >= 0; r--) sort_row(r, 1)
        now = crossings()
        if (now < best || !sweep) {
            best = now
            for (r = 0; r <= top; r++) for (k = 0; k < size[r]; k++) kept[r, k] = member[r, k]
        }
    }
    for (r = 0; r <= top; r++) { for (k = 0; k < size[r]; k++) member[r, k] = kept[r, k]; number_row(r) }
}

function half(node) { return (node <= count ? WIDTH : LANE) / 2 }

# Each node goes to the mean of its neighbours as far as those beside it in its row let it.
function place(   r, k, round, node, low, high, n, sum, l, want, x0) {
    for (r = 0; r <= top; r++) {
        x0 = 0
        for (k = 0; k < size[r]; k++) { node = member[r, k]; x[node] = x0 + half(node); x0 += 2 * half(node) + GAP }
        for (k = 0; k < size[r]; k++) x[member[r, k]] -= x0 / 2
    }
    for (round = 0; round < 200; round++) for (r = 0; r <= top; r++)
        for (l = 0; l < size[r]; l++) {
            k = round % 2 ? size[r] - 1 - l : l
            node = member[r, k]; sum = 0; n = ups[node] + downs[node]
            if (!n) continue
            for (want = 1; want <= ups[node]; want++) sum += x[up[node, want]]
            for (want = 1; want <= downs[node]; want++) sum += x[down[node, want]]
            want = sum / n
            low = k ? x[member[r, k - 1]] + half(member[r, k - 1]) + GAP + half(node) : -1e9
            high = k < size[r] - 1 ? x[member[r, k + 1]] - half(member[r, k + 1]) - GAP - half(node) : 1e9
            if (want < low) want = low
            if (want > high) want = high
            x[node] = want
        }
    left = 1e9; right = -1e9
    for (node = 1; node <= nodes; node++) {
        if (x[node] - half(node) < left) left = x[node] - half(node)
        if (x[node] + half(node) > right) right = x[node] + half(node)
    }
    for (node = 1; node <= nodes; node++) { x[node] += MARGIN - left; y[node] = MARGIN + (top - row[node]) * ROW }
}

# Where an arrow leaves or enters a box: beside the others there, in the order of their other ends.
function port(node, other, upwards,   k, n, before, at) {
    n = upwards ? ups[node] : downs[node]
    for (k = 1; k <= n; k++) {
        at = upwards ? up[node, k] : down[node, k]
        if (x[at] < x[other] || (x[at] == x[other] && at < other)) before++
    }
    return x[node] + (before - (n - 1) / 2) * (n > 1 ? min(26, (WIDTH - 30) / (n - 1)) : 0)
}
function min(a, b) { return a < b ? a : b }

function arrow(i, j, first,   node, below, path, px, py, qx, qy) {
    px = port(i, first, 0); py = y[i] + HEIGHT
    path = sprintf("M%.1f %.1f", px, py)
    for (node = first; ; node = below) {
        if (node == j) {
            qx = port(j, before_end, 1); qy = y[j] - 4
        } else { qx = x[node]; qy = y[node] }
        path = path sprintf("C%.1f %.1f %.1f %.1f %.1f %.1f", px, (py + qy) / 2, qx, (py + qy) / 2, qx, qy)
        if (node == j) break
        path = path sprintf("V%.1f", qy + HEIGHT)
        px = qx; py = qy + HEIGHT
        before_end = node; below = down[node, 1]
    }
    printf "<path id=\"%s-uses-%s\" d=\"%s\"/>\n", name[i], name[j], path
    tips = tips sprintf("M%.1f %.1fl-4 -7h8z", qx, qy + 4)
}

function words(text, at,   n, k, word, line, rows) {
    n = split(text, word, " "); line = word[1]
    for (k = 2; k <= n + 1; k++) {
        if (k <= n && length(line " " word[k]) <= LINE) { line = line " " word[k]; continue }
        rows = rows sprintf("<tspan x=\"%.1f\" dy=\"13\">%s</tspan>", at, line); line = word[k]
    }
    return rows
}

function draw(   i, k, node, first, fill, lines) {
    width = right - left + 2 * MARGIN; height = top * ROW + HEIGHT + 2 * MARGIN
    printf "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" width=\"%.0f\" height=\"%.0f\" ", \
        width, height, width, height
    print "font-family=\"sans-serif\" font-size=\"11\" text-anchor=\"middle\">"
    print "<title>Modules and what each uses; drawn by scripts/structure</title>"
    print "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>"
    print "<g fill=\"none\" stroke=\"#59636e\" stroke-width=\"1.2\">"
    for (i = 1; i <= count; i++) for (k = 1; k <= downs[i]; k++) {
        first = down[i, k]; before_end = i
        for (node = first; node > count; node = down[node, 1]) ;
        arrow(i, node, first)
    }
    print "</g>"
    printf "<path fill=\"#59636e\" d=\"%s\"/>\n", tips
    for (i = 1; i <= count; i++) {
        lines = words(purpose[i], x[i])
        fill = name[i] ~ /^(app|cli)$/ ? "#fdf0d5" : name[i] ~ /^(gpu|drawing)$/ ? "#e8e4f7" : "#e3eef8"
        printf "<rect x=\"%.1f\" y=\"%.1f\" width=\"%d\" height=\"%d\" rx=\"6\" fill=\"%s\" stroke=\"#59636e\"/>\n", \
            x[i] - WIDTH / 2, y[i], WIDTH, HEIGHT, fill
        printf "<text id=\"%s\" x=\"%.1f\" y=\"%.1f\"><tspan font-size=\"14\" font-weight=\"bold\">%s</tspan>%s</text>\n", \
            name[i], x[i], y[i] + 35.5 - 6.5 * gsub(/<tspan/, "&", lines), name[i], lines
    }
    print "</svg>"
}
