// SPDX-License-Identifier: MIT
#include "pipeline/scene/face_cutter.h"

#include <cstddef>
#include <cstdint>

namespace plumb {

using Point = FaceCutter::Point;

// Twice the signed area of (a, b, c): positive for a turn to the left at b.
static double turnOf(const Point& a, const Point& b, const Point& c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

FaceCutter::Outcome FaceCutter::run() {
    const uint32_t n = uint32_t(points.size());
    cuts.clear();
    bool anyRight = false, anyStraight = false;
    for (uint32_t i = 0; i < n; ++i) {
        const double turn = turnOf(points[i ? i - 1 : n - 1], points[i], points[i + 1 < n ? i + 1 : 0]);
        anyRight |= turn < 0;
        anyStraight |= turn == 0;
    }
    if (!anyRight && !anyStraight) {
        fan(n);
        return turnsOnce() ? Outcome::done : Outcome::selfCrossing;
    }
    // A straight corner needs ears rather than a fan. Cut off as a triangle without area it would leave the neighbouring face, which
    // also has that corner, with a T-junction: the background could be seen through it.
    const Outcome outcome = clipEars();
    if (outcome == Outcome::tooLarge) cuts.clear();
    if (outcome != Outcome::tooLarge || anyRight || !turnsOnce()) return outcome;
    fan(n);
    return Outcome::done;
}

void FaceCutter::fan(uint32_t corners) {
    for (uint32_t i = 1; i + 1 < corners; ++i) cuts.push_back({0, i, i + 1});
}

// True when the outline turns once. A convex outline changes its direction in x twice, and in y twice; a star whose turns are all to
// the left does so more often.
bool FaceCutter::turnsOnce() const {
    const auto changes = [&](auto coordinate) {
        int count = 0, first = 0, last = 0;
        for (size_t i = 0; i < points.size(); ++i) {
            const double step = coordinate(points[i + 1 < points.size() ? i + 1 : 0]) - coordinate(points[i]);
            const int sign = (step > 0) - (step < 0);
            if (sign == 0) continue;
            if (!first) first = sign;
            count += last && sign != last;
            last = sign;
        }
        return count + (first != last);
    };
    return changes([](const Point& p) { return p.x; }) <= 2 && changes([](const Point& p) { return p.y; }) <= 2;
}

double FaceCutter::turnAt(uint32_t i) const { return turnOf(points[before_[i]], points[i], points[after_[i]]); }

// True for an ear: a strict left turn whose triangle, border included, holds no corner that is not a strict left turn. Corners that
// coincide with the triangle's own (the bridge of a face with a hole) do not count.
bool FaceCutter::isEar(uint32_t i) {
    const Point &a = points[before_[i]], &b = points[i], &c = points[after_[i]];
    if (!(turnOf(a, b, c) > 0) || tests_ > kMaxCornerTests) return false;
    tests_ += reflex_.size();
    for (uint32_t r : reflex_) {
        const Point& p = points[r];
        if (gone_[r] || p == a || p == b || p == c) continue;
        if (turnOf(a, b, p) >= 0 && turnOf(b, c, p) >= 0 && turnOf(c, a, p) >= 0) return false;
    }
    return true;
}

void FaceCutter::cutOff(uint32_t i) {
    cuts.push_back({before_[i], i, after_[i]});
    after_[before_[i]] = after_[i];
    before_[after_[i]] = before_[i];
    gone_[i] = true;
}

void FaceCutter::collectReflex() {
    reflex_.clear();
    for (uint32_t i = 0; i < points.size(); ++i)
        if (!gone_[i] && !(turnAt(i) > 0)) reflex_.push_back(i);
}

bool FaceCutter::askAll() {
    collectReflex();
    bool any = false;
    for (uint32_t i = 0; i < points.size(); ++i) any |= ear_[i] = !gone_[i] && isEar(i);
    return any;
}

// Only the two neighbours of a cut corner can become ears or stop being reflex. In degenerate outlines other corners can too, so all are
// tested again before giving up, a few times.
FaceCutter::Outcome FaceCutter::clipEars() {
    const uint32_t n = uint32_t(points.size());
    before_.resize(n);
    after_.resize(n);
    gone_.assign(n, false);
    ear_.resize(n);
    for (uint32_t i = 0; i < n; ++i) before_[i] = i ? i - 1 : n - 1, after_[i] = i + 1 < n ? i + 1 : 0;
    tests_ = 0;
    askAll();
    uint32_t left = n, at = 0, sinceCut = 0, asked = 0;
    while (left > 3) {
        if (tests_ > kMaxCornerTests) return Outcome::tooLarge;
        if (ear_[at]) {
            const uint32_t a = before_[at], c = after_[at];
            cutOff(at);
            ear_[at] = false;
            --left;
            if (left % 64 == 0) collectReflex();
            ear_[a] = isEar(a);
            ear_[c] = isEar(c);
            at = c;  // not the corner just before, so that fans stay narrow
            sinceCut = 0;
            continue;
        }
        at = after_[at];
        if (++sinceCut <= left) continue;
        sinceCut = 0;
        if (++asked > 16) return fallBack(at, left);
        if (askAll()) continue;
        // No ear: cut a corner without area (a spike, or points in a line), else the outline crosses itself.
        uint32_t straight = at;
        for (uint32_t k = 0; k < left && turnAt(straight) != 0; ++k) straight = after_[straight];
        if (turnAt(straight) != 0) return fallBack(at, left);
        at = after_[straight];
        cutOff(straight);
        --left;
        ear_[straight] = false;
        askAll();
    }
    const bool folded = turnAt(at) < 0;
    cutOff(at);
    return folded ? Outcome::selfCrossing : Outcome::done;
}

FaceCutter::Outcome FaceCutter::fallBack(uint32_t at, uint32_t left) {
    // A remaining outline in one line has no area and crosses nothing.
    bool straight = true;
    for (uint32_t k = 0, i = at; k < left; ++k, i = after_[i]) straight &= turnAt(i) == 0;
    for (uint32_t i = after_[at]; left > 2; --left) {
        const uint32_t following = after_[i];
        cuts.push_back({at, i, following});
        i = following;
    }
    return straight ? Outcome::done : Outcome::selfCrossing;
}

}  // namespace plumb
