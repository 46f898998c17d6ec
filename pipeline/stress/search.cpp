// SPDX-License-Identifier: MIT
#include "pipeline/stress/search.h"

#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace plumb::stress {
namespace {

// Powers of two that are tried one by one; further ones are this far apart.
constexpr int kEachPower = 16, kStride = 4;
constexpr int kMostPowers = 256;
// Bisection ends where both sides agree to this factor: two digits of a margin, or of where nothing can be told.
constexpr double kMarginFactor = 1.02, kEndFactor = 1.2;
// Factors beyond a margin at which the picture must stay beyond.
constexpr double kConfirming[] = {2, 4};

// Least words of a refusal's own sentence. What stands before it says where: file, line, object.
constexpr int kLeastWords = 5;

// "a.toml:9:1: object 'x': it reaches further than that: move it" without the location and the advice.
std::string sentenceOf(const std::string& refusal) {
    for (size_t at = 0; at < refusal.size();) {
        const size_t end = std::min(refusal.find(": ", at), refusal.size());
        std::string part = refusal.substr(at, end - at);
        if (std::count(part.begin(), part.end(), ' ') + 1 >= kLeastWords) return part;
        at = end + 2;
    }
    return refusal;
}

// No time is left.
struct Late {};

class Sweep {
public:
    Sweep(Evaluator& evaluator, const Picture& picture, const AxisRow& axis, bool float32, const std::function<void(double)>& onStep)
        : evaluator_(evaluator),
          picture_(picture),
          axis_(axis),
          float32_(float32),
          onStep_(onStep),
          from_(axis.from(picture)),
          present_(axis.present(picture)),
          reach_(axis.reach(picture)) {}

    Margin run() {
        try {
            if (evaluator_.itself(float32_).outcome == Outcome::beyond)
                recover();
            else
                outward();
        } catch (const Late&) {
            out_.end = End::cut;
        }
        return std::move(out_);
    }

private:
    bool isHarder(double a, double b) const { return axis_.rises ? a > b : a < b; }
    double harderOf(double a, double b) const { return isHarder(a, b) ? a : b; }
    // The value `factor` times harder, and no harder than the axis reaches.
    double harder(double value, double factor) const {
        double moved = axis_.rises ? value * factor : value / factor;
        if (axis_.whole) moved = axis_.rises ? std::ceil(moved) : std::floor(moved);
        return isHarder(moved, reach_.value) ? reach_.value : moved;
    }

    const Tried& at(double value) {
        if (evaluator_.late()) throw Late{};
        onStep_(std::min(1.0, std::abs(std::log2(value / from_)) / std::max(1.0, std::abs(std::log2(reach_.value / from_)))));
        const Tried& tried = evaluator_.at(axis_, value, float32_);
        const auto same = [value](const Tried& t) { return t.value == value; };
        if (std::none_of(out_.tried.begin(), out_.tried.end(), same)) out_.tried.push_back(tried);
        return tried;
    }

    // A value between two others, none where they are as near to each other as `factor` asks.
    std::optional<double> between(double mild, double hard, double factor) const {
        const double low = std::min(mild, hard), high = std::max(mild, hard);
        if (axis_.whole) return high - low > 1 ? std::optional(std::floor((low + high) / 2)) : std::nullopt;
        if (low > 0) return high / low > factor ? std::optional(std::sqrt(low * high)) : std::nullopt;
        return high > from_ * 0x1p-20 ? std::optional(high / 2) : std::nullopt;
    }

    struct Sides {
        double within, past;
        Outcome outcome;  // of `past`
    };
    Sides bisect(Sides s) {
        while (const auto middle = between(s.within, s.past, s.outcome == Outcome::beyond ? kMarginFactor : kEndFactor)) {
            const Tried& tried = at(*middle);
            if (tried.outcome == Outcome::within)
                s.within = *middle;
            else
                s.past = *middle, s.outcome = tried.outcome;
        }
        return s;
    }

    // From the scene as it is to where the error passes the budget for good.
    void outward() {
        double within = present_.value_or(from_);
        for (;;) {
            const std::optional<Sides> end = firstNotWithin(within);
            if (!end) return hold(reach_.value, reach_.why);
            const Sides sides = bisect(*end);
            if (sides.outcome != Outcome::beyond) return hold(sides.within, reasonAt(sides.past));
            const std::optional<double> recovered = recoveredBeyond(sides.within);
            if (!recovered) return settle(sides);
            out_.islands.push_back(sides.past);
            within = *recovered;
        }
    }

