// SPDX-License-Identifier: MIT
// The polygon fill of the notes (13.1 to 14.3, 17) in binary64, written from its description: the witness of `--fill notes`.
// Shares no code with the passes. `corrected`: errata A4 to A7; else as printed, but for the misnamed variable of A6.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace plumb::golden {

struct NotesCorner {
    double x, y;                 // display, rounded to whole pixels
    std::vector<double> values;  // Z first, then what else is interpolated
};

struct NotesEdge {
    double x, yStart, yEnd, dx;
    std::vector<double> values, steps;
    size_t from, to;  // corners: start and end
};

struct NotesLine {
    double y, leftX, rightX;
    std::vector<double> left, right;
};

// Horizontal edges are dropped; sorted by Ystart, ties as they come.
inline std::vector<NotesEdge> notesFillTable(const std::vector<NotesCorner>& polygon) {
    std::vector<NotesEdge> table;
    for (size_t i = 0; i < polygon.size(); ++i) {
        size_t from = i, to = (i + 1) % polygon.size();
        if (polygon[from].y == polygon[to].y) continue;
        if (polygon[from].y > polygon[to].y) std::swap(from, to);
        const NotesCorner &a = polygon[from], &b = polygon[to];
        const double lines = b.y - a.y;
        NotesEdge e{a.x, a.y, b.y, (b.x - a.x) / lines, a.values, {}, from, to};
        for (size_t k = 0; k < a.values.size(); ++k) e.steps.push_back((b.values[k] - a.values[k]) / lines);
        table.push_back(e);
    }
    std::stable_sort(table.begin(), table.end(), [](const NotesEdge& a, const NotesEdge& b) { return a.yStart < b.yStart; });
    return table;
}

inline std::vector<NotesLine> notesLines(const std::vector<NotesEdge>& table, bool corrected) {
    std::vector<NotesLine> lines;
    if (table.empty()) return lines;
    double last = table[0].yEnd;
    for (const NotesEdge& e : table) last = std::max(last, e.yEnd);
    struct Active {
        size_t edge;
        double x;
        std::vector<double> values;
    };
    const auto start = [&](size_t i) { return Active{i, table[i].x, table[i].values}; };
    const auto step = [&](Active& a) {
        a.x += table[a.edge].dx;
        for (size_t k = 0; k < a.values.size(); ++k) a.values[k] += table[a.edge].steps[k];
    };
    Active i = start(0), j = start(1);
    size_t next = 2;
    for (double y = table[0].yStart; y <= last; ++y) {
        const Active &left = i.x < j.x ? i : j, &right = i.x < j.x ? j : i;
        lines.push_back({y, left.x, right.x, left.values, right.values});
        step(i);
        step(j);
        for (Active* a : {&i, &j})
            if (y >= table[a->edge].yEnd && y < last) {
                *a = start(next++);
                if (corrected) step(*a);  // Xstart belongs to the line that is painted already
            }
    }
    return lines;
}

// X runs LeftX, LeftX + 1, ... <= RightX. Counted, not summed: where a sum passes a power of two it may round past an end.
inline int notesPixels(const NotesLine& line) { return int(std::floor(line.rightX - line.leftX)) + 1; }

}  // namespace plumb::golden
