// SPDX-License-Identifier: MIT
// Floating point environment of the twin, the composites and the readers, which compute in IEEE arithmetic: round to nearest, subnormals
// kept. A library linked with -ffast-math sets flush-to-zero for the whole thread that loads it (docs/accuracy.md); a host program may have
// set another rounding.
#pragma once

#include <cfenv>

namespace plumb {

// Sets the default floating point environment for its lifetime and restores the old one. Threads started meanwhile inherit it.
class PlainFloats {
public:
    PlainFloats() {
        std::fegetenv(&found_);
        std::fesetenv(FE_DFL_ENV);
    }
    ~PlainFloats() { std::fesetenv(&found_); }
    PlainFloats(const PlainFloats&) = delete;
    PlainFloats& operator=(const PlainFloats&) = delete;

private:
    std::fenv_t found_{};
};

}  // namespace plumb