    // The first value from `within` on, by powers of two, that is not within; none as far as the axis reaches.
    std::optional<Sides> firstNotWithin(double within) {
        for (int k = 1; k <= kMostPowers; k += k < kEachPower ? 1 : kStride) {
            const double value = harder(from_, std::exp2(k));
            if (!isHarder(value, within)) {
                if (value == reach_.value) break;
                continue;
            }
            const Tried& tried = at(value);
            if (tried.outcome != Outcome::within) return Sides{within, value, tried.outcome};
            within = value;
            if (value == reach_.value) break;
        }
        return std::nullopt;
    }

    // The hardest of the confirming values that keeps the budget; none where the error stays beyond.
    std::optional<double> recoveredBeyond(double margin) {
        std::optional<double> recovered;
        for (double factor : kConfirming) {
            const double value = harder(margin, factor);
            if (isHarder(value, margin) && at(value).outcome == Outcome::within) recovered = value;
        }
        return recovered;
    }

    // Takes a margin, after the value at half of it kept the budget, too.
    void settle(Sides sides) {
        for (;;) {
            const double half = axis_.rises ? sides.within / 2 : sides.within * 2;
            const double value = axis_.whole ? (axis_.rises ? std::floor(half) : std::ceil(half)) : half;
            if (present_ ? !isHarder(value, *present_) : !isHarder(value, from_)) break;
            if (at(value).outcome != Outcome::beyond) break;
            // An island below the margin: what counts is its mild side.
            double mild = present_.value_or(from_);
            for (const Tried& tried : out_.tried)
                if (tried.outcome == Outcome::within && isHarder(value, tried.value)) mild = harderOf(mild, tried.value);
            sides = bisect({mild, value, Outcome::beyond});
            if (sides.outcome != Outcome::beyond) return hold(sides.within, reasonAt(sides.past));
        }
        out_.end = End::breaks;
        out_.margin = sides.within;
        out_.beyond = sides.past;
        std::erase_if(out_.islands, [&](double island) { return !isHarder(out_.margin, island); });
    }

    void hold(double margin, const std::string& why) {
        out_.end = End::holds;
        out_.margin = margin;
        out_.why = why;
    }

    std::string reasonAt(double value) {
        const Tried& tried = at(value);
        if (tried.outcome == Outcome::few)
            return tried.figures.pixels == 0 ? "then nothing is seen" : fmt::format("then only {} pixels are seen", tried.figures.pixels);
        if (tried.outcome == Outcome::open) return "then the truth's own bound leaves too much open";
        return fmt::format("then refused: {}", printable(sentenceOf(tried.why)));
    }

    // From the scene as it is, which is beyond, to the mild side.
    void recover() {
        out_.end = End::other;
        const std::optional<double> milder = axis_.mildest == nullptr || !present_ ? std::nullopt : std::optional(axis_.mildest(picture_));
        if (!milder || !isHarder(*present_, *milder)) {
            out_.why = "nothing milder can be drawn";
            return;
        }
        const double mildest = *milder;
        out_.why = fmt::format("at {:.3g} it is beyond, too", mildest);
        if (at(mildest).outcome != Outcome::within) return;
        out_.why.clear();
        double beyond = *present_, value = beyond;
        for (int k = 1; k <= kMostPowers; ++k) {
            value = axis_.rises ? *present_ * std::exp2(-k) : *present_ * std::exp2(k);
            if (axis_.whole) value = axis_.rises ? std::floor(value) : std::ceil(value);
            if (!isHarder(value, mildest)) value = mildest;
            if (value == mildest || at(value).outcome == Outcome::within) break;
            beyond = value;
        }
        const Sides sides = bisect({value, beyond, Outcome::beyond});
        out_.end = End::passed;
        out_.margin = sides.within;
        out_.beyond = sides.past;
    }

    Evaluator& evaluator_;
    const Picture& picture_;
    const AxisRow& axis_;
    const bool float32_;
    const std::function<void(double)>& onStep_;
    const double from_;
    const std::optional<double> present_;
    const Reach reach_;
    Margin out_;
};

}  // namespace

Margin sweep(Evaluator& evaluator, const Picture& picture, const AxisRow& axis, bool float32, const std::function<void(double)>& onStep) {
    return Sweep(evaluator, picture, axis, float32, onStep).run();
}

}  // namespace plumb::stress
